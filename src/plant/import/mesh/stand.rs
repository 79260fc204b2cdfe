//! Where a tree of triangles stands in its file, which way it grows, and in what unit.

use crate::math::DVec3;
use crate::plant::import::frame::Frame;
use crate::plant::import::{ImportReport, Reading, ReportKind, Unit, UpAxis};

/// Hands every point of a tree, in its file's space, to a function.
pub(in crate::plant) type Visit<'a> = dyn Fn(&mut dyn FnMut(DVec3)) + 'a;

/// A box in 64 bits.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Extent {
    least: DVec3,
    most: DVec3,
}

impl Extent {
    /// Around the points that `is_in` takes; `None` around nothing.
    fn of(visit: &Visit<'_>, is_in: impl Fn(DVec3) -> bool) -> Option<Self> {
        let mut extent = Self {
            least: DVec3::INFINITY,
            most: DVec3::NEG_INFINITY,
        };
        visit(&mut |point| {
            if is_in(point) {
                extent.least = extent.least.min(point);
                extent.most = extent.most.max(point);
            }
        });
        // What is not finite is refused where it is read.
        let size = extent.most - extent.least;
        (size.is_finite() && size.min_element() >= 0.0).then_some(extent)
    }

    fn size(&self) -> DVec3 {
        self.most - self.least
    }

    fn center(&self) -> DVec3 {
        0.5 * (self.least + self.most)
    }
}

/// A point's height, and 1 along the other axes.
fn height(up: UpAxis, point: DVec3) -> f64 {
    match up {
        UpAxis::Y => point.y,
        UpAxis::Z => point.z,
    }
}

fn with_height(up: UpAxis, point: DVec3, height: f64) -> DVec3 {
    match up {
        UpAxis::Y => DVec3::new(point.x, height, point.z),
        UpAxis::Z => DVec3::new(point.x, point.y, height),
    }
}

/// The frame of a file that says neither its up axis nor its unit.
///
/// A tree stands on little ground: of Y and Z that axis is up along which the lowest tenth of the tree is
/// the smaller share of its width, and where they are within a fifth of each other, that along which the
/// tree is longer. The unit is the metre up to a height of 120, the centimetre up to 12,000, and else the
/// millimetre: no tree is higher.
pub(in crate::plant) fn guess_frame(
    visit: &Visit<'_>,
    reading: Reading,
    report: &mut ImportReport,
) -> Frame {
    let Some(all) = Extent::of(visit, |_| true) else {
        return Frame::new(reading, UpAxis::Y, Unit::M);
    };
    let up = reading.up.unwrap_or_else(|| {
        let [y, z] = [UpAxis::Y, UpAxis::Z].map(|up| foot(visit, &all, up));
        let is_longer = all.size().z > all.size().y;
        let is_z = if y.max(z) <= 1.25 * y.min(z) {
            is_longer
        } else {
            z < y
        };
        let up = if is_z { UpAxis::Z } else { UpAxis::Y };
        let shares = [y, z].map(|share| (100.0 * share).round());
        let message = format!(
            "{} is up: the lowest tenth along y and z is {} and {} % as wide as the tree",
            up.name(),
            shares[0],
            shares[1]
        );
        report.add(ReportKind::Guessed, 1, "line 1", message);
        up
    });
    let unit = reading.unit.unwrap_or_else(|| {
        let height = height(up, all.size());
        let unit = match height {
            ..=120.0 => Unit::M,
            ..=12_000.0 => Unit::Cm,
            _ => Unit::Mm,
        };
        let (name, height) = (unit.name(), (1000.0 * height).round() / 1000.0);
        let message = format!("lengths are in {name}: the tree is {height} units high");
        report.add(ReportKind::Guessed, 1, "line 1", message);
        unit
    });
    Frame::new(reading, up, unit)
}

/// How wide the lowest tenth is along an axis, as a share of how wide all is.
fn foot(visit: &Visit<'_>, all: &Extent, up: UpAxis) -> f64 {
    let wide = with_height(up, all.size(), 0.0).length();
    match lowest(visit, all, up) {
        Some(low) if wide > 0.0 => with_height(up, low.size(), 0.0).length() / wide,
        _ => 1.0,
    }
}

fn lowest(visit: &Visit<'_>, all: &Extent, up: UpAxis) -> Option<Extent> {
    let top = height(up, all.least) + 0.1 * height(up, all.size());
    Extent::of(visit, |point| height(up, point) <= top)
}

/// Where a tree has its foot, in its file's space, if that is far from the file's origin: further than the
/// tree is large. Elsewhere a tree stays where its file has it.
pub(in crate::plant) fn base(visit: &Visit<'_>, up: UpAxis) -> Option<DVec3> {
    let all = Extent::of(visit, |_| true)?;
    let reach = DVec3::splat(all.size().max_element());
    let is_near = (all.least - reach).cmple(DVec3::ZERO) & (all.most + reach).cmpge(DVec3::ZERO);
    if is_near.all() {
        return None;
    }
    let low = lowest(visit, &all, up)?;
    Some(with_height(up, low.center(), height(up, all.least)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A trunk of 1 × 1 and 4 high, and a crown of 6 × 6 and 6 high upon it.
    fn tree(up: UpAxis, scale: f64, at: DVec3) -> Vec<DVec3> {
        let corners = |side: f64, level: f64| {
            [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[a, b]| {
                let [a, b] = [a, b].map(|c| 0.5 * c * side * scale);
                at + match up {
                    UpAxis::Y => DVec3::new(a, level * scale, b),
                    UpAxis::Z => DVec3::new(a, b, level * scale),
                }
            })
        };
        [(1.0, 0.0), (1.0, 4.0), (6.0, 5.0), (6.0, 9.0), (1.0, 10.0)]
            .iter()
            .flat_map(|&(side, level)| corners(side, level))
            .collect()
    }

    #[test]
    fn axis_and_unit_are_guessed_from_the_shape() {
        for (up, scale, said) in [
            (
                UpAxis::Y,
                1.0,
                "y is up: the lowest tenth along y and z is 17 and",
            ),
            (
                UpAxis::Z,
                100.0,
                "z is up: the lowest tenth along y and z is",
            ),
        ] {
            let points = tree(up, scale, DVec3::ZERO);
            let visit = |take: &mut dyn FnMut(DVec3)| points.iter().for_each(|&point| take(point));
            let mut report = ImportReport::default();
            let frame = guess_frame(&visit, Reading::default(), &mut report);
            let top = DVec3::splat(10.0 * scale);
            assert!((frame.point(top).y - 10.0).abs() < 1e-5);
            assert_eq!(
                frame.height(DVec3::new(0.0, 1.0, 2.0)),
                if scale > 1.0 { 2.0 } else { 1.0 }
            );
            assert!(report.entries[0].message.starts_with(said), "{report}");
            assert_eq!(base(&visit, up), None);
        }
        let mut report = ImportReport::default();
        let none = guess_frame(
            &|_: &mut dyn FnMut(DVec3)| {},
            Reading::default(),
            &mut report,
        );
        assert_eq!(none, Frame::new(Reading::default(), UpAxis::Y, Unit::M));
        assert!(report.entries.is_empty());
    }

    #[test]
    fn far_trees_have_their_foot_as_base() {
        let at = DVec3::new(5000.25, -3.0, 20.0);
        let points = tree(UpAxis::Y, 1.0, at);
        let visit = |take: &mut dyn FnMut(DVec3)| points.iter().for_each(|&point| take(point));
        assert_eq!(base(&visit, UpAxis::Y), Some(at));
    }
}
