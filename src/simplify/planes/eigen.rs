//! Eigenvectors of a symmetric 3 × 3 matrix.

use crate::math::{DMat3, DVec3};

/// Sweeps over the three entries off the diagonal; convergence is quadratic, and five reach the last
/// bit of all matrices tried.
const SWEEPS: u32 = 8;

/// The eigenvalues of a symmetric matrix and unit eigenvectors as columns, in the order of the axes that
/// they began as; by Jacobi's rotations in a fixed number of sweeps, so that no input takes longer
/// than others, and with `+ − × ÷ √` alone.
///
/// Of the matrix the upper half is read. Entries are finite, and so small that their squares are.
pub(super) fn eigenvectors(matrix: DMat3) -> (DVec3, DMat3) {
    let mut rows = matrix.transpose().to_cols_array_2d();
    let mut vectors = DMat3::IDENTITY.to_cols_array_2d();
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            rotate(&mut rows, &mut vectors, p, q);
        }
    }
    let values = DVec3::new(rows[0][0], rows[1][1], rows[2][2]);
    (values, DMat3::from_cols_array_2d(&vectors))
}

/// Turns axes `p < q` so that the entry between them vanishes.
fn rotate(rows: &mut [[f64; 3]; 3], vectors: &mut [[f64; 3]; 3], p: usize, q: usize) {
    let between = rows[p][q];
    if between == 0.0 {
        return;
    }
    // The smaller of the two angles that do: tan φ = sign θ / (|θ| + √(θ² + 1)), θ = cot 2φ. A θ
    // beyond all numbers is an angle of 0.
    let cotangent = (rows[q][q] - rows[p][p]) / (2.0 * between);
    let tangent = 1.0 / (cotangent.abs() + (cotangent * cotangent + 1.0).sqrt());
    let tangent = tangent.copysign(cotangent);
    let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
    let sine = tangent * cosine;
    rows[p][p] -= tangent * between;
    rows[q][q] += tangent * between;
    rows[p][q] = 0.0;
    let r = 3 - p - q;
    let entry = |a: usize, b: usize| (a.min(b), a.max(b));
    let (rp, rq) = (entry(r, p), entry(r, q));
    let (with_p, with_q) = (rows[rp.0][rp.1], rows[rq.0][rq.1]);
    rows[rp.0][rp.1] = cosine * with_p - sine * with_q;
    rows[rq.0][rq.1] = sine * with_p + cosine * with_q;
    let [along_p, along_q] = [p, q].map(|axis| DVec3::from_array(vectors[axis]));
    vectors[p] = (cosine * along_p - sine * along_q).to_array();
    vectors[q] = (sine * along_p + cosine * along_q).to_array();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Stream;

    fn outer(a: DVec3) -> DMat3 {
        DMat3::from_cols(a * a.x, a * a.y, a * a.z)
    }

    #[test]
    fn diagonal_matrices_are_done() {
        let (values, vectors) = eigenvectors(DMat3::from_diagonal(DVec3::new(3.0, -1.0, 2.0)));
        assert_eq!(values, DVec3::new(3.0, -1.0, 2.0));
        assert_eq!(vectors, DMat3::IDENTITY);
        let (values, vectors) = eigenvectors(DMat3::ZERO);
        assert_eq!((values, vectors), (DVec3::ZERO, DMat3::IDENTITY));
    }

    #[test]
    fn random_matrices_are_taken_apart() {
        let mut draws = Stream::new(1, 0).draws();
        let mut number = |scale: f64| scale * f64::from(draws.signed());
        for round in 0..2000 {
            // From sphere to needle and disc, of either sign, and nearly of lower rank.
            let scale = [1.0, 1e-3, 1e-9, 0.0];
            let matrix = [0, 1, 2].into_iter().fold(DMat3::ZERO, |sum, axis| {
                let size = scale[(round >> (2 * axis)) % 4];
                let vector = DVec3::new(number(1.0), number(1.0), number(1.0));
                sum + outer(vector) * number(size)
            });
            let (values, vectors) = eigenvectors(matrix);
            let size = matrix
                .to_cols_array()
                .iter()
                .fold(0.0, |most: f64, e| most.max(e.abs()));
            for axis in 0..3 {
                let vector = vectors.col(axis);
                let residual = (matrix * vector - values[axis] * vector).length();
                assert!(residual <= 1e-14 * size, "round {round}: {residual}");
                assert!((vector.length() - 1.0).abs() < 1e-14, "round {round}");
            }
            let upright = vectors.transpose() * vectors;
            assert!(upright.abs_diff_eq(DMat3::IDENTITY, 1e-14), "round {round}");
        }
    }
}
