//! Leaf distribution maps: which leaves show at a place of an impostor, and how they lie there.
//!
//! ```text
//!  impostor                    map, 4 × 4 texels × layers        a texel
//! ┌───────────┐               ┌──┬──┬──┬──┐                  r, g   lower left corner of the leaf's
//! │  ╭─╮      │  each leaf    │  │A │A │  │                         square, in the impostor
//! │  │A├─╮    │  in a square  ├──┼──┼──┼──┤                  b      which sprite: turn, face, kind
//! │  ╰─┤B│    │ ───────────▶  │  │A │AB│B │ 2 layers         a      size of the square, of the usual
//! │    ╰─╯    │               ├──┼──┼──┼──┤
//! └───────────┘               │  │  │B │B │                  r = −1: nothing
//! ```
//!
//! [GSS05](crate::references), § 2.3 has one leaf a texel, so where squares overlap leaves are lost; here
//! a texel has a list, the nearest to the front first, and from behind it is read backwards.

use super::bake::{Rectangle, ViewFrame};
use super::impostors_set::Impostor;
use super::indirect_sprites::{LeafShape, SpriteTurns};
use crate::math::{Vec2, Vec3, index_u32};
use crate::scene::{CardOptions, SpriteScale};

/// What of an impostor is told beside its map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LeafPlane {
    /// Where its texels lie.
    pub(super) frame: ViewFrame,
    /// The rectangle of the map: it holds all squares.
    pub(super) rectangle: Rectangle,
    /// The side of a square of the usual size, in the map's coordinates.
    pub(super) square: Vec2,
}

/// The map of an impostor: four floats a texel, texel by texel in rows from the top, each texel's list
/// after another.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LeafMap {
    pub(super) plane: LeafPlane,
    /// By texel, what lies there, the nearest to the front first.
    pub(super) texels: Vec<Vec<[f32; 4]>>,
    /// The most leaves in a texel.
    pub(super) most: u32,
    /// The greatest angle between a leaf and its sprite, in the plane: as its cosine.
    pub(super) least_cosine: f32,
}

/// The map of an impostor's leaves.
pub(super) fn leaf_map(
    impostor: &Impostor,
    shapes: &[LeafShape],
    turns: &SpriteTurns,
    options: &CardOptions,
) -> LeafMap {
    let frame = impostor.frame;
    let mut leaves: Vec<(u32, &LeafShape)> = impostor
        .sites
        .iter()
        .map(|&site| (site, &shapes[site as usize]))
        .collect();
    leaves.sort_by(|(first_site, first), (second_site, second)| {
        let nearer = frame
            .offset(second.centre)
            .total_cmp(&frame.offset(first.centre));
        nearer.then(first_site.cmp(second_site))
    });
    let count = leaves.len().max(1) as f32;
    let mean = leaves.iter().fold(0.0, |sum, (_, leaf)| sum + leaf.reach) / count;
    let usual = mean.max(LEAST_REACH);
    let reach_of = |leaf: &LeafShape| match options.scale {
        SpriteScale::Global => usual,
        SpriteScale::Leaf => leaf.reach.max(LEAST_REACH),
    };
    let rims = leaves.iter().flat_map(|(_, leaf)| {
        let reach = reach_of(leaf);
        let corner = frame.right + frame.up;
        [leaf.centre - reach * corner, leaf.centre + reach * corner]
    });
    let rectangle = Rectangle::around(&frame, rims);
    let sides = rectangle.sides();
    let side = options.map as usize;
    let mut map = LeafMap {
        plane: LeafPlane {
            frame,
            rectangle,
            square: 2.0 * usual / sides,
        },
        texels: vec![Vec::new(); side * side],
        most: 0,
        least_cosine: 1.0,
    };
    for (_, leaf) in leaves {
        let (sprite, cosine) = turns.nearest(leaf, &frame);
        map.least_cosine = map.least_cosine.min(cosine);
        let reach = reach_of(leaf);
        let seen = frame.seen(leaf.centre);
        // Rows of texels go down, as textures do.
        let middle = Vec2::new(seen.x - rectangle.least.x, rectangle.greatest.y - seen.y) / sides;
        let half = Vec2::splat(reach) / sides;
        let corner = middle - half;
        let entry = [corner.x, corner.y, sprite as f32, reach / usual];
        let [columns, rows] = [(middle.x, half.x), (middle.y, half.y)]
            .map(|(middle, half)| touched(middle - half, middle + half, options.map));
        for row in rows {
            for column in columns.clone() {
                let least = Vec2::new(column as f32, row as f32) / options.map as f32;
                let greatest = least + 1.0 / options.map as f32;
                // The leaf lies within a circle: what of its square is further off shows nothing.
                let off = (middle.clamp(least, greatest) - middle) * sides;
                if off.length_squared() <= (1.001 * reach) * (1.001 * reach) {
                    let texel = &mut map.texels[row as usize * side + column as usize];
                    texel.push(entry);
                    map.most = map.most.max(index_u32(texel.len()));
                }
            }
        }
    }
    map
}

const LEAST_REACH: f32 = 1e-4;

/// The texels of so many that an interval of coordinates touches.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the conversions saturate"
)]
fn touched(least: f32, greatest: f32, side: u32) -> std::ops::Range<u32> {
    let first = (least * side as f32).floor().max(0.0) as u32;
    let end = ((greatest * side as f32).ceil().max(0.0) as u32).min(side);
    first.min(end)..end
}

/// Maps side by side, layer by layer: what one texture of floats holds.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MapSheet {
    /// Texels a row, and rows.
    pub(super) size: [u32; 2],
    /// Tiles a row: tile `impostor · layers + layer` lies at column `tile % columns`.
    pub(super) columns: u32,
    /// As many as a texel needs that has most leaves.
    pub(super) layers: u32,
    /// Four floats a texel.
    pub(super) bytes: Vec<u8>,
}

impl MapSheet {
    /// All maps, of so many texels a side each.
    pub(super) fn of(maps: &[LeafMap], side: u32) -> Self {
        let layers = maps.iter().map(|map| map.most).max().unwrap_or(0).max(1);
        let tiles = layers * index_u32(maps.len().max(1));
        let columns = (1..=tiles)
            .find(|columns| columns * columns >= tiles)
            .unwrap_or(1);
        let size = [columns * side, tiles.div_ceil(columns) * side];
        let width = size[0] as usize;
        let mut floats = vec![[-1.0_f32, 0.0, 0.0, 0.0]; width * size[1] as usize];
        for (number, map) in (0..).zip(maps) {
            for (texel, list) in (0..).zip(&map.texels) {
                for (layer, entry) in (0..).zip(list) {
                    let tile: u32 = number * layers + layer;
                    let x = (tile % columns) * side + texel % side;
                    let y = (tile / columns) * side + texel / side;
                    floats[y as usize * width + x as usize] = *entry;
                }
            }
        }
        let bytes = floats.iter().flatten().copied();
        Self {
            size,
            columns,
            layers,
            bytes: bytes.flat_map(f32::to_le_bytes).collect(),
        }
    }
}

/// The corners of a map's rectangle in the impostor's plane, counter-clockwise from the lower left, with
/// their coordinates.
pub(super) fn corners(plane: &LeafPlane) -> [(Vec3, Vec2); 4] {
    [(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)].map(|(u, v)| {
        let coordinate = Vec2::new(u, v);
        let seen = plane.rectangle.at(coordinate);
        (plane.frame.point(seen, 0.0), coordinate)
    })
}
