//! Recorded traces: what a structure did and showed, line by line, checked later by
//! `spinney check-trace`. A program in any language can write one.
//!
//! ```text
//!  your program ──▶ trace.jsonl ──check_trace──▶ TraceReport: which laws, how many times, broken where
//!  our models ──record_model──┘
//! ```
//!
//! # The format, `spinney.trace/1`
//!
//! JSON lines, UTF-8, one object a line; unknown keys are errors. The first line is the header:
//!
//! | key | |
//! |---|---|
//! | `schema` | `"spinney.trace/1"` |
//! | `leaves` | how many leaves there are at full detail; they are numbered from 0 |
//! | `collapses` | two leaves each, in order; collapse `k` (from 0) makes leaf `leaves + k` |
//! | `parts` | which of the parts below every step tells |
//! | `resources` | with any of `writes`, `resident`, `reads`, `fresh`: `name` and size in `bytes` of each, numbered from 0; `"host": true` for what lies in host memory, of which no writes are told |
//!
//! Every further line is a step: one operation, and what is so after it.
//!
//! | operation | |
//! |---|---|
//! | `"level": n` | straight to the level after the first `n` collapses |
//! | `"clusters": [n, …]` | every cluster to its own number of collapses; clusters are the trees of the forest, in the order of their least leaf |
//! | `"collapse": n` | the next `n` collapses, from a level |
//! | `"split": n` | the last `n` collapses undone, from a level |
//!
//! The first step says by `level` or `clusters` where the structure stands at the start.
//!
//! | part | in every step | for the laws |
//! |---|---|---|
//! | `visible` | the leaves that show, in any order | partition, birth before death, monotone detail; split undoes collapse and history independence where a state comes again |
//! | `writes` | what was sent since the last step, a list of transfers, each a list of ranges `{"to": resource, "at": byte, "hex": bytes}`; before the first step memory is zero | conservation, with `resident` or `counted` |
//! | `computed` | beside `writes`, in steps that have any: ranges that the device itself wrote since the last step, before those that were sent; they are no traffic | conservation |
//! | `counted` | what the program itself counted since the last step: `{"transfers": n, "bytes": n}` | conservation, with `writes` |
//! | `resident` | all bytes of each resource, in hexadecimal | conservation, with `writes` |
//! | `reads` | what a draw may read: `[resource, first byte, end]` each | history independence, with `resident` |
//! | `fresh` | as `resident`, what a fresh upload of the state would hold | residency, with `resident` and `reads` |
//! | `image` | any text that is the same for the same picture, such as a digest | image equality, where the same leaves show again |
//!
//! A whole trace: three leaves of which two collapse into leaf 3, in slots of two bytes; a split
//! that writes only one of the two slots back.
//!
//! ```text
#![doc = include_str!("example.jsonl")]
//! ```
//!
//! Its last step breaks laws, and `spinney check-trace` says where:
//!
//! ```
//! use spinney::testkit::Law;
//! use spinney::testkit::trace::check_trace;
//!
//! # let trace = include_str!("example.jsonl");
//! // let trace = the text above
//! let report = check_trace("example.jsonl", trace.as_bytes()).unwrap();
//! let broken: Vec<Law> = report.laws.iter().filter(|law| law.broken > 0).map(|law| law.law).collect();
//! // Leaf 2 shows twice in place of leaf 1: no cut, not what was, and not what a fresh upload holds.
//! assert!(broken.contains(&Law::Partition) && broken.contains(&Law::SplitUndoesCollapse));
//! assert!(broken.contains(&Law::Residency) && !broken.contains(&Law::Conservation));
//! ```

mod check;
mod format;
mod record;

pub use check::{LawReport, TraceReport, check_trace};
pub use format::TracePart;
pub use record::{record_model, record_structure};
