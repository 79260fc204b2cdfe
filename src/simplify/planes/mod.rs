//! Planes through a crown: groups of leaves that nearly lie in one plane each, and their merging.
//!
//! ```text
//! Foliage ─leaf_sites─▶ centre, normal a leaf ─cluster_planes─▶ PlaneClusters ─PlaneHierarchy::of─▶
//!                                                K planes,        K, K − 1 … 2, 1 planes: levels,
//!                                                leaf → plane     and who is whose ancestor
//! Foliage + PlaneLevel ─flattened─▶ Foliage whose leaves lie in their planes
//! ```
//!
//! [GSS05](crate::references), § 2.1 and 2.2: K-means over leaves with planes for centres. A plane
//! `[n, d]` and a leaf `(nᵢ, pᵢ)` disagree by
//!
//! ```text
//! E = (pᵢ · n + d)² + α (1 − (nᵢ · n)²)                                                eq. (1)
//! ```
//!
//! and the plane with the least sum over `N` leaves goes through their centroid `c`, along the
//! eigenvector of the least eigenvalue of `A = Σ (p − c)(p − c)ᵀ − α Σ n nᵀ` (eqs. 3 to 5); the sum
//! is then `λ + α N`. The paper iterates `A⁻¹`, which finds the eigenvalue of the least *magnitude*:
//! `A` is indefinite, and for flat clusters of aligned leaves that plane stands across all leaves
//! ([`PlaneSolver::Literal`]). Here the eigenvalues of `A + α N I`, whose quadratic form is the sum
//! itself, are found by Jacobi's rotations. `α` has no value in the paper and the unit of a squared
//! length; here it is a [weight](PlaneOptions::orientation_weight) times the crown's mean square radius.
//!
//! **Invariant.** The total error, added in the order of leaves in `f64`, never rises from one step to
//! the next; every leaf is in one cluster; while there are as many leaves as planes, no cluster is
//! empty. No result depends on the number of threads.

mod cluster;
mod eigen;
mod fit;
mod flatten;
mod hierarchy;
mod plane;
mod site;

pub use cluster::{PlaneClusters, PlaneOptions, PlaneSolver, cluster_planes};
pub use flatten::{flattened, leaves_of_cluster};
pub use hierarchy::{PlaneHierarchy, PlaneLevel};
pub use plane::Plane;
pub use site::{LeafSite, leaf_sites};
