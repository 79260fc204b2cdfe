//! Leaf distribution maps: which leaves show at a place of an impostor, and how they lie there.
//!
//! ```text
//!  impostor                    map, 4 × 4 texels             list          leaves
//! ┌───────────┐               ┌──┬──┬──┬──┐
//! │  ╭─╮      │  each leaf    │  │A │A │  │  first, count    numbers of    r, g  corner of its square
//! │  │A├─╮    │  in a square  ├──┼──┼──┼──┤ ──────────────▶  leaves, 4  ─▶ b     which sprite: turn, face, kind
//! │  ╰─┤B│    │ ───────────▶  │  │A │AB│B │                  a texel       a     size of the square, of the usual
//! │    ╰─╯    │               ├──┼──┼──┼──┤
//! └───────────┘               │  │  │B │B │
//! ```
//!
//! In [GSS05](crate::references), § 2.3 the texel itself has what a leaf has here, so that it names one leaf,
//! and where squares overlap leaves are lost. Here it says where its list begins and how long that is: the
//! nearest to the front first, and from behind it is read backwards. So the longest list costs what it has,
//! and nothing elsewhere.

use super::bake::{Rectangle, ViewFrame};
use super::impostors_set::Impostor;
use super::indirect_sprites::{LeafShape, SpriteTurns};
use crate::limits;
use crate::math::{Vec2, Vec3, det, index_u32};
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

/// What the maps of a crown's impostors, of all levels, hold together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeafMapFacts {
    /// The most leaves that a texel names.
    pub most_leaves: u32,
    /// How many leaves all texels name together.
    pub entries: u64,
    /// The greatest angle between a leaf and the sprite that shows it, in the impostor's plane, in
    /// degrees: at most half of the step by which sprites are turned.
    pub greatest_turn: f32,
}

impl LeafMapFacts {
    /// Of some maps.
    pub(super) fn of(maps: &[LeafMap]) -> Self {
        let least_cosine = maps
            .iter()
            .fold(1.0, |least: f32, map| least.min(map.least_cosine));
        Self {
            most_leaves: maps.iter().map(|map| map.most).max().unwrap_or(0),
            entries: maps.iter().map(|map| map.entries as u64).sum(),
            greatest_turn: det::acos(least_cosine).to_degrees(),
        }
    }
}

/// The map of an impostor, texel by texel in rows from the top.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LeafMap {
    pub(super) plane: LeafPlane,
    /// The leaves, the nearest to the front first.
    pub(super) leaves: Vec<[f32; 4]>,
    /// By texel, the numbers of those that lie there, ascending.
    pub(super) texels: Vec<Vec<u32>>,
    /// Leaves of all texels together.
    pub(super) entries: usize,
    /// The most leaves in a texel.
    pub(super) most: u32,
    /// The greatest angle between a leaf and its sprite, in the plane: as its cosine.
    pub(super) least_cosine: f32,
}

/// The map of an impostor's leaves; `None` where its lists would have more entries than `room`.
pub(super) fn leaf_map(
    impostor: &Impostor,
    (shapes, turns): (&[LeafShape], &SpriteTurns),
    options: &CardOptions,
    room: usize,
) -> Option<LeafMap> {
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
        leaves: Vec::with_capacity(leaves.len()),
        texels: vec![Vec::new(); side * side],
        entries: 0,
        most: 0,
        least_cosine: 1.0,
    };
    for (number, (_, leaf)) in (0..).zip(leaves) {
        let (sprite, cosine) = turns.nearest(leaf, &frame);
        map.least_cosine = map.least_cosine.min(cosine);
        let reach = reach_of(leaf);
        let seen = frame.seen(leaf.centre);
        // Rows of texels go down, as textures do.
        let middle = Vec2::new(seen.x - rectangle.least.x, rectangle.greatest.y - seen.y) / sides;
        let half = Vec2::splat(reach) / sides;
        let corner = middle - half;
        map.leaves
            .push([corner.x, corner.y, sprite as f32, reach / usual]);
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
                    texel.push(number);
                    map.entries += 1;
                    map.most = map.most.max(index_u32(texel.len()));
                }
            }
        }
        // Leaf by leaf, so that nothing grows without bounds.
        if map.entries > room {
            return None;
        }
    }
    Some(map)
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

/// All maps as textures of floats, four a texel.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MapSheet {
    /// Maps side by side: of each texel the place of its list's first number and how many there are,
    /// then zeros. Map `m` lies at column `m % columns`.
    pub(super) map: FloatTexels,
    /// Maps a row.
    pub(super) columns: u32,
    /// The lists of all texels one after another, in rows: numbers of leaves, four a texel.
    pub(super) list: FloatTexels,
    /// The leaves of all maps one after another, in rows.
    pub(super) leaves: FloatTexels,
    /// The mean number of leaves of texels that have some, rounded up.
    pub(super) usual_count: u32,
}

/// A texture of one level.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FloatTexels {
    /// Texels a row, and rows.
    pub(super) size: [u32; 2],
    pub(super) texels: Vec<[f32; 4]>,
}

/// How many entries all lists together may have: 32 MiB. As `f32` their places are exact, and so are the
/// numbers of leaves, each of which is in some list.
pub(super) const MOST_ENTRIES: usize = 1 << 23;

impl MapSheet {
    /// The most maps of so many texels a side that fit a texture together.
    pub(super) fn room(side: u32) -> u32 {
        let columns = limits::TEXTURE_SIDE / side.max(1);
        columns * columns
    }

    /// All maps, of so many texels a side each, no more than there is [room](Self::room) for.
    pub(super) fn of(maps: &[LeafMap], side: u32) -> Self {
        let count = index_u32(maps.len().max(1));
        let columns = square_side(count);
        let size = [columns * side, count.div_ceil(columns) * side];
        let width = size[0] as usize;
        let mut texels = vec![[0.0_f32; 4]; width * size[1] as usize];
        let (mut list, mut leaves, mut filled) = (Vec::new(), Vec::new(), 0);
        for (number, map) in (0_u32..).zip(maps) {
            let of_map = index_u32(leaves.len());
            leaves.extend_from_slice(&map.leaves);
            for (texel, numbers) in (0..).zip(&map.texels) {
                if numbers.is_empty() {
                    continue;
                }
                let x = (number % columns) * side + texel % side;
                let y = (number / columns) * side + texel / side;
                let [first, count] = [list.len(), numbers.len()].map(|number| number as f32);
                texels[y as usize * width + x as usize] = [first, count, 0.0, 0.0];
                list.extend(numbers.iter().map(|leaf| (of_map + leaf) as f32));
                filled += 1;
            }
        }
        let usual_count = index_u32(list.len().div_ceil(filled.max(1)));
        list.resize(list.len().next_multiple_of(4), 0.0);
        Self {
            map: FloatTexels { size, texels },
            columns,
            list: FloatTexels::in_rows(list.as_chunks().0.to_vec()),
            leaves: FloatTexels::in_rows(leaves),
            usual_count,
        }
    }
}

/// The side of the least square that has room for so many.
fn square_side(count: u32) -> u32 {
    let below = count.isqrt();
    below + u32::from(below * below < count)
}

impl FloatTexels {
    /// Texels one after another, in about as many rows as a row has texels; the last one ends with zeros.
    fn in_rows(mut texels: Vec<[f32; 4]>) -> Self {
        let count = index_u32(texels.len().max(1));
        let width = square_side(count);
        let rows = count.div_ceil(width);
        texels.resize(width as usize * rows as usize, [0.0; 4]);
        Self {
            size: [width, rows],
            texels,
        }
    }

    pub(super) fn bytes(&self) -> Vec<u8> {
        let floats = self.texels.as_flattened().iter();
        floats.flat_map(|value| value.to_le_bytes()).collect()
    }

    /// How many bytes these are.
    pub(super) fn byte_count(&self) -> u64 {
        16 * self.texels.len() as u64
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

#[cfg(test)]
mod tests {
    use super::super::indirect_sprites::leaf_shapes;
    use super::super::triangles::LeafTriangles;
    use super::super::triangles::examples::squares;
    use super::*;
    use crate::math::whole_u32;
    use crate::plant::Foliage;
    use crate::scene::CardOptions;
    use crate::simplify::Plane;

    /// An impostor in the plane z = 0 of squares at these places, seen from +Z, and their shapes.
    fn impostor(places: &[(Vec3, f32)]) -> (Impostor, Vec<LeafShape>) {
        let foliage = Foliage {
            groups: vec![squares([1.0; 3], places)],
        };
        let leaves = LeafTriangles::of(&foliage);
        let frame = ViewFrame {
            origin: Vec3::ZERO,
            right: Vec3::X,
            up: Vec3::Y,
            toward: Vec3::Z,
        };
        let plane = Plane {
            normal: Vec3::Z,
            distance: 0.0,
        };
        let corners = leaves.corners(0..leaves.site_count());
        let impostor = Impostor {
            level: 0,
            plane,
            next: plane,
            frame,
            rectangle: Rectangle::around(&frame, corners),
            sites: (0..leaves.site_count()).collect(),
        };
        (impostor, leaf_shapes(&leaves))
    }

    /// Leaves of three sizes, of which several overlap.
    const PLACES: [(Vec3, f32); 5] = [
        (Vec3::new(0.0, 0.0, 0.1), 1.0),
        (Vec3::new(0.3, 0.2, 0.3), 0.5),
        (Vec3::new(0.4, -0.1, 0.2), 2.0),
        (Vec3::new(-2.0, 1.5, 0.0), 0.3),
        (Vec3::new(3.1, 1.0, 0.0), 1.0),
    ];

    #[test]
    fn every_texel_names_all_leaves_that_reach_it_the_nearest_first() {
        let (impostor, shapes) = impostor(&PLACES);
        for scale in [SpriteScale::Leaf, SpriteScale::Global] {
            let options = CardOptions {
                map: 16,
                scale,
                ..CardOptions::USUAL
            };
            let turns = SpriteTurns::new(4);
            let map = leaf_map(&impostor, (&shapes, &turns), &options, 10_000);
            let map = map.expect("there is room");
            let LeafPlane {
                rectangle, square, ..
            } = map.plane;
            // Four points of each texel, and the leaves whose circles hold them.
            for texel in 0..256_u16 {
                let names: Vec<f32> = map.texels[usize::from(texel)]
                    .iter()
                    .map(|&leaf| map.leaves[leaf as usize])
                    .map(|entry| (entry[0] + 0.5 * entry[3] * square.x) * rectangle.sides().x)
                    .collect();
                for (dx, dy) in [(0.1, 0.1), (0.9, 0.1), (0.1, 0.9), (0.9, 0.9)] {
                    let [x, y] = [texel % 16, texel / 16].map(f32::from);
                    let at = rectangle.at(Vec2::new(x + dx, y + dy) / 16.0);
                    for shape in &shapes {
                        let reach = match scale {
                            SpriteScale::Leaf => shape.reach,
                            SpriteScale::Global => 0.5 * square.x * rectangle.sides().x,
                        };
                        let is_there = at.distance(shape.centre.truncate()) < reach;
                        let middle = shape.centre.x - rectangle.least.x;
                        let is_named = names.iter().any(|name| (name - middle).abs() < 1e-4);
                        assert!(is_named || !is_there, "{scale:?}, texel {texel}: {names:?}");
                    }
                }
            }
            // Where three overlap, by their heights.
            let middle = rectangle.coordinate(Vec2::new(0.3, 0.2)) * 16.0;
            let [column, row] = [middle.x, middle.y].map(|at| at.floor());
            let list = map.texels.iter().zip(0_u16..).find_map(|(list, texel)| {
                let is_it = [texel % 16, texel / 16].map(f32::from) == [column, row];
                is_it.then_some(list)
            });
            let centres: Vec<f32> = list
                .expect("it is in the map")
                .iter()
                .map(|&leaf| map.leaves[leaf as usize])
                .map(|entry| (entry[0] + 0.5 * entry[3] * square.x) * rectangle.sides().x)
                .map(|x| x + rectangle.least.x)
                .collect();
            for (found, wanted) in centres.iter().zip([0.3, 0.4, 0.0]) {
                assert!((found - wanted).abs() < 1e-4, "{centres:?}");
            }
            assert_eq!(
                map.most as usize,
                map.texels.iter().map(Vec::len).max().unwrap_or(0)
            );
        }
    }

    #[test]
    fn lists_take_what_they_hold_and_no_more_than_there_is_room() {
        let (impostor, shapes) = impostor(&PLACES);
        let options = CardOptions {
            map: 16,
            ..CardOptions::USUAL
        };
        let turns = SpriteTurns::new(4);
        let map_in = |room| leaf_map(&impostor, (&shapes, &turns), &options, room);
        let map = map_in(10_000).expect("there is room");
        let entries: usize = map.texels.iter().map(Vec::len).sum();
        assert_eq!(map.entries, entries);
        assert!(map_in(entries).is_some() && map_in(entries - 1).is_none());
        let sheet = MapSheet::of(&[map.clone(), map.clone(), map.clone()], 16);
        assert_eq!((sheet.columns, sheet.map.size), (2, [32, 32]));
        let [width, rows] = sheet.list.size;
        let room = 4 * (width * rows) as usize;
        assert!((3 * entries..3 * entries + 4 * (width as usize + 1)).contains(&room));
        assert_eq!(sheet.leaves.texels[5..10], map.leaves);
        // Each texel's list lies where the map says.
        let (mut named, mut texels) = (0, 0);
        for (number, texel) in sheet.map.texels.iter().enumerate() {
            let [x, y] = [number % 32, number / 32];
            let own = &map.texels[y % 16 * 16 + x % 16];
            let is_third = x / 16 + 2 * (y / 16) < 3;
            let [first, count] =
                [texel[0], texel[1]].map(|value| whole_u32(f64::from(value)) as usize);
            let list = &sheet.list.texels.as_flattened()[first..first + count];
            let of_map = 5 * (x / 16 + 2 * (y / 16));
            let wanted = own.iter().map(|&leaf| (leaf as usize + of_map) as f32);
            let is_same = list.iter().copied().eq(wanted);
            assert!(is_same || !is_third && count == 0, "{x}, {y}");
            named += count;
            texels += usize::from(count > 0);
        }
        assert_eq!(named, 3 * entries);
        assert_eq!(sheet.usual_count as usize, named.div_ceil(texels));
        assert_eq!(LeafMapFacts::of(&[map]).entries, entries as u64);
        assert_eq!((MapSheet::room(512), square_side(5)), (256, 3));
    }
}
