//! K-means over leaves, with planes for centres.

use rayon::prelude::*;

use super::fit::PlaneSums;
use super::plane::{FinePlane, Plane};
use super::site::LeafSite;
use crate::math::{DVec3, Draws, Stream, index_u32};

/// How many planes, and how they are found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneOptions {
    /// How many planes (`K`); at least 1 is made of any leaf, and never more than there are leaves.
    pub count: u32,
    /// `α / R²` of eq. (1), with `R` the root of the mean square distance of the leaves from their
    /// centroid: a leaf at a right angle to its plane counts as much as one that is so many square radii
    /// off it. Counts from 10⁻⁶ to 10⁶, NaN as the least.
    pub orientation_weight: f32,
    /// From how many random sets of planes to start; the best end is kept, the earliest of equals.
    /// At least 1.
    pub seeds: u32,
    /// How the plane of a cluster is found.
    pub solver: PlaneSolver,
}

/// How the plane of a cluster is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum PlaneSolver {
    /// The least eigenvalue, by Jacobi's rotations; a plane is kept unless the new one is better.
    Jacobi,
    /// As printed: power iteration with `A⁻¹`, and every plane is replaced by what it finds. Kept to
    /// show what goes wrong.
    Literal,
}

impl PlaneOptions {
    /// So many planes with the constants that measured best.
    #[must_use]
    pub fn to(count: u32) -> Self {
        Self {
            count,
            orientation_weight: 0.03,
            seeds: 4,
            solver: PlaneSolver::Jacobi,
        }
    }
}

/// Leaves in clusters, each with its plane.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PlaneClusters {
    /// The planes; none without leaves, and no more than there are leaves.
    pub planes: Vec<Plane>,
    /// The plane of each site.
    pub cluster_of_site: Vec<u32>,
    /// The sum of eq. (1) over all sites, in square metres: as the leaves are first dealt out, then
    /// after each fitting of planes and each dealing out in turn. The last one counts.
    pub errors: Vec<f64>,
}

/// Deals leaves out to planes and fits planes to their leaves, until neither lowers the error by more than a
/// ten-thousandth.
///
/// It begins with the planes of random leaves, each in its own. A leaf moves only to a plane that is
/// nearer than its own, the lowest number of equals. An empty cluster takes the leaf that is worst off
/// among those that are not alone, the lowest number of equals, and that leaf's own plane.
///
/// Time is linear in leaves, planes and seeds, which run in parallel in rayon's current pool.
#[must_use]
pub fn cluster_planes(sites: &[LeafSite], options: &PlaneOptions) -> PlaneClusters {
    if sites.is_empty() {
        return PlaneClusters::default();
    }
    let cloud = Cloud::new(sites, options.orientation_weight);
    let count = (options.count.max(1) as usize).min(sites.len());
    let run = |seed: u32| {
        let mut draws = Stream::new(u64::from(seed), PLANE_STREAM).draws();
        Clustering::begin(&cloud, count, &mut draws).run(options.solver)
    };
    let ends: Vec<Clustering<'_>> = (0..options.seeds.max(1)).into_par_iter().map(run).collect();
    let best = ends.into_iter().reduce(|best, other| {
        if other.error() < best.error() {
            other
        } else {
            best
        }
    });
    best.map(Clustering::finish).unwrap_or_default()
}

/// The stream of the first planes: "planes" in ASCII.
const PLANE_STREAM: u64 = 0x0070_6c61_6e65_7300;

const LEAST_WEIGHT: f32 = 1e-6;
const MOST_WEIGHT: f32 = 1e6;

/// Rounds of fitting and dealing out, at most; crowns of 10⁴ leaves take some twenty.
const ROUNDS: usize = 200;

/// A round that takes away less than this share of the error is the last one: the hundred that may
/// follow move a few leaves each and take away some thousandths together.
const LEAST_GAIN: f64 = 1e-4;

/// Sites that are dealt out together: what is kept of them stays in the nearest cache.
const BLOCK: usize = 256;

/// The sites as they are computed with: counted from their centroid, axis by axis.
#[derive(Debug)]
pub(super) struct Cloud {
    origin: DVec3,
    /// Places, then normals of unit length or zero.
    axes: [Vec<f64>; 6],
    pub(super) alpha: f64,
}

impl Cloud {
    pub(super) fn new(sites: &[LeafSite], orientation_weight: f32) -> Self {
        let count = sites.len().max(1) as f64;
        let sum = sites
            .iter()
            .fold(DVec3::ZERO, |sum, site| sum + site.centre.as_dvec3());
        let origin = sum / count;
        let mut axes = [const { Vec::new() }; 6];
        let mut squares = 0.0;
        for site in sites {
            let place = site.centre.as_dvec3() - origin;
            // To the last bit of `f64`, so that no leaf is nearer to its own plane than 0.
            let normal = site.normal.as_dvec3().normalize_or_zero();
            squares += place.length_squared();
            let all = place.to_array().into_iter().chain(normal.to_array());
            for (axis, value) in axes.iter_mut().zip(all) {
                axis.push(value);
            }
        }
        let mean_square = squares / count;
        // Leaves all at one place have no radius, and any weight of normals will do.
        let unit = if mean_square > 0.0 { mean_square } else { 1.0 };
        let weight = if orientation_weight > LEAST_WEIGHT {
            f64::from(orientation_weight.min(MOST_WEIGHT))
        } else {
            f64::from(LEAST_WEIGHT)
        };
        Self {
            origin,
            axes,
            alpha: weight * unit,
        }
    }

    fn len(&self) -> usize {
        self.axes[0].len()
    }

    pub(super) fn point(&self, site: usize) -> DVec3 {
        DVec3::new(self.axes[0][site], self.axes[1][site], self.axes[2][site])
    }

    pub(super) fn normal(&self, site: usize) -> DVec3 {
        DVec3::new(self.axes[3][site], self.axes[4][site], self.axes[5][site])
    }

    /// The plane as others see it.
    pub(super) fn oriented(&self, plane: &FinePlane) -> Plane {
        plane.moved(self.origin).oriented()
    }

    /// The plane of one leaf; one without a normal has the plane across x.
    fn own_plane(&self, site: usize) -> FinePlane {
        let normal = self.normal(site);
        let normal = if normal == DVec3::ZERO {
            DVec3::X
        } else {
            normal
        };
        FinePlane::through(self.point(site), normal)
    }

    /// Eq. (1).
    fn error(&self, site: usize, plane: &FinePlane) -> f64 {
        error(
            self.alpha,
            plane,
            [0, 1, 2, 3, 4, 5].map(|axis| self.axes[axis][site]),
        )
    }
}

/// Eq. (1) of a leaf by its place and normal.
///
/// The one formula by which leaves are dealt out and errors added, so that both agree to the bit.
#[inline(always)]
fn error(alpha: f64, plane: &FinePlane, [x, y, z, nx, ny, nz]: [f64; 6]) -> f64 {
    let normal = plane.normal;
    let distance = x * normal.x + y * normal.y + z * normal.z + plane.distance;
    let cosine = nx * normal.x + ny * normal.y + nz * normal.z;
    distance * distance + alpha * (1.0 - cosine * cosine)
}

/// One run from one set of planes.
#[derive(Debug)]
struct Clustering<'a> {
    cloud: &'a Cloud,
    planes: Vec<FinePlane>,
    cluster_of_site: Vec<u32>,
    /// Each site's error from its plane.
    error_of_site: Vec<f64>,
    errors: Vec<f64>,
}

impl<'a> Clustering<'a> {
    /// The planes of `count` random leaves, no leaf twice, and each leaf dealt out to the nearest.
    fn begin(cloud: &'a Cloud, count: usize, draws: &mut Draws) -> Self {
        let mut sites: Vec<usize> = (0..cloud.len()).collect();
        for place in 0..count {
            let left = (cloud.len() - place) as u64;
            sites.swap(place, place + crate::math::index_usize(draws.below(left)));
        }
        let planes = sites[..count].iter().map(|&site| cloud.own_plane(site));
        let mut begun = Self {
            cloud,
            planes: planes.collect(),
            cluster_of_site: vec![0; cloud.len()],
            error_of_site: vec![f64::INFINITY; cloud.len()],
            errors: Vec::new(),
        };
        begun.deal_out();
        begun
    }

    fn run(mut self, solver: PlaneSolver) -> Self {
        for _ in 0..ROUNDS {
            let before = self.error();
            self.fit_planes(solver);
            let is_moved = self.deal_out();
            let is_worth_it = self.error() < (1.0 - LEAST_GAIN) * before;
            if !is_moved || solver == PlaneSolver::Jacobi && !is_worth_it {
                break;
            }
        }
        self.fit_planes(solver);
        self
    }

    fn finish(self) -> PlaneClusters {
        let planes = self.planes.iter().map(|plane| self.cloud.oriented(plane));
        PlaneClusters {
            planes: planes.collect(),
            cluster_of_site: self.cluster_of_site,
            errors: self.errors,
        }
    }

    /// The total so far.
    fn error(&self) -> f64 {
        self.errors.last().copied().unwrap_or(f64::INFINITY)
    }

    /// In the order of sites: of the same sites with no larger errors it is no larger, to the bit.
    fn add_up(&mut self) {
        let total = self
            .error_of_site
            .iter()
            .fold(0.0, |sum, error| sum + error);
        self.errors.push(total);
    }

    /// Step 1 of § 2: every leaf to the plane that is nearest. Whether any moved.
    fn deal_out(&mut self) -> bool {
        let mut is_moved = false;
        let blocks = self
            .cluster_of_site
            .chunks_mut(BLOCK)
            .zip(self.error_of_site.chunks_mut(BLOCK));
        for (number, (clusters, errors)) in blocks.enumerate() {
            is_moved |= deal_out_block(self.cloud, &self.planes, number * BLOCK, clusters, errors);
        }
        is_moved |= self.fill_empty();
        self.add_up();
        is_moved
    }

    /// Gives every empty cluster a leaf. Whether there was one.
    fn fill_empty(&mut self) -> bool {
        let mut sizes = vec![0_u32; self.planes.len()];
        for &cluster in &self.cluster_of_site {
            sizes[cluster as usize] += 1;
        }
        let empty: Vec<usize> = (0..sizes.len())
            .filter(|&cluster| sizes[cluster] == 0)
            .collect();
        for &cluster in &empty {
            let mut worst: Option<usize> = None;
            for site in 0..self.cloud.len() {
                let is_worse =
                    worst.is_none_or(|worst| self.error_of_site[site] > self.error_of_site[worst]);
                if is_worse && sizes[self.cluster_of_site[site] as usize] > 1 {
                    worst = Some(site);
                }
            }
            // There are no more clusters than leaves, so one that is empty leaves two elsewhere.
            let Some(worst) = worst else { continue };
            sizes[self.cluster_of_site[worst] as usize] -= 1;
            sizes[cluster] = 1;
            let of = std::mem::replace(&mut self.cluster_of_site[worst], index_u32(cluster));
            // A leaf's own plane is off it by rounding, and that where it was may be nearer still.
            let own = self.cloud.own_plane(worst);
            let error = self.cloud.error(worst, &own);
            if error < self.error_of_site[worst] {
                self.planes[cluster] = own;
                self.error_of_site[worst] = error;
            } else {
                self.planes[cluster] = self.planes[of as usize];
            }
        }
        !empty.is_empty()
    }

    /// Step 2 of § 2: every plane to its leaves.
    fn fit_planes(&mut self, solver: PlaneSolver) {
        let mut sums = vec![PlaneSums::default(); self.planes.len()];
        for (site, &cluster) in self.cluster_of_site.iter().enumerate() {
            sums[cluster as usize].add(self.cloud.point(site), self.cloud.normal(site));
        }
        let fitted: Vec<FinePlane> = sums
            .iter()
            .zip(&self.planes)
            .map(|(sums, plane)| {
                sums.fit(self.cloud.alpha, solver)
                    .map_or(*plane, |fit| fit.plane)
            })
            .collect();
        let errors: Vec<f64> = self
            .cluster_of_site
            .iter()
            .enumerate()
            .map(|(site, &cluster)| self.cloud.error(site, &fitted[cluster as usize]))
            .collect();
        // By cluster, each in the order of its sites: before, after.
        let mut totals = vec![[0.0_f64; 2]; self.planes.len()];
        for (site, &cluster) in self.cluster_of_site.iter().enumerate() {
            totals[cluster as usize][0] += self.error_of_site[site];
            totals[cluster as usize][1] += errors[site];
        }
        let is_kept = |cluster: usize| {
            let [before, after] = totals[cluster];
            solver == PlaneSolver::Literal || after < before
        };
        // Both rules can differ in the last bit from that over all sites, which then decides.
        let kept = self.cluster_of_site.iter().enumerate();
        let chosen: Vec<f64> = kept
            .map(|(site, &cluster)| {
                if is_kept(cluster as usize) {
                    errors[site]
                } else {
                    self.error_of_site[site]
                }
            })
            .collect();
        let total = chosen.iter().fold(0.0, |sum, error| sum + error);
        if solver == PlaneSolver::Jacobi && total > self.error() {
            self.errors.push(self.error());
            return;
        }
        for (cluster, plane) in fitted.into_iter().enumerate() {
            if is_kept(cluster) {
                self.planes[cluster] = plane;
            }
        }
        self.error_of_site = chosen;
        self.add_up();
    }
}

/// Deals out the sites from `first` on; whether one moved.
fn deal_out_block(
    cloud: &Cloud,
    planes: &[FinePlane],
    first: usize,
    clusters: &mut [u32],
    errors: &mut [f64],
) -> bool {
    let count = clusters.len();
    let axes = [0, 1, 2, 3, 4, 5].map(|axis| &cloud.axes[axis][first..first + count]);
    let mut nearest = [u64::MAX; BLOCK];
    // All as long as each other, so that nothing is checked for each site.
    let (nearest, errors) = (&mut nearest[..count], &mut errors[..count]);
    for (number, plane) in planes.iter().enumerate() {
        for site in 0..count {
            let found = error(cloud.alpha, plane, axes.map(|axis| axis[site]));
            // No branch: several sites at a time.
            let is_nearer = found < errors[site];
            errors[site] = if is_nearer { found } else { errors[site] };
            nearest[site] = if is_nearer {
                number as u64
            } else {
                nearest[site]
            };
        }
    }
    let mut is_moved = false;
    for (cluster, &nearest) in clusters.iter_mut().zip(&*nearest) {
        if let Ok(nearest) = u32::try_from(nearest) {
            is_moved |= *cluster != nearest;
            *cluster = nearest;
        }
    }
    is_moved
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Vec3, index_usize};

    fn site(draws: &mut Draws) -> LeafSite {
        let mut vector = || Vec3::new(draws.signed(), draws.signed(), draws.signed());
        LeafSite {
            centre: 5.0 * vector() + Vec3::new(0.0, 12.0, 0.0),
            normal: vector().normalize_or_zero(),
        }
    }

    /// On a coarse lattice: equal leaves, leaves without normals, and many ties.
    fn lattice_site(draws: &mut Draws) -> LeafSite {
        let mut vector = || Vec3::from_array([0; 3].map(|_| draws.below(3) as f32 - 1.0));
        LeafSite {
            centre: vector(),
            normal: vector().normalize_or_zero(),
        }
    }

    fn options(count: u32, solver: PlaneSolver) -> PlaneOptions {
        PlaneOptions {
            seeds: 2,
            solver,
            ..PlaneOptions::to(count)
        }
    }

    fn rises(clusters: &PlaneClusters) -> bool {
        clusters.errors.windows(2).any(|pair| pair[1] > pair[0])
    }

    #[test]
    fn error_never_rises_and_no_cluster_is_empty() {
        for round in 0..120_u64 {
            let mut draws = Stream::new(8, round).draws();
            let drawn = if round % 2 == 0 { site } else { lattice_site };
            let sites: Vec<LeafSite> = (0..=round * 3).map(|_| drawn(&mut draws)).collect();
            let count = 1 + index_u32(index_usize(draws.below(20)));
            let clusters = cluster_planes(&sites, &options(count, PlaneSolver::Jacobi));
            assert!(!rises(&clusters), "round {round}: {:?}", clusters.errors);
            let planes = (count as usize).min(sites.len());
            assert_eq!(clusters.planes.len(), planes, "round {round}");
            assert_eq!(clusters.cluster_of_site.len(), sites.len());
            for cluster in 0..index_u32(planes) {
                assert!(clusters.cluster_of_site.contains(&cluster), "round {round}");
            }
            for plane in &clusters.planes {
                assert!(plane.distance >= 0.0, "round {round}: {plane:?}");
                assert!((plane.normal.length() - 1.0).abs() < 1e-6, "round {round}");
            }
        }
    }

    #[test]
    fn error_rises_with_the_papers_solver() {
        let risen = (0..20).filter(|&round| {
            let mut draws = Stream::new(9, round).draws();
            let sites: Vec<LeafSite> = (0..60).map(|_| site(&mut draws)).collect();
            let options = PlaneOptions {
                // In the papers' range of "relative importance" nothing forbids one half.
                orientation_weight: 0.5,
                ..options(4, PlaneSolver::Literal)
            };
            rises(&cluster_planes(&sites, &options))
        });
        assert!(risen.count() >= 15);
    }

    #[test]
    fn planes_are_found_where_leaves_lie_in_planes() {
        // Three storeys and a wall.
        let leaf = |x: f32, y: f32, z: f32, normal: Vec3| LeafSite {
            centre: Vec3::new(x, y, z),
            normal,
        };
        let cells = (0..25_u8).map(|cell| (f32::from(cell % 5) - 2.0, f32::from(cell / 5) - 2.0));
        let sites: Vec<LeafSite> = cells
            .flat_map(|(x, z)| {
                let floor = |y: f32| leaf(x, y, z, Vec3::Y);
                [
                    floor(2.0),
                    floor(5.0),
                    floor(8.0),
                    leaf(-6.0, x + 5.0, z, Vec3::X),
                ]
            })
            .collect();
        let clusters = cluster_planes(&sites, &PlaneOptions::to(4));
        assert!(
            clusters
                .errors
                .last()
                .is_some_and(|error| error.abs() < 1e-9),
            "{:?}",
            clusters.errors
        );
        for (site, cluster) in sites.iter().zip(&clusters.cluster_of_site) {
            let plane = clusters.planes[*cluster as usize];
            assert!(plane.signed_distance(site.centre).abs() < 1e-5);
            assert!(plane.normal.dot(site.normal).abs() > 0.999_999);
        }
    }

    #[test]
    fn few_leaves_have_planes_of_their_own() {
        assert_eq!(
            cluster_planes(&[], &PlaneOptions::to(4)),
            PlaneClusters::default()
        );
        let mut draws = Stream::new(10, 0).draws();
        for count in 1..6 {
            let sites: Vec<LeafSite> = (0..count).map(|_| site(&mut draws)).collect();
            let clusters = cluster_planes(&sites, &PlaneOptions::to(9));
            let mut alone = clusters.cluster_of_site.clone();
            alone.sort_unstable();
            assert_eq!(alone, (0..count).collect::<Vec<u32>>());
            assert!(
                clusters
                    .errors
                    .last()
                    .is_some_and(|error| error.abs() < 1e-12)
            );
            let one = cluster_planes(&sites, &PlaneOptions::to(0));
            assert_eq!(one.planes.len(), 1);
        }
    }

    #[test]
    fn the_size_of_a_crown_does_not_matter() {
        let mut draws = Stream::new(11, 0).draws();
        let sites: Vec<LeafSite> = (0..300).map(|_| site(&mut draws)).collect();
        let larger = sites.iter().map(|site| LeafSite {
            centre: 16.0 * site.centre,
            ..*site
        });
        let [one, other] = [sites.clone(), larger.collect()]
            .map(|sites| cluster_planes(&sites, &PlaneOptions::to(6)));
        assert_eq!(one.cluster_of_site, other.cluster_of_site);
        assert_eq!(one.planes[0].normal, other.planes[0].normal);
        assert_eq!(16.0 * one.planes[0].distance, other.planes[0].distance);
    }

    #[test]
    fn threads_do_not_show() {
        let mut draws = Stream::new(12, 0).draws();
        let sites: Vec<LeafSite> = (0..700).map(|_| site(&mut draws)).collect();
        let [one, two, seven] = [1, 2, 7].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let pool = pool.build().expect("few threads");
            pool.install(|| cluster_planes(&sites, &PlaneOptions::to(12)))
        });
        assert_eq!(one, two);
        assert_eq!(one, seven);
    }
}
