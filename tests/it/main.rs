//! Tests of the library through its public face.

mod bus_bytes;
mod cli;
mod closed_form;
mod determinism;
mod diff;
mod explain;
mod gltf;
mod golden;
mod gpu;
mod hostile;
mod house;
mod laws;
mod layering;
mod mass;
mod model_contracts;
mod raster;
mod report;
mod scene;
mod selftest;
mod shards;
mod shrinking;
mod simplify_props;
mod support;
mod threads;
mod traces;
mod walks;
