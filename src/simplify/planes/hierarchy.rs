//! Clusters merged two by two, from all planes down to one.

use super::cluster::{Cloud, PlaneClusters, PlaneSolver};
use super::fit::PlaneSums;
use super::plane::Plane;
use super::site::LeafSite;
use crate::math::index_u32;

/// Every number of planes from that of the clusters down to 1, each level the next finer one with two
/// of its clusters merged.
///
/// [GSS05](crate::references), § 2.4, asks for clusters that are "organized hierarchically" and does not
/// say how. Here each step merges the two clusters whose common plane has the least more error than
/// their two have together, the lowest numbers of equals. What the best plane depends on adds up, so no step
/// looks at leaves; time is cubic in planes.
///
/// ```text
///  K = 4   0   1   2   3
///          │   └─┬─┘   │
///      3   0     1     2       a cluster is numbered by its first one on the finest level,
///          └──┬──┘     │       so that order stays
///      2      0        1
///             └────┬───┘
///      1           0
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlaneHierarchy {
    /// The planes of the finest clusters, then those that merging made.
    planes: Vec<Plane>,
    /// The two that became plane `K + step`, the one with the lower first cluster first.
    merges: Vec<[u32; 2]>,
    /// The error that each merging adds, in square metres.
    gains: Vec<f64>,
    /// The finest cluster of each site.
    cluster_of_site: Vec<u32>,
}

/// The clusters at one number of planes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlaneLevel {
    /// The planes.
    pub planes: Vec<Plane>,
    /// The plane of each site.
    pub cluster_of_site: Vec<u32>,
}

impl From<PlaneClusters> for PlaneLevel {
    fn from(clusters: PlaneClusters) -> Self {
        Self {
            planes: clusters.planes,
            cluster_of_site: clusters.cluster_of_site,
        }
    }
}

impl PlaneHierarchy {
    /// Merges clusters of these sites down to one. `orientation_weight` is that of
    /// [`PlaneOptions`](super::PlaneOptions), as the clusters were made with.
    #[must_use]
    pub fn of(sites: &[LeafSite], clusters: &PlaneClusters, orientation_weight: f32) -> Self {
        let cloud = Cloud::new(sites, orientation_weight);
        let mut sums = vec![PlaneSums::default(); clusters.planes.len()];
        for (site, &cluster) in clusters.cluster_of_site.iter().enumerate() {
            sums[cluster as usize].add(cloud.point(site), cloud.normal(site));
        }
        let mut merging = Merging::new(&cloud, &clusters.planes, sums);
        while merging.step() {}
        Self {
            planes: merging.planes,
            merges: merging.merges,
            gains: merging.gains,
            cluster_of_site: clusters.cluster_of_site.clone(),
        }
    }

    /// How many planes the finest level has.
    #[must_use]
    pub fn count(&self) -> u32 {
        index_u32(self.planes.len() - self.merges.len())
    }

    /// The error that each merging adds, in square metres, from the finest level on.
    #[must_use]
    pub fn gains(&self) -> &[f64] {
        &self.gains
    }

    /// The level of so many planes, or the nearest that there is.
    #[must_use]
    pub fn level(&self, count: u32) -> PlaneLevel {
        let live = self.live(count);
        let cluster_of_finest = self.numbers(&live);
        PlaneLevel {
            planes: live
                .iter()
                .map(|&node| self.planes[node as usize])
                .collect(),
            cluster_of_site: self
                .cluster_of_site
                .iter()
                .map(|&finest| cluster_of_finest[finest as usize])
                .collect(),
        }
    }

    /// The cluster of the level of `count_to` planes that `cluster` of the level of `count_from` planes
    /// has become part of; with as many or more planes, that to which its first finest cluster belongs.
    ///
    /// # Panics
    ///
    /// When `cluster` is not below the number of clusters of its level.
    #[must_use]
    pub fn ancestor(&self, count_from: u32, cluster: u32, count_to: u32) -> u32 {
        let from = self.live(count_from)[cluster as usize];
        self.numbers(&self.live(count_to))[self.first(from) as usize]
    }

    /// What stands at the level of so many planes, by the first finest cluster of each.
    fn live(&self, count: u32) -> Vec<u32> {
        let finest = self.count();
        let steps = finest - count.clamp(finest.min(1), finest);
        // By first finest cluster; what was merged into a lower one is left out.
        let mut node_of_first: Vec<Option<u32>> = (0..finest).map(Some).collect();
        for (step, &[one, other]) in self.merges[..steps as usize].iter().enumerate() {
            node_of_first[self.first(other) as usize] = None;
            node_of_first[self.first(one) as usize] = Some(finest + index_u32(step));
        }
        node_of_first.into_iter().flatten().collect()
    }

    /// The lowest finest cluster of a node.
    fn first(&self, mut node: u32) -> u32 {
        let finest = self.count();
        while node >= finest {
            node = self.merges[(node - finest) as usize][0];
        }
        node
    }

    /// For every finest cluster, its place among the nodes of a level.
    fn numbers(&self, live: &[u32]) -> Vec<u32> {
        let finest = self.count();
        let mut number_of_node = vec![u32::MAX; self.planes.len()];
        for (number, &node) in live.iter().enumerate() {
            number_of_node[node as usize] = index_u32(number);
        }
        // Parents come after children, so one pass from the end hands numbers down.
        for (step, children) in self.merges.iter().enumerate().rev() {
            let number = number_of_node[finest as usize + step];
            if number != u32::MAX {
                for &child in children {
                    number_of_node[child as usize] = number;
                }
            }
        }
        number_of_node.truncate(finest as usize);
        number_of_node
    }
}

/// The work under way.
#[derive(Debug)]
struct Merging<'a> {
    cloud: &'a Cloud,
    planes: Vec<Plane>,
    merges: Vec<[u32; 2]>,
    gains: Vec<f64>,
    /// What stands, by first finest cluster: node, sums, and the error of its plane.
    live: Vec<(u32, PlaneSums, f64)>,
    /// `gain_of[a][b]`, `b < a`: what merging the two at places `a` and `b` adds.
    gain_of: Vec<Vec<f64>>,
}

impl<'a> Merging<'a> {
    fn new(cloud: &'a Cloud, planes: &[Plane], sums: Vec<PlaneSums>) -> Self {
        let mut merging = Self {
            cloud,
            planes: planes.to_vec(),
            merges: Vec::new(),
            gains: Vec::new(),
            live: Vec::new(),
            gain_of: Vec::new(),
        };
        for (node, sums) in sums.into_iter().enumerate() {
            let error = merging.error(&sums);
            let live = (index_u32(node), sums, error);
            let gains = merging.live.iter().map(|other| merging.gain(&live, other));
            merging.gain_of.push(gains.collect());
            merging.live.push(live);
        }
        merging
    }

    /// The least error of a cluster; none of an empty one.
    fn error(&self, sums: &PlaneSums) -> f64 {
        let fit = sums.fit(self.cloud.alpha, PlaneSolver::Jacobi);
        fit.map_or(0.0, |fit| fit.error)
    }

    fn gain(&self, one: &(u32, PlaneSums, f64), other: &(u32, PlaneSums, f64)) -> f64 {
        self.error(&one.1.plus(&other.1)) - one.2 - other.2
    }

    /// Merges the best two; `false` when there are none.
    fn step(&mut self) -> bool {
        let mut best: Option<(usize, usize)> = None;
        for low in 0..self.live.len() {
            for high in low + 1..self.live.len() {
                let gain = self.gain_of[high][low];
                if best.is_none_or(|(low, high)| gain < self.gain_of[high][low]) {
                    best = Some((low, high));
                }
            }
        }
        let Some((low, high)) = best else {
            return false;
        };
        let sums = self.live[low].1.plus(&self.live[high].1);
        let fit = sums.fit(self.cloud.alpha, PlaneSolver::Jacobi);
        // Without a leaf in both, either's plane does.
        let plane = fit.map_or(self.planes[self.live[low].0 as usize], |fit| {
            self.cloud.oriented(&fit.plane)
        });
        self.merges.push([self.live[low].0, self.live[high].0]);
        self.gains.push(self.gain_of[high][low]);
        self.live[low] = (
            index_u32(self.planes.len()),
            sums,
            fit.map_or(0.0, |fit| fit.error),
        );
        self.planes.push(plane);
        self.live.remove(high);
        self.gain_of.remove(high);
        for gains in &mut self.gain_of[high..] {
            gains.remove(high);
        }
        for place in 0..self.live.len() {
            if place != low {
                let gain = self.gain(&self.live[low], &self.live[place]);
                self.gain_of[place.max(low)][place.min(low)] = gain;
            }
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::cluster::{PlaneOptions, cluster_planes};
    use super::*;
    use crate::math::{Stream, Vec3};

    fn sites(count: u32, seed: u64) -> Vec<LeafSite> {
        let mut draws = Stream::new(seed, 0).draws();
        let mut vector = || Vec3::new(draws.signed(), draws.signed(), draws.signed());
        (0..count)
            .map(|_| LeafSite {
                centre: 5.0 * vector(),
                normal: vector().normalize_or_zero(),
            })
            .collect()
    }

    fn hierarchy(sites: &[LeafSite], count: u32) -> (PlaneClusters, PlaneHierarchy) {
        let options = PlaneOptions::to(count);
        let clusters = cluster_planes(sites, &options);
        let hierarchy = PlaneHierarchy::of(sites, &clusters, options.orientation_weight);
        (clusters, hierarchy)
    }

    #[test]
    fn levels_are_nested_and_ancestors_are_theirs() {
        let sites = sites(200, 1);
        let (clusters, hierarchy) = hierarchy(&sites, 13);
        assert_eq!(hierarchy.count(), 13);
        let finest = hierarchy.level(13);
        assert_eq!(finest.planes, clusters.planes);
        assert_eq!(finest.cluster_of_site, clusters.cluster_of_site);
        assert_eq!(hierarchy.level(99), finest);
        assert_eq!(hierarchy.level(0), hierarchy.level(1));
        for count_from in 1..=13 {
            let from = hierarchy.level(count_from);
            assert_eq!(from.planes.len(), count_from as usize);
            for count_to in 1..=count_from {
                let to = hierarchy.level(count_to);
                for (site, &cluster) in from.cluster_of_site.iter().enumerate() {
                    let ancestor = hierarchy.ancestor(count_from, cluster, count_to);
                    assert_eq!(
                        ancestor, to.cluster_of_site[site],
                        "{count_from} to {count_to}"
                    );
                }
                let ancestors: Vec<u32> = (0..count_from)
                    .map(|cluster| hierarchy.ancestor(count_from, cluster, count_to))
                    .collect();
                // Firsts in order: no number appears before a lower one has.
                let mut next = 0;
                for ancestor in ancestors {
                    assert!(ancestor <= next, "{count_from} to {count_to}");
                    next = next.max(ancestor + 1);
                }
                assert_eq!(next, count_to);
            }
        }
    }

    /// The plane of each cluster of a level has the error that its own leaves say, not one a pair
    /// merged first would have less, and all gains add up to the error of one plane.
    #[test]
    fn merging_adds_the_least_error_there_is() {
        let sites = sites(80, 2);
        let (clusters, hierarchy) = hierarchy(&sites, 7);
        let weight = PlaneOptions::to(7).orientation_weight;
        let cloud = Cloud::new(&sites, weight);
        let error_of = |chosen: &dyn Fn(u32) -> bool| {
            let mut sums = PlaneSums::default();
            for (site, &cluster) in clusters.cluster_of_site.iter().enumerate() {
                if chosen(cluster) {
                    sums.add(cloud.point(site), cloud.normal(site));
                }
            }
            let fit = sums.fit(cloud.alpha, PlaneSolver::Jacobi);
            fit.map_or(0.0, |fit| fit.error)
        };
        let gain = |a: u32, b: u32| {
            error_of(&|cluster| cluster == a || cluster == b)
                - error_of(&|cluster| cluster == a)
                - error_of(&|cluster| cluster == b)
        };
        let pairs = (0..7).flat_map(|a| (a + 1..7).map(move |b| (a, b)));
        let least = pairs.map(|(a, b)| gain(a, b)).fold(f64::INFINITY, f64::min);
        assert!((hierarchy.gains()[0] - least).abs() < 1e-9);
        let apart: f64 = (0..7).map(|a| error_of(&|cluster| cluster == a)).sum();
        let gains: f64 = hierarchy.gains().iter().sum();
        assert!((apart + gains - error_of(&|_| true)).abs() < 1e-9);
        assert!(hierarchy.gains().iter().all(|&gain| gain > -1e-9));
    }

    #[test]
    fn equal_pairs_merge_in_the_order_of_their_numbers() {
        // Four floors, each as far above the one before.
        let floor = |y: f32| {
            (0..9_u8).map(move |cell| LeafSite {
                centre: Vec3::new(f32::from(cell % 3), y, f32::from(cell / 3)),
                normal: Vec3::Y,
            })
        };
        let sites: Vec<LeafSite> = [0.0, 0.5, 1.0, 1.5].into_iter().flat_map(floor).collect();
        let clusters = PlaneClusters {
            planes: vec![
                Plane {
                    normal: Vec3::Y,
                    distance: 0.0
                };
                4
            ],
            cluster_of_site: (0..36).map(|site| site / 9).collect(),
            errors: Vec::new(),
        };
        let hierarchy = PlaneHierarchy::of(&sites, &clusters, 0.03);
        let level = hierarchy.level(3);
        assert_eq!(level.cluster_of_site[..10], [0; 10]);
        assert_eq!(level.cluster_of_site[18], 1);
        // Half way between the two floors.
        let between = Vec3::new(0.0, 0.25, 0.0);
        assert!(level.planes[0].signed_distance(between).abs() < 1e-6);
        // Two and two: 0 with 1, 2 with 3.
        assert_eq!(hierarchy.ancestor(4, 3, 2), 1);
        assert_eq!(hierarchy.ancestor(4, 2, 2), 1);
        assert_eq!(hierarchy.ancestor(2, 1, 1), 0);
    }

    #[test]
    fn nothing_and_one_leaf_have_hierarchies_too() {
        let (_, none) = hierarchy(&[], 5);
        assert_eq!(none.count(), 0);
        assert_eq!(none.level(3), PlaneLevel::default());
        let (clusters, one) = hierarchy(&sites(1, 3), 5);
        assert_eq!(one.level(4).planes, clusters.planes);
        assert_eq!(one.ancestor(1, 0, 1), 0);
    }
}
