//! Trees at any level of detail on a GPU that exists only in software, with every byte counted.
#![warn(missing_docs)]

pub mod document;
pub mod gpu;
pub mod math;
pub mod models;
pub mod plant;
pub mod raster;
pub mod report;
pub mod run;
pub mod scene;
pub mod simplify;

#[doc = include_str!("references.md")]
pub mod references {}
