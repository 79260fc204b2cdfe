//! Offline simplification: a plant in, a sequence of reversible steps out; pure functions.
//!
//! ```text
//! Plant.foliage ─collapse_leaves─▶ CollapseSequence ─Clusters::of─▶ Clusters
//!   quad leaves ─prune_leaves────▶   old1, old2 → new                 arrays in consumption order
//!                                        │
//!                                        ├─measure_leaves──▶ area, folds of a level
//!                                        └─Accounting──────▶ bytes, beside what the papers print
//! Plant.trunk ──collapse_vertices──▶ VertexCollapses ─┬─ mesh_after(level)
//!   triangle mesh                      u → v          └─ strips_of ─▶ Strips
//!              └─simplify_mesh──▶ SimplifiedMesh (both) ─parts─▶ kept elsewhere ─restored─▶ checked
//! Plant.foliage ─leaf_sites─▶ LeafSite ─cluster_planes─▶ PlaneClusters ─▶ PlaneHierarchy
//!   all with triangles          centre, normal             planes, leaf → plane    levels
//! Plant.skeleton ──▶ BranchSequence ─at(ε)─▶ BranchLevel
//!   and needles        errors of all merges    polygons, lines, how far they may be off
//! Plant ─strokes::*─▶ StrokeLevels, BranchStrokes: what painted trees are made of
//! ```
//!
//! **Invariant.** A [`CollapseSequence`] is a forest of binary trees over the leaves: every leaf is
//! consumed at most once, only after it exists, and every new leaf uses vertices of its own
//! originals with their corner roles kept, or brings four of its own. A [`VertexCollapses`] moves vertices to vertices with higher
//! numbers, so that what is gone is always a first part of them all.

mod branches;
mod clusters;
mod leaves;
mod measure;
mod mesh;
mod planes;
mod pruning;
mod published;
mod sequence;
mod storage;
pub mod strokes;

pub use branches::{
    Attachment, BranchAxis, BranchErrors, BranchLevel, BranchMesh, BranchOptions, BranchRelevance,
    BranchRoutes, BranchSequence, BranchSkeleton, BranchVertex, Caps, EdgeTable, Edges, ErrorStep,
    Frame, FrameMethod, Internode, LEAST_EDGES, LevelBound, LevelNodes, LineAlpha, LineNormals,
    MOST_EDGES, Merge, MergeTable, Needle, NeedleOptions, NeedleRadius, NeedleSequence, NeedleUnit,
    PolygonOptions, PrimitiveCounts, RouteChange, Shares, Side, SkeletalVector, TopologyOrder,
    WHOLE_MERGES, fractional_edges, merge_deviation, moving_frames, permitted_error, radial, sides,
    upright_frame,
};
pub use clusters::{Cluster, Clusters, Record, literal_visible};
pub use leaves::{LEAF_COLLAPSE_VERSION, LeafCollapseOptions, LeafDistance, collapse_leaves};
pub use measure::{LeafMeasure, is_folded, leaf_area, measure_leaves};
pub use mesh::{
    EDGE_WEIGHT, LAST_TRIANGLES, LEAST_COSINE, SimplifiedMesh, SimplifiedParts, Strips,
    VERTEX_COLLAPSE_VERSION, VertexCollapse, VertexCollapseOptions, VertexCollapses,
    collapse_vertices, lowest_first, simplify_mesh, strips_of,
};
pub use planes::{
    LeafSite, Plane, PlaneClusters, PlaneHierarchy, PlaneLevel, PlaneOptions, PlaneSolver,
    cluster_planes, flattened, leaf_sites, leaves_of_cluster,
};
pub use pruning::{PruningOptions, hand_on_areas, prune_leaves};
pub use published::{Erratum, PUBLISHED_ROWS, PublishedCell, PublishedRow};
#[cfg(test)]
pub(crate) use sequence::examples;
pub use sequence::{Collapse, CollapseSequence, SequenceError};
pub use storage::{
    Accounting, PRINTED_LODF_BYTES, PRINTED_LODF_HARDWARE_BYTES, StorageCounts, mebibyte_hundredths,
};
