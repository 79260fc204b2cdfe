//! What importing and exporting promise, on files made here.

mod fixture;
mod foreign;
mod hostile;
mod own;
