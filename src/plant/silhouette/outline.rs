//! The outlines and arrangements of all silhouettes.

use super::Silhouette;
use super::brush::{Brush, Outline, reach};
use crate::math::{Vec2, det};

/// A twig's brown.
const TWIG: [u8; 3] = [0x6a, 0x52, 0x3a];

/// A rod's green.
const ROD: [u8; 3] = [0x5f, 0x80, 0x3c];

/// Paints a silhouette over the whole canvas.
pub(super) fn paint(silhouette: Silhouette, brush: &mut Brush) {
    match silhouette {
        Silhouette::OvateSerrate => single(brush, ovate_serrate),
        Silhouette::Elliptic => single(brush, elliptic),
        Silhouette::Obovate => single(brush, obovate),
        Silhouette::Lobed => single(brush, lobed),
        Silhouette::Lanceolate => single(brush, lanceolate),
        Silhouette::LanceolateSerrate => single(brush, lanceolate_serrate),
        Silhouette::Round => single(brush, round),
        Silhouette::BirchSprig => sprig(brush, ovate_serrate, &SPRIG_OF_FIVE, 0.62),
        Silhouette::OakSprig => sprig(brush, lobed, &SPRIG_OF_FIVE, 0.56),
        Silhouette::CorkOakSprig => sprig(brush, spiny, &SPRIG_OF_SEVEN, 0.6),
        Silhouette::OliveSprig => sprig(brush, lanceolate, &SPRIG_OF_PAIRS, 0.3),
        Silhouette::Pinnate => pinnate(brush, 7, true, ovate_serrate),
        Silhouette::PinnateEntire => pinnate(brush, 5, false, elliptic),
        Silhouette::YewSpray => yew_spray(brush),
        Silhouette::JuniperTuft => juniper_tuft(brush),
        Silhouette::CypressSpray => cypress_spray(brush),
        Silhouette::Rush => rush(brush),
        Silhouette::RushBlossom => rush_blossom(brush),
    }
}

fn elliptic(share: f32) -> f32 {
    let x = 2.0 * share - 1.0;
    (1.0 - x * x).max(0.0).sqrt()
}

/// Widest where `share ^ power` is one half.
fn hump(share: f32, power: f32) -> f32 {
    det::sin(std::f32::consts::PI * det::pow(share, power)).max(0.0)
}

fn obovate(share: f32) -> f32 {
    hump(share, 1.4)
}

fn lanceolate(share: f32) -> f32 {
    hump(share, 0.8)
}

fn lanceolate_serrate(share: f32) -> f32 {
    // Teeth point to the tip: each widens, then ends at once.
    let tooth = (12.0 * share).fract();
    hump(share, 0.9) * (0.82 + 0.18 * tooth)
}

fn round(share: f32) -> f32 {
    // A circle with a short tip.
    let disc = elliptic((share / 0.93).min(1.0));
    disc.max(0.35 * (1.0 - share) / 0.1 * f32::from(u8::from(share > 0.9)))
}

fn ovate_serrate(share: f32) -> f32 {
    let tooth = (11.0 * share).fract();
    hump(share, 0.62) * (1.0 - 0.22 * tooth)
}

fn spiny(share: f32) -> f32 {
    let tooth = (5.0 * share).fract();
    hump(share, 0.75) * (1.0 - 0.25 * tooth)
}

fn lobed(share: f32) -> f32 {
    let lobes = det::cos(std::f32::consts::TAU * (4.0 * share - 0.62));
    hump(share, 1.1) * (0.76 + 0.24 * lobes)
}

/// One blade over the whole canvas, on a short stalk.
fn single(brush: &mut Brush, outline: Outline) {
    let (base, tip) = (Vec2::new(0.0, 0.06), Vec2::new(0.0, 0.99));
    brush.line(&[Vec2::ZERO, Vec2::new(0.0, 0.2)], 0.03, 0.9);
    brush.blade([base, tip], 0.485 * brush.width, outline, 1.0);
}

/// A leaf of a sprig: where it sits on the twig, its angle in degrees, its length, its brightness.
type SprigLeaf = (f32, f32, f32, f32);

const SPRIG_OF_FIVE: [SprigLeaf; 5] = [
    (0.08, -62.0, 0.46, 0.88),
    (0.16, 58.0, 0.48, 0.95),
    (0.34, -44.0, 0.5, 1.0),
    (0.42, 40.0, 0.5, 0.92),
    (0.5, 2.0, 0.49, 1.06),
];

const SPRIG_OF_SEVEN: [SprigLeaf; 7] = [
    (0.06, -60.0, 0.36, 0.86),
    (0.14, 62.0, 0.38, 0.94),
    (0.28, -54.0, 0.38, 1.0),
    (0.36, 52.0, 0.38, 0.9),
    (0.5, -42.0, 0.38, 1.04),
    (0.56, 38.0, 0.36, 0.95),
    (0.62, 0.0, 0.37, 1.08),
];

const SPRIG_OF_PAIRS: [SprigLeaf; 9] = [
    (0.06, -48.0, 0.42, 0.9),
    (0.06, 46.0, 0.42, 0.98),
    (0.22, -42.0, 0.44, 1.04),
    (0.22, 44.0, 0.44, 0.9),
    (0.38, -36.0, 0.42, 0.95),
    (0.38, 38.0, 0.42, 1.06),
    (0.54, -28.0, 0.4, 1.04),
    (0.54, 26.0, 0.4, 0.94),
    (0.62, 0.0, 0.37, 1.0),
];

/// Leaves on a twig; `shape` is a blade's width as a share of its length.
fn sprig(brush: &mut Brush, outline: Outline, leaves: &[SprigLeaf], shape: f32) {
    brush.twig(&[Vec2::ZERO, Vec2::new(0.0, 0.64)], 0.02, TWIG);
    // Wide canvases let leaves reach out; on narrow ones they are folded to fit.
    let reach_out = (brush.width / 0.8).min(1.0);
    for &(at, degrees, length, tone) in leaves {
        let base = Vec2::new(0.0, at);
        let tip = reach(base, degrees * reach_out, length);
        brush.blade([base, tip], 0.5 * shape * length, outline, tone);
    }
}

/// Leaflets in pairs on a rachis, with or without one at the end.
fn pinnate(brush: &mut Brush, pairs: u16, end: bool, outline: Outline) {
    let rachis = if end { 0.8 } else { 0.76 };
    brush.line(&[Vec2::ZERO, Vec2::new(0.0, rachis)], 0.02, 0.85);
    let first = 0.17;
    let spacing = (rachis - first) / f32::from(pairs - 1);
    let longest = 0.5 * brush.width;
    for pair in 0..pairs {
        let share = f32::from(pair) / f32::from(pairs - 1);
        // Shortest at both ends.
        let length = longest * (0.8 + 0.26 * elliptic(0.15 + 0.8 * share));
        for side in [-1.0, 1.0] {
            let base = Vec2::new(0.0, first + spacing * f32::from(pair));
            let tip = reach(base, side * (68.0 - 26.0 * share), length);
            let tone = if (pair % 2 == 0) == (side > 0.0) {
                1.05
            } else {
                0.92
            };
            brush.blade([base, tip], 0.52 * spacing, outline, tone);
        }
    }
    if end {
        let ends = [Vec2::new(0.0, rachis - 0.02), Vec2::new(0.0, 0.995)];
        brush.blade(ends, 0.5 * spacing, outline, 1.08);
    }
}

/// Needles in two ranks along a twig from `base`; none reaches past the canvas.
fn ranks(brush: &mut Brush, ends: [Vec2; 2], needle: f32, tone: f32) {
    let [base, tip] = ends;
    let along = tip - base;
    let count = (along.length() / 0.034).floor().max(3.0);
    let heading = det::atan2(along.x, along.y).to_degrees();
    brush.line(&[base, tip], 0.02, 0.7 * tone);
    let mut step = 1.0;
    while step <= count {
        let share = step / count;
        let root = base + share * along;
        // Shorter and more forward towards the tip.
        let length = needle * (1.0 - 0.45 * share * share);
        for side in [-1.0, 1.0] {
            let end = reach(root, heading + side * (68.0 - 40.0 * share), length);
            let light = if side > 0.0 { 1.08 } else { 0.92 };
            brush.line(&[root, end], 0.021, tone * light);
        }
        step += 1.0;
    }
}

fn yew_spray(brush: &mut Brush) {
    let half = 0.5 * brush.width;
    let point = |x: f32, y: f32| Vec2::new(x * half, y);
    let side_twigs = [
        ([point(0.0, 0.12), point(-0.62, 0.5)], 0.86),
        ([point(0.0, 0.2), point(0.62, 0.58)], 0.94),
        ([point(0.0, 0.44), point(-0.5, 0.8)], 1.0),
        ([point(0.0, 0.5), point(0.5, 0.84)], 0.9),
    ];
    for (ends, tone) in side_twigs {
        ranks(brush, ends, 0.26 * half, tone);
    }
    ranks(brush, [Vec2::ZERO, point(0.0, 0.93)], 0.3 * half, 1.08);
}

fn juniper_tuft(brush: &mut Brush) {
    let half = 0.5 * brush.width;
    let twigs = [
        ([Vec2::new(0.0, 0.08), Vec2::new(-0.5 * half, 0.62)], 0.86),
        ([Vec2::new(0.0, 0.16), Vec2::new(0.52 * half, 0.68)], 0.94),
        ([Vec2::ZERO, Vec2::new(0.0, 0.84)], 1.04),
    ];
    for ([base, tip], tone) in twigs {
        brush.twig(&[base, tip], 0.022, TWIG);
        let along = tip - base;
        let heading = det::atan2(along.x, along.y).to_degrees();
        // Whorls of three: two seen from the side, one towards the viewer.
        for whorl in 0..9_u16 {
            let share = (f32::from(whorl) + 0.6) / 9.0;
            let root = base + share * along;
            for (side, light) in [(-1.0, 0.9), (1.0, 1.0), (0.35, 1.16)] {
                let end = reach(root, heading + side * (62.0 - 22.0 * share), 0.42 * half);
                brush.line(&[root, end], 0.02, tone * light);
            }
        }
    }
}

fn cypress_spray(brush: &mut Brush) {
    let half = 0.5 * brush.width;
    let axis = |y: f32| Vec2::new(0.0, y);
    for rank in 0..9_u16 {
        let share = f32::from(rank) / 9.0;
        for side in [-1.0, 1.0] {
            let stagger = if side > 0.0 { 0.045 } else { 0.0 };
            let root = axis(0.06 + 0.8 * share + stagger);
            let length = (0.95 * half).min(0.4) * (1.0 - 0.75 * share * share);
            let tone = if (rank % 2 == 0) == (side > 0.0) {
                1.05
            } else {
                0.88
            };
            let end = reach(root, side * 44.0, length);
            brush.line(&[root, end], 0.04, tone);
            // Twiglets on the outer side, shorter towards the tip.
            for (at, outer) in [(0.35, 1.0), (0.6, -1.0), (0.75, 1.0)] {
                let fork = root.lerp(end, at);
                let tip = reach(
                    fork,
                    side * (44.0 - outer * 34.0),
                    0.4 * length * (1.25 - at),
                );
                brush.line(&[fork, tip], 0.035, 1.04 * tone);
            }
        }
    }
    brush.line(&[axis(0.0), axis(0.97)], 0.045, 0.96);
}

/// The rods of a broom's twig: angle in degrees, length, brightness.
const RODS: [(f32, f32, f32); 5] = [
    (-9.0, 0.86, 0.85),
    (-4.5, 0.97, 1.0),
    (0.5, 0.99, 1.1),
    (5.0, 0.94, 0.92),
    (9.5, 0.8, 1.02),
];

/// How far rods may lean on a canvas, as a factor on their angles.
fn rod_spread(brush: &Brush) -> f32 {
    (brush.width / 0.36).min(1.0)
}

fn rush(brush: &mut Brush) {
    let spread = rod_spread(brush);
    for (degrees, length, tone) in RODS {
        let tip = reach(Vec2::ZERO, spread * degrees, length);
        brush.line(&[Vec2::ZERO, tip], 0.026, tone);
        // A small leaf here and there, pressed to the rod.
        for at in [0.3, 0.62] {
            let base = tip * (at + 0.01 * degrees.abs());
            let lean = if degrees > 0.0 { 24.0 } else { -24.0 };
            let end = reach(base, spread * (degrees + lean), 0.11);
            brush.blade([base, end], 0.014, elliptic, 1.1 * tone);
        }
    }
}

fn rush_blossom(brush: &mut Brush) {
    let spread = rod_spread(brush);
    brush.twig(&[Vec2::ZERO, Vec2::new(0.0, 0.95)], 0.03, ROD);
    for flower in 0..9_u16 {
        let share = f32::from(flower) / 8.0;
        let base = Vec2::new(0.0, 0.32 + 0.56 * share);
        let side = if flower % 2 == 0 { 1.0 } else { -1.0 };
        let length = 0.17 - 0.07 * share;
        let tip = reach(base, side * spread * 62.0, length);
        brush.blade(
            [base, tip],
            0.42 * length,
            obovate,
            if side > 0.0 { 1.0 } else { 0.9 },
        );
        let keel = reach(base, side * spread * 100.0, 0.7 * length);
        brush.blade([base, keel], 0.3 * length, elliptic, 0.86);
    }
}
