//! Trees at any level of detail on a GPU that exists only in software: every byte that crosses its
//! bus is counted, every pixel is the same on every machine.
//!
//! ```text
//!  scenes/*.toml                                                               golden/, report
//!       │                                                                           ▲
//!       ▼                                                                           │
//!    scene ──▶ plant ──▶ simplify ──▶ models ═══Queue═══▶ gpu ──▶ raster ──▶ frame + ledger
//!    what is   leaves,   collapse     what is             buffers, bus,  coverage,
//!    asked     branches  sequences    resident, what      passes,        depth,
//!    for                 (offline)    changes per frame   ledger         shading
//!       └─────────────────────────── run: the frame loop ──────────────────┘
//! ```
//!
//! Two wings meet only in [`models`]: [`gpu`] and [`raster`] have never heard of a tree, [`plant`]
//! and [`simplify`] never of a device.
//!
//! # What is promised
//!
//! The same scene and the same version give the same image bytes, the same ledger, and the same
//! plants and models, for any number of threads, in debug and release builds, on any processor and
//! instruction set. Not promised: how long it takes, and what is printed by the way.
//!
//! # The stages, in the order of the data
//!
//! [`scene`], [`plant`], [`simplify`], [`models`], [`gpu`], [`raster`], [`run`], [`report`],
//! [`golden`], [`explain`], and [`cli`], the only one that prints. [`math`], [`document`] and
//! [`limits`] serve all; [`testkit`] tests models, ours and others'.

pub mod cli;
pub mod document;
pub mod explain;
pub mod golden;
pub mod gpu;
pub mod limits;
pub mod math;
pub mod models;
pub mod plant;
pub mod raster;
pub mod report;
pub mod run;
pub mod scene;
pub mod simplify;
pub mod testkit;

#[doc = include_str!("references.md")]
pub mod references {}
