//! Tests of the library through its public face.

mod layering;
mod raster;
mod scene;
