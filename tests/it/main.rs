//! Tests of the library through its public face.

mod bus_bytes;
mod closed_form;
mod determinism;
mod gltf;
mod gpu;
mod laws;
mod house;
mod layering;
mod mass;
mod model_contracts;
mod raster;
mod report;
mod scene;
mod simplify_props;
mod support;
mod walks;
