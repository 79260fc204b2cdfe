//! Criteria: which clusters deserve leaves.

use super::super::{Crown, State};
use super::{Apportionment, Sight, apportion};
use crate::math::{Aabb, Vec3, index_u32};

/// A criterion: how much of a budget of leaves a cluster deserves.
///
/// Implement it for a criterion of your own:
///
/// ```
/// use spinney::models::{ClusterFacts, Importance, Sight};
///
/// /// The lower half of a crown stands behind a wall.
/// #[derive(Debug)]
/// struct AboveTheWall;
///
/// impl Importance for AboveTheWall {
///     fn weight(&self, cluster: &ClusterFacts<'_>, _: &Sight) -> f64 {
///         let above = cluster.center().y > cluster.crown().center().y;
///         f64::from(cluster.leaf_count()) * if above { 1.0 } else { 0.1 }
///     }
/// }
/// # use std::sync::Arc;
/// # use spinney::math::Vec3;
/// # use spinney::models::{Crown, Placement, State, spread};
/// # use spinney::plant::{Foliage, LeafGroup, Material, NO_BRANCH, Plant, Prototype};
/// # use spinney::scene::{Camera, CameraKey, ImageSize, Projection};
/// # use spinney::simplify::{Collapse, CollapseSequence};
/// # let leaf = |y: f32| {
/// #     [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(u, v)| Vec3::new(u, y + v, 0.0))
/// # };
/// # let group = LeafGroup {
/// #     name: "leaves".to_owned(),
/// #     prototype: Prototype::Quad { texture_corners: Prototype::WHOLE_IMAGE },
/// #     material: Material::plain("leaf", [0.1, 0.4, 0.1]),
/// #     owners: vec![NO_BRANCH; 4],
/// #     positions: [0.0, 0.2, 5.0, 5.2].map(leaf).concat(),
/// # };
/// # let plant = Plant::new("four", None, None, Foliage { groups: vec![group] }).expect("sound");
/// # let mut corners: Vec<[u32; 4]> = (0..4).map(|l| [0, 1, 2, 3].map(|role| 4 * l + role)).collect();
/// # corners.extend([[0, 1, 2, 3], [8, 9, 10, 11]]);
/// # let collapses = [[0, 1], [2, 3]].map(|old| Collapse { old, cost: 0.0 }).to_vec();
/// # let sequence = CollapseSequence::new(4, corners, collapses).expect("sound");
/// # let crown = Crown::new(Arc::new(plant), sequence);
/// # let key = CameraKey { frame: 0, eye: Vec3::new(0.0, 1.0, 9.0), target: Vec3::ZERO };
/// # let projection = Projection::Perspective { vertical_field_of_view: 40.0 };
/// # let camera = Camera::new(projection, 0.1, 100.0, vec![key]).expect("sound");
/// # let view = camera.at(0, ImageSize::new(64, 64).expect("small"));
/// let sight = Sight::of(&view, &Placement::IDENTITY);
/// // Two clusters of two leaves, one below, one above; three leaves may show.
/// let state = spread(&crown, 3, &AboveTheWall, &sight);
/// assert_eq!(state, State::Variable { counts: vec![1, 0] });
/// ```
pub trait Importance: std::fmt::Debug {
    /// The weight of a cluster as it is seen, 0 or more, on any scale.
    ///
    /// Leaves are dealt out in proportion, so a weight that is to mean "twice as dense" must be twice
    /// as large for each leaf that there is.
    fn weight(&self, cluster: &ClusterFacts<'_>, sight: &Sight) -> f64;
}

/// A cluster, as criteria see it.
#[derive(Debug, Clone, Copy)]
pub struct ClusterFacts<'c> {
    crown: &'c Crown,
    number: u32,
}

impl<'c> ClusterFacts<'c> {
    /// The crown that it is part of.
    #[must_use]
    pub fn crown(&self) -> &'c Crown {
        self.crown
    }

    /// Its number.
    #[must_use]
    pub fn number(&self) -> u32 {
        self.number
    }

    /// How many original leaves it has (`m`).
    #[must_use]
    pub fn leaf_count(&self) -> u32 {
        self.crown.clusters().clusters[self.number as usize].original_count()
    }

    /// The box of its leaves, in the plant's space.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.crown.cluster_bounds()[self.number as usize]
    }

    /// The middle of its box.
    #[must_use]
    pub fn center(&self) -> Vec3 {
        self.crown.cluster_centers()[self.number as usize]
    }

    /// Its error in metres after every number of collapses, from none to all; ascending.
    #[must_use]
    pub fn errors(&self) -> &'c [f32] {
        self.crown.errors().curve(self.number)
    }
}

/// Near clusters deserve more: the law of `D_MIN` and `D_MAX` ([RRCGR](crate::references),
/// Algorithm 4), not rounded to whole leaves. All leaves count up to `nearest`, one from `farthest` on,
/// linearly between.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ByDistance {
    /// Metres of the plant, to the cluster's centre.
    pub nearest: f32,
    /// Metres of the plant.
    pub farthest: f32,
}

impl ByDistance {
    /// Between the nearest and the farthest cluster of a crown: the same contrast from everywhere.
    #[must_use]
    pub fn across(crown: &Crown, eye: Vec3) -> Self {
        let distances = crown.cluster_centers().iter().map(|c| eye.distance(*c));
        let begin = (f32::INFINITY, f32::NEG_INFINITY);
        let (nearest, farthest) =
            distances.fold(begin, |(least, most), d| (least.min(d), most.max(d)));
        Self { nearest, farthest }
    }
}

impl Importance for ByDistance {
    fn weight(&self, cluster: &ClusterFacts<'_>, sight: &Sight) -> f64 {
        let distance = sight.eye().distance(cluster.center());
        let [distance, nearest, farthest] = [distance, self.nearest, self.farthest].map(f64::from);
        let share = if farthest > nearest {
            ((distance - nearest) / (farthest - nearest)).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let leaves = f64::from(cluster.leaf_count());
        leaves - share * (leaves - 1.0)
    }
}

/// Clusters deserve more that would look wrong without leaves: leaves times the pixels, at the
/// nearest point, of the error of the last one left.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ByScreenError;

impl Importance for ByScreenError {
    fn weight(&self, cluster: &ClusterFacts<'_>, sight: &Sight) -> f64 {
        let error = cluster.errors().last().copied().unwrap_or(0.0);
        let pixels = f64::from(error) * sight.pixels_per_metre_at(&cluster.bounds());
        f64::from(cluster.leaf_count()) * pixels
    }
}

/// Clusters on the crown's outline deserve more.
///
/// The crown is taken for the ellipsoid in its box, in the space of which it is a ball; there the
/// distance of a cluster from the line of sight through the middle is 0 in front and behind, and 1
/// where the surface is seen edge-on: its square counts, in front a tenth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BySilhouette;

impl Importance for BySilhouette {
    fn weight(&self, cluster: &ClusterFacts<'_>, sight: &Sight) -> f64 {
        let crown = cluster.crown().bounds();
        // Flat foliage has its outline within its plane.
        let half = (0.5 * crown.size()).max(Vec3::splat(1e-6));
        let in_ball = |point: Vec3| ((point - crown.center()) / half).as_dvec3();
        let line = in_ball(sight.eye()).normalize_or_zero();
        let rim = line.cross(in_ball(cluster.center())).length().min(1.0);
        f64::from(cluster.leaf_count()) * (0.1 + 0.9 * (rim * rim))
    }
}

/// The weights of all clusters of a crown.
#[must_use]
pub fn weights(crown: &Crown, importance: &dyn Importance, sight: &Sight) -> Vec<f64> {
    let numbers = 0..index_u32(crown.clusters().clusters.len());
    let facts = numbers.map(|number| ClusterFacts { crown, number });
    facts
        .map(|facts| importance.weight(&facts, sight))
        .collect()
}

/// The variable state that shows exactly `leaves`, or as many as there are, or one a cluster, spread
/// as a criterion says.
#[must_use]
pub fn spread(crown: &Crown, leaves: u32, importance: &dyn Importance, sight: &Sight) -> State {
    let clusters = crown.clusters().clusters.iter();
    let sizes: Vec<u32> = clusters.map(|cluster| cluster.original_count()).collect();
    let weights = weights(crown, importance, sight);
    let shown = apportion(leaves, &sizes, &weights, Apportionment::Divisor);
    let counts = sizes.iter().zip(shown).map(|(size, shown)| size - shown);
    State::Variable {
        counts: counts.collect(),
    }
}
