//! The list of goldens, by suite.
