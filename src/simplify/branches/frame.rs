//! Frames that move along an axis with as little turning as possible.

use crate::math::{Vec3, perpendicular};

/// Three directions at a node: right-handed, orthonormal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// The direction of the axis, towards the tip.
    pub tangent: Vec3,
    /// Where the angle θ is 0.
    pub normal: Vec3,
    /// Where the angle θ is a quarter turn: `tangent × normal`.
    pub binormal: Vec3,
}

/// How a frame gets from one node to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FrameMethod {
    /// Two reflections a step ([WJZL08](crate::references)): the error of the twist falls with the
    /// fourth power of the step.
    DoubleReflection,
    /// The last normal projected onto the next cross-section ([ZBMJLDC17](crate::references),
    /// eq. A1): neither a Frenet frame nor a rotation, and of first order only.
    Projection,
}

/// The frame at every point of a polyline.
///
/// A tangent is the bisector of the two segments that meet at its point; at the ends it is the one
/// segment's direction. Where both cancel (a hairpin) the segment that follows decides, and where a
/// segment has no length the one before it goes on, or +Y. The first normal lies across the first
/// tangent and the coordinate axis that it leans towards least (x before y before z).
#[must_use]
pub fn moving_frames(points: &[Vec3], method: FrameMethod) -> Vec<Frame> {
    carried(points, &tangents(points), method)
}

/// The frames at points of a curve whose tangents are known.
fn carried(points: &[Vec3], tangents: &[Vec3], method: FrameMethod) -> Vec<Frame> {
    let mut frames: Vec<Frame> = Vec::with_capacity(points.len());
    for (place, &tangent) in tangents.iter().enumerate() {
        let normal = match place.checked_sub(1) {
            None => perpendicular(tangent),
            Some(before) => {
                let last = frames[before];
                let carried = match method {
                    FrameMethod::DoubleReflection => {
                        twice_reflected(&last, points[place] - points[before], tangent)
                    }
                    FrameMethod::Projection => last.normal,
                };
                upright(carried, tangent)
            }
        };
        frames.push(Frame {
            tangent,
            normal,
            binormal: tangent.cross(normal),
        });
    }
    frames
}

/// The bisectors at all points.
fn tangents(points: &[Vec3]) -> Vec<Vec3> {
    let mut segments = Vec::with_capacity(points.len());
    let mut last = Vec3::Y;
    for ends in points.windows(2) {
        last = (ends[1] - ends[0]).normalize_or(last);
        segments.push(last);
    }
    let segment = |place: usize| segments.get(place).copied().unwrap_or(last);
    (0..points.len())
        .map(|place| match place {
            0 => segment(0),
            _ => {
                let after = segment(place);
                (segment(place - 1) + after).normalize_or(after)
            }
        })
        .collect()
}

/// The normal reflected in the plane between two points, then in the one between the tangents; a
/// reflection without a plane is left out.
fn twice_reflected(frame: &Frame, step: Vec3, tangent: Vec3) -> Vec3 {
    let reflected = |vector: Vec3, across: Vec3| {
        let square = across.length_squared();
        if square > 0.0 {
            vector - (2.0 / square) * across.dot(vector) * across
        } else {
            vector
        }
    };
    // As a direction: the square of a tiny step would be no number to divide by.
    let step = step.normalize_or_zero();
    let (normal, turned) = (
        reflected(frame.normal, step),
        reflected(frame.tangent, step),
    );
    let between = tangent - turned;
    // Of tangents this near only rounding is left, and its direction is any.
    if between.length_squared() < 1e-12 {
        return normal;
    }
    reflected(normal, between)
}

/// `normal` made a unit vector across `tangent`; any such where it lies along it.
fn upright(normal: Vec3, tangent: Vec3) -> Vec3 {
    let flat = normal - normal.dot(tangent) * tangent;
    if flat.length_squared() < 1e-10 {
        return perpendicular(tangent);
    }
    let flat = flat.normalize_or_zero();
    // Once more: what one pass leaves of the tangent is rounding over a short length.
    (flat - flat.dot(tangent) * tangent).normalize_or(perpendicular(tangent))
}

/// A frame about a direction of its own.
#[must_use]
pub fn upright_frame(tangent: Vec3) -> Frame {
    let normal = perpendicular(tangent);
    Frame {
        tangent,
        normal,
        binormal: tangent.cross(normal),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{Stream, det};

    /// Two turns of a helix of radius 1, with the curve's own tangents.
    fn helix(steps: u16, method: FrameMethod) -> Vec<Frame> {
        let (points, tangents): (Vec<Vec3>, Vec<Vec3>) = (0..=steps)
            .map(|step| {
                let angle = 2.0 * std::f32::consts::TAU * f32::from(step) / f32::from(steps);
                let (sine, cosine) = det::sin_cos(angle);
                let tangent = Vec3::new(-sine, 0.5, cosine).normalize_or_zero();
                (Vec3::new(cosine, 0.5 * angle, sine), tangent)
            })
            .unzip();
        carried(&points, &tangents, method)
    }

    fn sound(frames: &[Frame]) {
        for (place, frame) in frames.iter().enumerate() {
            let Frame {
                tangent,
                normal,
                binormal,
            } = *frame;
            for unit in [tangent, normal, binormal] {
                assert!((unit.length() - 1.0).abs() < 1e-5, "{place}: {frame:?}");
            }
            assert!(tangent.dot(normal).abs() < 1e-6, "{place}: {frame:?}");
            assert!(
                (normal.cross(binormal) - tangent).length() < 1e-5,
                "{place}: {frame:?}"
            );
        }
    }

    #[test]
    fn frames_are_orthonormal_on_any_polyline() {
        let mut draws = Stream::new(5, 0).draws();
        for case in 0_u16..200 {
            let mut points = vec![Vec3::ZERO];
            for _ in 0..12 {
                let step = Vec3::new(draws.signed(), draws.signed(), draws.signed());
                let last = points[points.len() - 1];
                // Steps of no length, hairpins and right angles too.
                points.push(match draws.below(6) {
                    0 => last,
                    1 => points[points.len().saturating_sub(2)],
                    2 => last + Vec3::X,
                    3 => last - Vec3::Y,
                    _ => last + step,
                });
            }
            points.truncate(usize::from(case % 14));
            for method in [FrameMethod::DoubleReflection, FrameMethod::Projection] {
                let frames = moving_frames(&points, method);
                assert_eq!(frames.len(), points.len());
                sound(&frames);
            }
        }
    }

    #[test]
    fn reflections_turn_least_and_projection_falls_behind() {
        let last = |steps, method| helix(steps, method).last().unwrap().normal;
        let reference = last(1280, FrameMethod::DoubleReflection);
        let error = |steps, method| (last(steps, method) - reference).length();
        // Of order four: a sixteenth for half the step, until rounding is all that is left.
        let [coarse, fine] = [20, 40].map(|steps| error(steps, FrameMethod::DoubleReflection));
        assert!((14.0..18.0).contains(&(coarse / fine)), "{coarse} {fine}");
        assert!(error(160, FrameMethod::DoubleReflection) < 1e-5);
        // Of order one.
        let [coarse, fine] = [80, 160].map(|steps| error(steps, FrameMethod::Projection));
        assert!((0.01..0.02).contains(&fine), "{fine}");
        assert!((1.8..2.6).contains(&(coarse / fine)), "{coarse} {fine}");
    }

    #[test]
    fn a_bend_in_a_plane_keeps_what_lies_across_it() {
        let points = [Vec3::ZERO, Vec3::Y, Vec3::Y + Vec3::X];
        for method in [FrameMethod::DoubleReflection, FrameMethod::Projection] {
            let frames = moving_frames(&points, method);
            let across = |frame: &Frame| [frame.normal.z, frame.binormal.z];
            let first = across(&frames[0]);
            for frame in &frames {
                for (found, wanted) in across(frame).into_iter().zip(first) {
                    assert!((found - wanted).abs() < 1e-6, "{method:?}: {frames:?}");
                }
            }
        }
    }
}
