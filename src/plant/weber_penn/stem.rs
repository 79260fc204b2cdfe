//! One stem: its curved axis, the clones it splits into, and how pruning shortens it.

use super::GrowError;
use super::formulas::{lifted, segment_curve, shape_ratio};
use super::frame::Frame;
use crate::limits;
use crate::math::{Stream, Vec2, Vec3};
use crate::plant::{Crown, Pruning, Shape, StemLevel};

/// Which numbers of a stem's stream serve what; children and leaves have streams of their own, so
/// that none of them shifts another.
pub(super) mod streams {
    pub(in super::super) const SHAPE: u64 = 0;
    pub(in super::super) const CURVE: u64 = 1;
    pub(in super::super) const CLONES: u64 = 2;
    pub(in super::super) const CHILDREN: u64 = 3;
    pub(in super::super) const LEAVES: u64 = 4;
}

/// What decides a stem before it grows.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stem {
    /// Its level, 0 the trunk.
    pub(super) level: usize,
    /// Where and how it leaves its parent.
    pub(super) position: Vec3,
    pub(super) frame: Frame,
    /// In metres, before pruning.
    pub(super) length: f32,
    /// Its radius at the base, in metres.
    pub(super) radius: f32,
    /// Where it sits on its parent, as a share of the parent's length.
    pub(super) offset: f32,
    /// Its length as a share of its parent's.
    pub(super) share: f32,
    /// Its random numbers.
    pub(super) stream: Stream,
}

/// A polyline that grew: a stem's main axis, or a clone of it.
#[derive(Debug, Clone)]
pub(super) struct Axis {
    /// The axis and the node where it split off; `None` for the main axis.
    pub(super) split_from: Option<(usize, usize)>,
    /// Base first.
    pub(super) points: Vec<Point>,
    /// Its random numbers.
    pub(super) stream: Stream,
}

/// A point of an axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point {
    pub(super) position: Vec3,
    /// The frame of the segment that begins here; at the tip, of the one that ends here.
    pub(super) frame: Frame,
    /// The distance from the stem's base along the axis, in metres.
    pub(super) along: f32,
    /// The part of the stem's children that the segment that begins here bears: 1 before the first
    /// split, and at each split shared evenly, since `nBranches` counts all of a stem's children.
    pub(super) part: f32,
}

/// The tree as a whole: what pruning and attraction look at.
#[derive(Debug, Clone, Copy)]
pub(super) struct Site<'a> {
    pub(super) crown: &'a Crown,
    /// The height of this plant, in metres (`scale ± scale_v`).
    pub(super) height: f32,
    /// Clones at the end of the trunk's first segment.
    pub(super) base_splits: u32,
    /// How wide the trunk's foot flares; decides where it needs points.
    pub(super) flare: f32,
}

/// Grows all axes of a stem, and tells its length after pruning; no axis when nothing is left.
///
/// # Errors
///
/// When the effort runs out: splits make too many points, or pruning tries too often.
pub(super) fn grow_stem(
    site: &Site<'_>,
    level: &StemLevel,
    stem: &Stem,
    effort: &mut Effort,
) -> Result<(Vec<Axis>, f32), GrowError> {
    let pruning = &site.crown.pruning;
    let mut grow = |length| axes_of(site, level, stem, length, effort);
    let grown = grow(stem.length)?;
    if pruning.ratio <= 0.0 || stem.level == 0 || site.holds(&grown) {
        return Ok((grown, stem.length));
    }
    // The paper shortens a stem until it fits, and then goes `ratio` of the way there.
    let mut fitting = stem.length;
    while fitting > 0.05 * stem.length {
        fitting *= 0.9;
        if site.holds(&grow(fitting)?) {
            break;
        }
    }
    let fits = fitting > 0.05 * stem.length;
    let length = stem.length + pruning.ratio * (if fits { fitting } else { 0.0 } - stem.length);
    if length < 0.05 * stem.length {
        return Ok((Vec::new(), 0.0));
    }
    Ok((grow(length)?, length))
}

/// How many points were grown, discarded attempts included: what bounds time and memory.
#[derive(Debug, Default)]
pub(super) struct Effort {
    all: usize,
}

impl Effort {
    fn spend(&mut self, points_of_stem: usize) -> Result<(), GrowError> {
        self.all += 1;
        for (what, found, limit) in [
            ("points on one stem", points_of_stem, limits::STEM_POINTS),
            ("points tried", self.all, limits::GROWTH_POINTS),
        ] {
            if found > limit {
                return Err(GrowError::TooMany { what, found, limit });
            }
        }
        Ok(())
    }
}

impl Site<'_> {
    /// Whether all points lie inside the pruning envelope.
    fn holds(&self, axes: &[Axis]) -> bool {
        let Pruning { width, .. } = self.crown.pruning;
        let crown_height = self.height * (1.0 - self.crown.base_size);
        axes.iter().flat_map(|axis| &axis.points).all(|point| {
            let from_axis = Vec2::new(point.position.x, point.position.z).length();
            let ratio = (self.height - point.position.y) / crown_height;
            let room = shape_ratio(Shape::Envelope, ratio, &self.crown.pruning);
            from_axis <= width * self.height * room
        })
    }
}

/// An axis that still grows.
struct Growing {
    axis: usize,
    segment: u32,
    position: Vec3,
    frame: Frame,
    /// The turn in degrees that each remaining segment takes back after a split.
    return_turn: f32,
    /// What rounding left of the splits so far; begins at random, so that stems split at
    /// different heights when there is less than one split a stem.
    split_error: f32,
    /// See [`Point::part`].
    part: f32,
}

fn axes_of(
    site: &Site<'_>,
    level: &StemLevel,
    stem: &Stem,
    length: f32,
    effort: &mut Effort,
) -> Result<Vec<Axis>, GrowError> {
    let segment_length = length / level.curve_res as f32;
    let shape = stem.stream.child(streams::SHAPE);
    let mut frame = stem.frame;
    if level.curve_v < 0.0 {
        frame = frame.pitch(-level.curve_v);
    }
    let first = Point {
        position: stem.position,
        frame,
        along: 0.0,
        part: 1.0,
    };
    let mut axes = vec![Axis {
        split_from: None,
        points: vec![first],
        stream: stem.stream,
    }];
    let mut growing = vec![Growing {
        axis: 0,
        segment: 0,
        position: stem.position,
        frame,
        return_turn: 0.0,
        split_error: shape.unit(0) - 0.5,
        part: 1.0,
    }];
    let mut point_count = 1;
    while let Some(mut tip) = growing.pop() {
        let stream = axes[tip.axis].stream;
        let bends = stream.child(streams::CURVE);
        while tip.segment < level.curve_res {
            let segment = tip.segment;
            if segment > 0 {
                let bend = segment_curve(level, segment, bends.signed(u64::from(segment)));
                tip.frame = tip.frame.pitch(bend + tip.return_turn);
                if level.curve_v < 0.0 {
                    // A quarter turn about the stem's own direction a segment makes the helix.
                    tip.frame = tip.frame.about(stem.frame.heading, 90.0);
                }
                let pull = site.crown.attraction_up[stem.level] / level.curve_res as f32;
                tip.frame = lifted(tip.frame, pull);
                if let Some(last) = axes[tip.axis].points.last_mut() {
                    last.frame = tip.frame;
                    last.part = tip.part;
                }
            }
            let along = segment as f32 * segment_length;
            for step in steps_within(site, level, stem, length, segment) {
                axes[tip.axis].points.push(Point {
                    position: tip.position + step * tip.frame.heading,
                    frame: tip.frame,
                    along: along + step,
                    part: tip.part,
                });
                point_count += 1;
                effort.spend(point_count)?;
            }
            tip.position += segment_length * tip.frame.heading;
            tip.segment += 1;
            let points = &mut axes[tip.axis].points;
            points.push(Point {
                position: tip.position,
                frame: tip.frame,
                along: along + segment_length,
                part: tip.part,
            });
            point_count += 1;
            effort.spend(point_count)?;
            if tip.segment < level.curve_res {
                split(site, level, stem, &mut tip, &mut axes, &mut growing);
            }
        }
    }
    Ok(axes)
}

/// Turns an axis aside at the end of a segment and lets clones grow from there.
fn split(
    site: &Site<'_>,
    level: &StemLevel,
    stem: &Stem,
    tip: &mut Growing,
    axes: &mut Vec<Axis>,
    growing: &mut Vec<Growing>,
) {
    let at_base = stem.level == 0 && tip.segment == 1 && site.base_splits > 0;
    let clones = if at_base {
        site.base_splits
    } else {
        let wanted = level.segment_splits + tip.split_error;
        let whole = (wanted + 0.5).floor().max(0.0);
        tip.split_error = wanted - whole;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number from 0 to 5: splits a segment are at most 4"
        )]
        let whole = whole as u32;
        whole
    };
    if clones == 0 {
        return;
    }
    let node = axes[tip.axis].points.len() - 1;
    let stream = axes[tip.axis].stream.child(streams::CLONES);
    let stream = stream.child(u64::from(tip.segment));
    let (before, declination) = (tip.frame, tip.frame.declination());
    let remaining = (level.curve_res - tip.segment) as f32;
    tip.part /= (clones + 1) as f32;
    for clone in 0..=clones {
        let draws = stream.child(u64::from(clone));
        let wanted = level.split_angle + draws.signed(0) * level.split_angle_v;
        let angle = (wanted - declination).max(0.0);
        let mut frame = before.pitch(angle);
        // The first is the axis itself.
        if clone > 0 {
            let spread = if at_base {
                360.0 * clone as f32 / (clones + 1) as f32
            } else {
                let u = draws.unit(1);
                let sign = if draws.u64(2) & 1 == 0 { 1.0 } else { -1.0 };
                sign * (20.0 + 0.75 * (30.0 + (declination - 90.0).abs()) * u * u)
            };
            frame = frame.about(Vec3::Y, spread);
        }
        let return_turn = tip.return_turn - angle / remaining;
        if clone == 0 {
            tip.frame = frame;
            tip.return_turn = return_turn;
            continue;
        }
        axes.push(Axis {
            split_from: Some((tip.axis, node)),
            points: vec![Point {
                position: tip.position,
                frame,
                along: axes[tip.axis].points[node].along,
                part: tip.part,
            }],
            stream: draws,
        });
        growing.push(Growing {
            axis: axes.len() - 1,
            segment: tip.segment,
            position: tip.position,
            frame,
            return_turn,
            split_error: draws.unit(3) - 0.5,
            part: tip.part,
        });
    }
}

/// Where a segment needs points between its ends, as distances from its base in metres: where the
/// radius does not follow a straight line.
fn steps_within(
    site: &Site<'_>,
    level: &StemLevel,
    stem: &Stem,
    length: f32,
    segment: u32,
) -> Vec<f32> {
    let segments = level.curve_res as f32;
    let (start, end) = (segment as f32 / segments, (segment + 1) as f32 / segments);
    let mut at = Vec::new();
    if stem.level == 0 && site.flare > 0.0 {
        at.extend([0.01, 0.03, 0.06, 0.125]);
    }
    if level.taper > 2.0 {
        // Four points a bulge, one bulge a diameter.
        let steps = (2.0 * (end - start) * length / stem.radius.max(1e-6)).clamp(1.0, 32.0);
        let steps = steps.floor();
        let mut step = 1.0;
        while step < steps {
            at.push(start + (end - start) * step / steps);
            step += 1.0;
        }
    } else if level.taper > 1.0 {
        // The dome: one radius long, its slope steeper and steeper.
        let dome = stem.radius * (level.taper - 1.0) / length;
        at.extend([1.0, 0.5, 0.134].map(|share| 1.0 - share * dome));
    }
    at.retain(|&z| z > start + 1e-3 * (end - start) && z < end - 1e-3 * (end - start));
    at.sort_by(f32::total_cmp);
    at.iter().map(|z| (z - start) * length).collect()
}
