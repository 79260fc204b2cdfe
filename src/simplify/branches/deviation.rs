//! How far the polygons of one internode lie from its surface, at most.
//!
//! The paper looks at the two end circles only. Between them lies more; what is added here is derived
//! so that it holds in both directions, for every point of the surface and every point of the
//! polygons.
//!
//! Points of both with the same `u` are compared. The surface is `(1−u) V(θ) + u V'(θ)`, with `V`, `V'`
//! the end circles (eq. 1).
//!
//! - **A side joins points at angles α and β** of the two polygons. A point of an edge lies within the
//!   sagitta of the circle point at its angle, so the side lies within the greater sagitta of
//!   `(1−u) V(α) + u V'(β)`. Compare that with the surface at the angle between, in proportion to
//!   `a = (1−u) R` and `b = u R'`: what is of first order in `Δ = β − α` cancels, and there remain
//!   `p Δ²/2` towards the axis, `p |Δ|³/6` along the circle, `p |Δ| κ` because the frames differ by
//!   `κ = √(|N'−N|² + |B'−B|²)`, where `p = a b / (a + b) ≤ R R' / (√R + √R')²` for all `u`. For a
//!   prism `Δ = 0` and nothing remains; a prismoid's [`Connection`] knows its greatest `Δ`.
//! - **A quad is drawn as two triangles.** Its bilinear patch is `A + u b + s c + u s d`, with `d` the
//!   difference of the two edges; the triangles have `min(u, s)` in place of `u s`, which is at most a
//!   quarter more: `|d| / 4`. What of `d` lies along `c` moves points within the patch's own lines
//!   of equal `u` only, so the part `d'` across it is a bound too. A taper without a bend has none.
//! - **An apex** is compared with a circle, which is its radius away, and so is **a line**.

use super::connection::Connection;
use super::skeletal::SkeletalVector;
use crate::math::Vec3;

/// How far one internode's polygons may lie from its surface, in metres.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Deviation {
    /// On the end circles, which `E3` bounds.
    pub(super) circles: f32,
    /// What comes on top between them.
    pub(super) between: f32,
}

/// What joined polygons add between their circles, without what quads add by being two triangles.
pub(super) fn turned(start: &SkeletalVector, end: &SkeletalVector, connection: &Connection) -> f32 {
    let angle = connection.offset + connection.slack;
    let [first, second] = [start, end].map(|end| end.radius.sqrt());
    let roots = first + second;
    if angle <= 0.0 || roots <= 0.0 {
        return 0.0;
    }
    let part = first * second / roots;
    let normals = end.frame.normal - start.frame.normal;
    let binormals = end.frame.binormal - start.frame.binormal;
    let frames = (normals.length_squared() + binormals.length_squared()).sqrt();
    part * part * angle * (0.5 * angle + angle * angle / 6.0 + frames)
}

/// What a quad adds by being two triangles; its corners are two of the start's edge and two of the
/// end's, in the same order.
pub(super) fn split(start: [Vec3; 2], end: [Vec3; 2]) -> f32 {
    let edge = start[1] - start[0];
    let difference = (end[1] - end[0]) - edge;
    let quarter = 0.25 * difference.length();
    let square = edge.length_squared();
    if square <= 0.0 {
        return quarter;
    }
    let along = difference.dot(edge) / square;
    if along > -1.0 {
        quarter.min((difference - along * edge).length())
    } else {
        quarter
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trapezium_adds_nothing_and_a_saddle_a_quarter() {
        let trapezium = split([Vec3::ZERO, Vec3::X], [Vec3::Y, Vec3::Y + 0.25 * Vec3::X]);
        assert!(trapezium < 1e-7, "{trapezium}");
        // One corner lifted by 1: the middles of the two diagonals are a half apart.
        let saddle = split([Vec3::ZERO, Vec3::X], [Vec3::Y, Vec3::new(1.0, 1.0, 1.0)]);
        assert!((saddle - 0.25).abs() < 1e-7, "{saddle}");
    }
}
