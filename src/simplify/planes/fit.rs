//! The plane with the least total error for a cluster, from sums that add up.

use super::cluster::PlaneSolver;
use super::eigen::eigenvectors;
use super::plane::FinePlane;
use crate::math::{DMat3, DVec3};

/// All that the best plane of a cluster depends on. Sums of two clusters add up to those of both, so
/// that clusters merge without looking at their leaves.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct PlaneSums {
    /// `N`, whole.
    pub(super) count: f64,
    /// `Σ p`.
    points: DVec3,
    /// `Σ p pᵀ`: the diagonal, and the entries xy, xz, yz.
    point_squares: [DVec3; 2],
    /// `Σ n nᵀ`, likewise.
    normal_squares: [DVec3; 2],
}

/// A plane and the total error of its cluster as the eigenvalue tells it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit {
    pub(super) plane: FinePlane,
    /// `λ + α N`, in square metres.
    pub(super) error: f64,
}

impl PlaneSums {
    /// Adds a leaf.
    pub(super) fn add(&mut self, point: DVec3, normal: DVec3) {
        self.count += 1.0;
        self.points += point;
        add_square(&mut self.point_squares, point);
        add_square(&mut self.normal_squares, normal);
    }

    /// The sums of both clusters.
    pub(super) fn plus(&self, other: &Self) -> Self {
        let both = |one: [DVec3; 2], other: [DVec3; 2]| [one[0] + other[0], one[1] + other[1]];
        Self {
            count: self.count + other.count,
            points: self.points + other.points,
            point_squares: both(self.point_squares, other.point_squares),
            normal_squares: both(self.normal_squares, other.normal_squares),
        }
    }

    /// The plane of the least total error, by a solver; `None` where the paper's finds nothing, or
    /// without leaves.
    pub(super) fn fit(&self, alpha: f64, solver: PlaneSolver) -> Option<Fit> {
        if self.count == 0.0 {
            return None;
        }
        let form = self.form(alpha);
        let (normal, error) = match solver {
            PlaneSolver::Jacobi => self.least(form),
            PlaneSolver::Literal => {
                let normal =
                    literal_normal(form - DMat3::from_diagonal(DVec3::splat(alpha * self.count)))?;
                (normal, normal.dot(form * normal))
            }
        };
        let centroid = self.points / self.count;
        Some(Fit {
            plane: FinePlane::through(centroid, normal),
            error,
        })
    }

    /// `A + α N I = Σ (p − c)(p − c)ᵀ + α Σ (I − n nᵀ)`: the total error of the plane through the
    /// centroid with normal `n` is `nᵀ (A + α N I) n`, so it has no negative eigenvalue.
    fn form(&self, alpha: f64) -> DMat3 {
        let centroid = self.points / self.count;
        let mut moved = [DVec3::ZERO; 2];
        add_square(&mut moved, centroid);
        let points = [0, 1].map(|half| self.point_squares[half] - self.count * moved[half]);
        let across = [
            DVec3::splat(self.count) - self.normal_squares[0],
            -self.normal_squares[1],
        ];
        symmetric([0, 1].map(|half| points[half] + alpha * across[half]))
    }

    /// The eigenvector of the least eigenvalue, and that.
    ///
    /// Where eigenvalues are as good as equal, the one that most leaves face counts, then the axis that
    /// it began as.
    fn least(&self, form: DMat3) -> (DVec3, f64) {
        const SAME: f64 = 1e-12;
        let (values, vectors) = eigenvectors(form);
        let least = values.min_element();
        let bound = least + SAME * (form.x_axis.x + form.y_axis.y + form.z_axis.z).abs();
        let normals = symmetric(self.normal_squares);
        let faced = |axis: usize| vectors.col(axis).dot(normals * vectors.col(axis));
        let equal = (0..3).filter(|&axis| values[axis] <= bound);
        let best = equal.fold(None, |best, axis| match best {
            Some((_, most)) if faced(axis) <= most + SAME * self.count => best,
            _ => Some((axis, faced(axis))),
        });
        let axis = best.map_or(0, |(axis, _)| axis);
        (vectors.col(axis), values[axis])
    }
}

/// The matrix with a diagonal and the entries xy, xz, yz.
fn symmetric([diagonal, beside]: [DVec3; 2]) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(diagonal.x, beside.x, beside.y),
        DVec3::new(beside.x, diagonal.y, beside.z),
        DVec3::new(beside.y, beside.z, diagonal.z),
    )
}

/// Adds `v vᵀ`.
fn add_square(sum: &mut [DVec3; 2], v: DVec3) {
    sum[0] += v * v;
    sum[1] += DVec3::new(v.x * v.y, v.x * v.z, v.y * v.z);
}

/// The paper's normal ([GSS05](crate::references), § 2.2): `Bⁿ x₀` with `B = A⁻¹`, from one fixed `x₀`,
/// for `n` = 1024.
///
/// `A⁻¹` is taken without its determinant, which changes no direction; where `A` has rank 1, as
/// that of a single leaf has, nothing is left of it and there is no answer.
fn literal_normal(matrix: DMat3) -> Option<DVec3> {
    const SQUARINGS: u32 = 10;
    let mut power = of_size_one(matrix)?;
    power = of_size_one(DMat3::from_cols(
        power.y_axis.cross(power.z_axis),
        power.z_axis.cross(power.x_axis),
        power.x_axis.cross(power.y_axis),
    ))?;
    for _ in 0..SQUARINGS {
        power = of_size_one(power * power)?;
    }
    (power * DVec3::new(1.0, 0.9, 0.8)).try_normalize()
}

/// The matrix with 1 as its largest entry; `None` when all are 0.
fn of_size_one(matrix: DMat3) -> Option<DMat3> {
    let entries = matrix.to_cols_array();
    let size = entries
        .iter()
        .fold(0.0, |most: f64, entry| most.max(entry.abs()));
    (size > 0.0).then(|| matrix * (1.0 / size))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Draws, Stream};

    /// A leaf as ERRATA I1 draws it: flat clusters across z of lateral deviation 1, thickness 0.1,
    /// normals scattered by 0.3.
    fn flat_leaf(draws: &mut Draws) -> (DVec3, DVec3) {
        let mut normal = || f64::from(draws.normal());
        let point = DVec3::new(normal(), normal(), 0.1 * normal());
        let lying = DVec3::new(0.3 * normal(), 0.3 * normal(), 1.0);
        (point, lying.normalize())
    }

    fn sums(leaves: &[(DVec3, DVec3)]) -> PlaneSums {
        let mut sums = PlaneSums::default();
        for &(point, normal) in leaves {
            sums.add(point, normal);
        }
        sums
    }

    fn total(leaves: &[(DVec3, DVec3)], plane: &FinePlane, alpha: f64) -> f64 {
        leaves.iter().fold(0.0, |sum, &(point, normal)| {
            let (distance, cosine) = (plane.signed_distance(point), normal.dot(plane.normal));
            sum + distance * distance + alpha * (1.0 - cosine * cosine)
        })
    }

    #[test]
    fn eigenvalue_tells_the_least_error_and_no_plane_has_less() {
        let mut draws = Stream::new(2, 0).draws();
        for round in 0..300_usize {
            let alpha = [0.0, 0.01, 0.3, 10.0][round % 4];
            let count = 1 + round % 23;
            let leaves: Vec<_> = (0..count)
                .map(|_| {
                    let (point, normal) = flat_leaf(&mut draws);
                    (point + DVec3::new(3.0, -5.0, 2.0), normal)
                })
                .collect();
            let fit = sums(&leaves)
                .fit(alpha, PlaneSolver::Jacobi)
                .expect("there are leaves");
            let error = total(&leaves, &fit.plane, alpha);
            let unit = count as f64 * (alpha + 50.0);
            assert!(
                (fit.error - error).abs() < 1e-14 * unit,
                "{} for {error}",
                fit.error
            );
            for _ in 0..20 {
                let mut near = || 0.1 * f64::from(draws.signed());
                let normal = fit.plane.normal + DVec3::new(near(), near(), near());
                let other = FinePlane {
                    normal: normal.normalize(),
                    distance: fit.plane.distance + near(),
                };
                let other = total(&leaves, &other, alpha);
                assert!(
                    other >= error - 1e-14 * unit,
                    "round {round}: {other} for {error}"
                );
            }
        }
    }

    #[test]
    fn few_leaves_have_their_plane_too() {
        let (n, p) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(1.0, 2.0, 3.0));
        let one = sums(&[(p, n)])
            .fit(0.1, PlaneSolver::Jacobi)
            .expect("a leaf");
        assert!(
            (one.plane.normal.dot(n).abs() - 1.0).abs() < 1e-15,
            "{one:?}"
        );
        assert!(one.error.abs() < 1e-15, "{one:?}");
        // The plane of two leaves side by side, and of two that face each other far apart.
        let beside = sums(&[(p, n), (p + DVec3::Y, n)]);
        let beside = beside.fit(0.1, PlaneSolver::Jacobi).expect("two leaves");
        assert!(
            (beside.plane.normal.dot(n).abs() - 1.0).abs() < 1e-15,
            "{beside:?}"
        );
        let apart = sums(&[(p, n), (p + 10.0 * n, n)]);
        let apart = apart.fit(0.1, PlaneSolver::Jacobi).expect("two leaves");
        assert!(apart.plane.normal.dot(n).abs() < 1e-15, "{apart:?}");
        assert!((apart.error - 0.2).abs() < 1e-13, "{apart:?}");
        // A leaf without a normal has the error of any plane through it; axes decide.
        let none = sums(&[(p, DVec3::ZERO)])
            .fit(0.1, PlaneSolver::Jacobi)
            .expect("a leaf");
        assert_eq!(none.plane.normal, DVec3::X);
        assert_eq!(PlaneSums::default().fit(0.1, PlaneSolver::Jacobi), None);
    }

    #[test]
    fn ties_go_to_the_plane_that_leaves_face() {
        // Four points of a regular tetrahedron: all planes through their middle are as far away.
        let corners = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]];
        let leaf =
            |corner: [i8; 3], normal: DVec3| (DVec3::from_array(corner.map(f64::from)), normal);
        for normal in [DVec3::Y, -DVec3::Y, DVec3::Z] {
            let leaves = corners.map(|corner| leaf(corner, normal));
            let fit = sums(&leaves).fit(0.0, PlaneSolver::Jacobi).expect("leaves");
            assert_eq!(fit.plane.normal, normal.abs());
        }
    }

    #[test]
    fn sums_add_up() {
        let mut draws = Stream::new(3, 0).draws();
        let leaves: Vec<_> = (0..40).map(|_| flat_leaf(&mut draws)).collect();
        let parts = sums(&leaves[..15]).plus(&sums(&leaves[15..]));
        let [parts, whole] =
            [parts, sums(&leaves)].map(|sums| sums.fit(0.02, PlaneSolver::Jacobi).expect("leaves"));
        assert!(
            (parts.error - whole.error).abs() < 1e-12,
            "{parts:?} {whole:?}"
        );
        assert!(parts.plane.normal.dot(whole.plane.normal).abs() > 1.0 - 1e-12);
    }

    /// Cells of ERRATA I1: how often the paper's iteration ends at a plane across the leaves, which has
    /// many times the error, by the number of leaves and `α` in lateral variances.
    #[test]
    fn the_papers_solver_picks_planes_across_the_leaves() {
        const TRIALS: u32 = 400;
        let cells = [
            (2, 0.1, 1.0),
            (5, 0.1, 0.15),
            (5, 1.0, 0.97),
            (20, 0.1, 0.0),
            (20, 1.0, 0.89),
            (350, 1.0, 0.455),
            (350, 0.5, 0.0),
        ];
        for (count, alpha, share) in cells {
            let mut wrong = 0_u32;
            for trial in 0..TRIALS {
                let mut draws = Stream::new(4, u64::from(trial)).child(count).draws();
                let leaves: Vec<_> = (0..count).map(|_| flat_leaf(&mut draws)).collect();
                let sums = sums(&leaves);
                let best = sums.fit(alpha, PlaneSolver::Jacobi).expect("leaves");
                let paper = sums
                    .fit(alpha, PlaneSolver::Literal)
                    .expect("more than one");
                // Eigenvectors of two eigenvalues are at right angles; half way is neither.
                wrong += u32::from(paper.plane.normal.dot(best.plane.normal).abs() < 0.7);
            }
            let found = f64::from(wrong) / f64::from(TRIALS);
            // Four deviations of the difference of two samples of as many trials.
            let deviation = (2.0 * share * (1.0 - share) / f64::from(TRIALS)).sqrt();
            let around = 4.0 * deviation + 0.01;
            assert!(
                (found - share).abs() <= around,
                "{count} leaves, α {alpha}: {found} for {share}"
            );
        }
    }
}
