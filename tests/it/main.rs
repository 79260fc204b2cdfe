//! Tests of the library through its public face.

mod raster;
mod scene;
