//! A crown's impostors, all levels of them: which leaves each stands for, where it lies, what it shows.
//!
//! ```text
//! Foliage ─leaf_sites─▶ PlaneHierarchy ─level(32), level(16), …─▶ Impostor, … ─bake─▶ Atlas
//! ```

use super::atlas::Atlas;
use super::bake::{Bake, BakeOptions, BakeSites, BakeView, Rectangle, ViewFrame, bake};
use super::impostors_fit::least_rectangle;
use super::impostors_outline::{Outline, rectangle_outline, trimmed_outline};
use super::triangles::LeafTriangles;
use crate::gpu::{GpuError, Ledger};
use crate::math::{Vec3, index_u32};
use crate::models::Crown;
use crate::scene::{CardOptions, CardOutline, CardSides, Transparency};
use crate::simplify::{
    Plane, PlaneClusters, PlaneHierarchy, PlaneOptions, PlaneSolver, cluster_planes, leaf_sites,
};

/// Alpha from which a texel of a card shows.
///
/// Where a texel is half covered, the leaf's rim runs through its middle: so outlines stay where they
/// are.
pub(super) const CARD_ALPHA_CUTOFF: f32 = 0.5;

/// Pixels along each side of a texel as it is baked: alpha in quarters, so that a rim is found to half
/// a texel between bilinear samples; more costs the square and shows no better.
pub(super) const SUPERSAMPLING: u32 = 2;

/// One impostor.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Impostor {
    /// Its level in the list, 0 the finest.
    pub(super) level: u32,
    /// Its plane.
    pub(super) plane: Plane,
    /// The plane of the impostor of the next level that its leaves belong to; its own at the coarsest.
    pub(super) next: Plane,
    /// Axes in the plane.
    pub(super) frame: ViewFrame,
    /// The rectangle around its leaves.
    pub(super) rectangle: Rectangle,
    /// The leaf sites it stands for, ascending.
    pub(super) sites: Vec<u32>,
}

/// Impostors with their textures.
#[derive(Debug, Clone)]
pub(super) struct ImpostorSet {
    /// Level by level, the finest first.
    pub(super) impostors: Vec<Impostor>,
    /// What is drawn of each.
    pub(super) outlines: Vec<Outline>,
    /// Front of each; or front and back of each in turn.
    pub(super) atlas: Option<Atlas>,
    /// How many levels there are.
    pub(super) levels: u32,
    /// What the bake cost on a device of its own.
    pub(super) ledger: Ledger,
}

impl ImpostorSet {
    /// The impostors of all leaves that have triangles, baked.
    ///
    /// # Errors
    ///
    /// [`GpuError`] where views do not fit the device of the bake, or not one texture together.
    pub(super) fn of(crown: &Crown, options: &CardOptions) -> Result<Self, GpuError> {
        let leaves = LeafTriangles::of(crown.plant().foliage());
        let impostors = planned(crown, &leaves, options);
        let views = views(&impostors, options);
        let supersampling = SUPERSAMPLING;
        let Bake {
            views: baked,
            ledger,
        } = bake(&leaves, &views, BakeOptions { supersampling })?;
        let cutoff = match options.transparency {
            Transparency::Test => CARD_ALPHA_CUTOFF,
            Transparency::Blend | Transparency::Coverage => 0.0,
        };
        let atlas = Atlas::of(&baked, cutoff);
        if atlas.is_none() && !baked.is_empty() {
            let (count, side) = (baked.len(), options.texture);
            let what = format!("{count} views of {side} × {side} texels, which fit no texture");
            return Err(GpuError::Unsupported { what });
        }
        let sides = baked.len() / impostors.len().max(1);
        let outlines = impostors.iter().enumerate();
        let outlines = outlines.map(|(number, impostor)| match options.outline {
            CardOutline::Quad => rectangle_outline(impostor),
            CardOutline::Trimmed => {
                trimmed_outline(impostor, &baked[sides * number..sides * (number + 1)])
            }
        });
        Ok(Self {
            outlines: outlines.collect(),
            levels: index_u32(options.levels.as_slice().len()),
            impostors,
            atlas,
            ledger,
        })
    }
}

/// How many impostors each of so many levels has.
pub(super) fn counts(impostors: &[Impostor], levels: u32) -> Vec<u32> {
    let of_level = |level| impostors.iter().filter(move |one| one.level == level);
    (0..levels)
        .map(|level| index_u32(of_level(level).count()))
        .collect()
}

/// The impostors of every level: K-means makes the finest, merging the others
/// ([GSS05](crate::references), § 2.1, 2.2 and 2.4). Leaves that are known to lie in as many planes as the
/// finest level has stand there.
pub(super) fn planned(
    crown: &Crown,
    leaves: &LeafTriangles,
    options: &CardOptions,
) -> Vec<Impostor> {
    let counts = options.levels.as_slice();
    let weight = options.orientation_weight;
    let Some(&finest) = counts.first() else {
        return Vec::new();
    };
    let sites = leaf_sites(crown.plant().foliage());
    let known = crown.planes().filter(|level| {
        let wanted = sites.len().min(finest as usize);
        level.planes.len() == wanted && level.cluster_of_site.len() == sites.len()
    });
    let clusters = match known {
        Some(level) => PlaneClusters {
            planes: level.planes.clone(),
            cluster_of_site: level.cluster_of_site.clone(),
            errors: Vec::new(),
        },
        None => cluster_planes(
            &sites,
            &PlaneOptions {
                count: finest,
                orientation_weight: weight,
                seeds: options.plane_seeds,
                solver: PlaneSolver::Jacobi,
            },
        ),
    };
    let hierarchy = PlaneHierarchy::of(&sites, &clusters, weight);
    let levels: Vec<_> = counts.iter().map(|&count| hierarchy.level(count)).collect();
    let mut impostors = Vec::new();
    for (number, level) in (0_u32..).zip(&levels) {
        let mut of_cluster = vec![Vec::new(); level.planes.len()];
        for (site, &cluster) in (0..).zip(&level.cluster_of_site) {
            of_cluster[cluster as usize].push(site);
        }
        for (plane, sites) in level.planes.iter().zip(of_cluster) {
            let Some(&first) = sites.first() else {
                continue;
            };
            // All leaves of a cluster have one ancestor.
            let next = levels.get(number as usize + 1).map(|next| {
                let parent = next.cluster_of_site[first as usize];
                next.planes[parent as usize]
            });
            let points: Vec<Vec3> = leaves.corners(sites.iter().copied()).collect();
            let (frame, rectangle) = least_rectangle(*plane, &points);
            impostors.push(Impostor {
                level: number,
                plane: *plane,
                next: next.unwrap_or(*plane),
                frame,
                rectangle,
                sites,
            });
        }
    }
    impostors
}

/// What is baked: front, or front and back, of each in turn.
fn views(impostors: &[Impostor], options: &CardOptions) -> Vec<BakeView> {
    let size = [options.texture; 2];
    let mut views = Vec::new();
    for impostor in impostors {
        let front = BakeView {
            sites: BakeSites::Listed(impostor.sites.clone()),
            frame: impostor.frame,
            rectangle: impostor.rectangle,
            size,
        };
        let back = (options.sides == CardSides::Both).then(|| BakeView {
            frame: front.frame.behind(),
            ..front.clone()
        });
        views.push(front);
        views.extend(back);
    }
    views
}
