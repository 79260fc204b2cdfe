//! Branches as polygons and lines at any error ([ZBMJLDC17](crate::references)).
//!
//! ```text
//!                        once                                        for any error ε
//! Plant.skeleton ─▶ BranchSkeleton ─┬▶ MergeTable     E1, E2 ─▶ fewest primitives ─┐
//!   nodes, radii    P, R, T, N, B   ├▶ TopologyOrder  E4     ─▶ branches that stay ┼─▶ BranchLevel
//!                   52 B a node     └▶ BranchRelevance (baseline)                  │   quads, triangles,
//! Plant.foliage ──▶ Needle ─────────▶ NeedleSequence  E5     ─▶ needles that stay ─┘   lines; a bound
//!                                                     E3     ─▶ edges of each circle
//! ```
//!
//! **Invariant.** A level is never farther from the plant than its [`LevelBound`] says, and a greater
//! error never makes more primitives. What stays keeps its skeletal vectors, so that a device which
//! has them needs nothing else to make any level.
//!
//! Where the paper's formulas leave a gap, halve a circle or exclude the tip, the code that replaces
//! them says so.

mod connection;
mod deviation;
mod edges;
mod frame;
mod internode;
mod merges;
mod mesh;
mod nearest_needles;
mod needles;
mod octree;
mod polygons;
mod relevance;
mod route;
mod routes;
mod sequence;
mod shares;
mod skeletal;
mod step;
mod topology;

pub use connection::{Side, sides};
pub use edges::{EdgeTable, Edges, LEAST_EDGES, MOST_EDGES, fractional_edges};
pub use frame::{Frame, FrameMethod, moving_frames, upright_frame};
pub use internode::{Internode, radial};
pub use merges::{Merge, MergeTable, WHOLE_MERGES, deviation as merge_deviation};
pub use mesh::{BranchMesh, BranchVertex, PrimitiveCounts};
pub use needles::{Needle, NeedleOptions, NeedleRadius, NeedleSequence, NeedleUnit};
pub use polygons::{Caps, LineAlpha, LineNormals, PolygonOptions};
pub use relevance::BranchRelevance;
pub use routes::{BranchRoutes, RouteChange};
pub use sequence::{BranchLevel, BranchOptions, BranchSequence, LevelBound, LevelNodes};
pub use shares::{BranchErrors, Shares, permitted_error};
pub use skeletal::{Attachment, BranchAxis, BranchSkeleton, SkeletalVector};
pub use step::ErrorStep;
pub use topology::TopologyOrder;

#[cfg(test)]
mod tests;
