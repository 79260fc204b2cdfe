//! Forests: trees of a few species, each grown once, that stand over an area.
//!
//! ```text
//!  [[forest]] ─ForestChoice─▶ Forest::new ─▶ where each stands (x, z), turn, scale
//!                                              └─ trees(terrain) ─▶ Tree, Tree, … on the ground
//! ```
//!
//! **Invariant.** Where a tree of a scattered forest stands depends on the trees before it alone: a
//! species that is added at the end moves none of the others.

use super::terrain::Terrain;
use super::{PlantSource, Tree};
use crate::math::{Digest, Stream, Vec3, index_usize};

/// What is asked of a forest.
#[derive(Debug, Clone, PartialEq)]
pub struct ForestChoice {
    /// The species, at least one.
    pub species: Vec<ForestSpecies>,
    /// The seed that the plants grow from.
    pub plant_seed: u64,
    /// Trees of each species.
    pub count: u32,
    /// The seed of places, turns and scales.
    pub seed: u64,
    /// How places are found.
    pub layout: Layout,
    /// Where the trees stand.
    pub area: Area,
    /// The least distance between two trunks of this forest: metres, above 0.
    pub spacing: f32,
    /// The least and the greatest factor on a tree's size; between, all are as likely.
    pub scale: [f32; 2],
}

/// A species of a forest.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ForestSpecies {
    /// The species file, relative to the scene file.
    pub path: String,
    /// As [`Tree::plant_digest`].
    pub plant_digest: Option<Digest>,
}

/// How the places of trees are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Each tree where chance puts it, if it is not too near to those before: up to
    /// [`Forest::DARTS`] tries. All trees of the first species come first.
    Scattered,
    /// At the corners of squares, row by row from the area's first corner, the species in turn.
    Grid,
    /// In patches of one tree of each species, all alike but for a quarter turn or three: squares of a
    /// `spacing` for each tree, row by row from the area's first corner. A patch is level.
    Patches,
}

impl Layout {
    /// The names in scene files.
    pub const NAMES: &[&str] = &["scattered", "grid", "patches"];

    /// The layout of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "scattered" => Some(Self::Scattered),
            "grid" => Some(Self::Grid),
            "patches" => Some(Self::Patches),
            _ => None,
        }
    }

    /// The name in scene files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Scattered => "scattered",
            Self::Grid => "grid",
            Self::Patches => "patches",
        }
    }
}

/// A rectangle of ground: x and z in world space, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    least: [f32; 2],
    greatest: [f32; 2],
}

impl Area {
    /// From `[x0, z0, x1, z1]`, finite and with `x0 < x1` and `z0 < z1`; else `None`.
    #[must_use]
    pub fn new([x0, z0, x1, z1]: [f32; 4]) -> Option<Self> {
        let sound = [x0, z0, x1, z1].iter().all(|number| number.is_finite());
        (sound && x0 < x1 && z0 < z1).then_some(Self {
            least: [x0, z0],
            greatest: [x1, z1],
        })
    }

    /// A square with the origin in its middle.
    pub(super) fn around_origin(side: f32) -> Self {
        let half = 0.5 * side;
        Self {
            least: [-half; 2],
            greatest: [half; 2],
        }
    }

    /// `[x0, z0, x1, z1]`.
    #[must_use]
    pub fn corners(&self) -> [f32; 4] {
        let ([x0, z0], [x1, z1]) = (self.least, self.greatest);
        [x0, z0, x1, z1]
    }

    /// Whether a point lies within or on the rim.
    #[must_use]
    pub fn contains(&self, x: f32, z: f32) -> bool {
        let [x0, z0, x1, z1] = self.corners();
        (x0..=x1).contains(&x) && (z0..=z1).contains(&z)
    }

    fn sides(self) -> [f32; 2] {
        [0, 1].map(|axis| self.greatest[axis] - self.least[axis])
    }
}

/// Fewer trees fit than are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{wanted} trees, room for {fit} at that spacing")]
pub struct NoRoom {
    /// How many found a place, of all species.
    pub fit: usize,
    /// How many were asked for.
    pub wanted: usize,
}

/// A forest whose trees have found their places.
#[derive(Debug, Clone, PartialEq)]
pub struct Forest {
    asked: ForestChoice,
    stands: Vec<Stand>,
    patches: Option<Patches>,
}

/// What a forest of patches is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct Patches {
    /// The trees of a patch: their species, in order.
    pub samples: Vec<PatchSample>,
    /// Where the patches stand: the middle of each on the ground (x, z), and its turn in degrees.
    pub places: Vec<([f32; 2], f32)>,
}

/// A tree of a patch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PatchSample {
    /// From the patch's middle (x, z), metres.
    pub offset: [f32; 2],
    /// In degrees about +Y.
    pub turn: f32,
    /// The factor on its size.
    pub scale: f32,
}

/// Where and how one tree stands.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Stand {
    species: usize,
    place: [f32; 2],
    /// The middle of its patch, which has the height of the ground there.
    middle: Option<[f32; 2]>,
    turn: f32,
    scale: f32,
}

/// The stream of a forest's places, turns and scales.
const STANDS: u64 = 0x666f_7265_7374;

impl Forest {
    /// How often a place is looked for before a tree counts as without room.
    pub const DARTS: u64 = 200;

    /// Finds a place for every tree.
    ///
    /// # Errors
    ///
    /// [`NoRoom`] when they do not fit.
    pub fn new(asked: ForestChoice) -> Result<Self, NoRoom> {
        let places = match asked.layout {
            Layout::Scattered => scattered(&asked),
            Layout::Grid => grid(&asked),
            Layout::Patches => return Self::of_patches(asked),
        };
        let wanted = asked.species.len() * asked.count as usize;
        if places.len() < wanted {
            let fit = places.len();
            return Err(NoRoom { fit, wanted });
        }
        let stream = Stream::new(asked.seed, STANDS);
        let [least, greatest] = asked.scale;
        let stand = |(number, place): (u64, [f32; 2])| {
            let looks = stream.child(number).child(1);
            let order = index_usize(number);
            Stand {
                species: match asked.layout {
                    Layout::Scattered => order / asked.count as usize,
                    Layout::Grid | Layout::Patches => order % asked.species.len(),
                },
                place,
                middle: None,
                turn: 360.0 * looks.unit(0),
                scale: (least + (greatest - least) * looks.unit(1)).clamp(least, greatest),
            }
        };
        let stands = (0..).zip(places).map(stand).collect();
        Ok(Self {
            asked,
            stands,
            patches: None,
        })
    }

    fn of_patches(asked: ForestChoice) -> Result<Self, NoRoom> {
        let patches = Patches::of(&asked);
        let wanted = asked.species.len() * asked.count as usize;
        let fit = patches.places.len() * asked.species.len();
        if fit < wanted {
            return Err(NoRoom { fit, wanted });
        }
        let stand = |&([x, z], turn): &([f32; 2], f32)| {
            let samples = (0..).zip(&patches.samples);
            let stands = samples.map(move |(species, sample)| {
                let [dx, dz] = turned(sample.offset, turn);
                Stand {
                    species,
                    place: [x + dx, z + dz],
                    middle: Some([x, z]),
                    turn: (turn + sample.turn) % 360.0,
                    scale: sample.scale,
                }
            });
            stands.collect::<Vec<_>>()
        };
        Ok(Self {
            stands: patches.places.iter().flat_map(stand).collect(),
            asked,
            patches: Some(patches),
        })
    }

    /// What it is made of, where it stands in patches; its trees follow patch by patch.
    #[must_use]
    pub fn patches(&self) -> Option<&Patches> {
        self.patches.as_ref()
    }

    /// Whether it stands in patches.
    #[must_use]
    pub fn is_of_patches(&self) -> bool {
        self.patches.is_some()
    }

    /// What was asked for.
    #[must_use]
    pub fn asked(&self) -> &ForestChoice {
        &self.asked
    }

    /// The species, to name other files or pin their plants.
    pub fn species_mut(&mut self) -> &mut [ForestSpecies] {
        &mut self.asked.species
    }

    /// Trees of all species.
    #[must_use]
    pub fn tree_count(&self) -> usize {
        self.stands.len()
    }

    /// The species of each tree, as its number in the list.
    pub fn species_of_trees(&self) -> impl Iterator<Item = usize> + '_ {
        self.stands.iter().map(|stand| stand.species)
    }

    /// The trees, on the terrain, or at height 0 without one.
    pub fn trees<'a>(
        &'a self,
        terrain: Option<&'a Terrain>,
    ) -> impl Iterator<Item = Tree> + use<'a> {
        self.stands.iter().map(move |stand| {
            let [x, z] = stand.place;
            let [middle_x, middle_z] = stand.middle.unwrap_or(stand.place);
            let species = &self.asked.species[stand.species];
            Tree {
                source: PlantSource::Species(species.path.clone()),
                seed: self.asked.plant_seed,
                at: Vec3::new(
                    x,
                    terrain.map_or(0.0, |ground| ground.height(middle_x, middle_z)),
                    z,
                ),
                turn: stand.turn,
                scale: stand.scale,
                plant_digest: species.plant_digest,
            }
        })
    }
}

impl Patches {
    /// As many as are wanted or fit.
    fn of(asked: &ForestChoice) -> Self {
        let stream = Stream::new(asked.seed, STANDS);
        let side = (1..).find(|side| side * side >= asked.species.len());
        let side = side.unwrap_or(1);
        let [least, greatest] = asked.scale;
        let sample = |number: usize| {
            let looks = stream.child(number as u64).child(1);
            // Within the middle half of its square, so that neighbours keep half a spacing.
            let along = |at: usize, draw: u64| {
                let middle = at as f32 + 0.5 - 0.5 * side as f32;
                asked.spacing * (middle + 0.5 * (looks.unit(draw) - 0.5))
            };
            PatchSample {
                offset: [along(number % side, 2), along(number / side, 3)],
                turn: 360.0 * looks.unit(0),
                scale: (least + (greatest - least) * looks.unit(1)).clamp(least, greatest),
            }
        };
        let square = f64::from(asked.spacing) * side as f64;
        // A side of several squares, but for rounding, has room for all of them.
        let [columns, rows] = asked
            .area
            .sides()
            .map(|side| whole((f64::from(side) / square + 1e-6).floor()));
        let [x0, z0] = asked.area.least;
        let middle = |number: usize| {
            #[expect(clippy::cast_possible_truncation, reason = "rounded once, at the end")]
            let along = |from: f32, squares: usize| {
                (f64::from(from) + (squares as f64 + 0.5) * square) as f32
            };
            [along(x0, number % columns), along(z0, number / columns)]
        };
        let fit = columns.saturating_mul(rows).min(asked.count as usize);
        let middles = (0..fit).map(middle);
        let place = |(number, middle): (u64, [f32; 2])| {
            let quarters = stream.child(number).child(2).unit(0) * 4.0;
            (middle, 90.0 * quarters.floor().min(3.0))
        };
        Self {
            samples: (0..asked.species.len()).map(sample).collect(),
            places: (0..).zip(middles).map(place).collect(),
        }
    }
}

/// A way on the ground turned by quarters about +Y.
fn turned([x, z]: [f32; 2], degrees: f32) -> [f32; 2] {
    match degrees {
        90.0 => [z, -x],
        180.0 => [-x, -z],
        270.0 => [-z, x],
        _ => [x, z],
    }
}

/// Places in rows and columns, as many as are wanted or fit.
fn grid(asked: &ForestChoice) -> Vec<[f32; 2]> {
    let [x0, z0] = asked.area.least;
    let wanted = asked.species.len() * asked.count as usize;
    let spacing = f64::from(asked.spacing);
    // A side of several spacings, but for rounding, has room for one more tree than spacings.
    let [columns, rows] = asked
        .area
        .sides()
        .map(|side| whole((f64::from(side) / spacing + 1e-6).floor()) + 1);
    let fit = columns.saturating_mul(rows).min(wanted);
    let place = |number: usize| {
        #[expect(clippy::cast_possible_truncation, reason = "rounded once, at the end")]
        let along = |from: f32, steps: usize| (f64::from(from) + steps as f64 * spacing) as f32;
        [along(x0, number % columns), along(z0, number / columns)]
    };
    (0..fit).map(place).collect()
}

/// Places by chance, as many as are wanted or until a tree finds none.
fn scattered(asked: &ForestChoice) -> Vec<[f32; 2]> {
    let stream = Stream::new(asked.seed, STANDS);
    let mut taken = Taken::new(asked.area, asked.spacing);
    let sides = asked.area.sides();
    let wanted = asked.species.len() * asked.count as usize;
    let mut places = Vec::with_capacity(wanted);
    for number in 0..wanted as u64 {
        let darts = stream.child(number).child(0);
        let found = (0..Forest::DARTS).find_map(|dart| {
            let place = [0, 1].map(|axis| {
                let along = darts.unit(2 * dart + axis as u64);
                let least = asked.area.least[axis];
                (least + sides[axis] * along).min(asked.area.greatest[axis])
            });
            taken.is_free(place).then_some(place)
        });
        let Some(place) = found else {
            break;
        };
        taken.add(place);
        places.push(place);
    }
    places
}

/// Places that are taken, in cells at least as wide as the spacing.
struct Taken {
    first: [f32; 2],
    cell: f32,
    spacing: f32,
    columns: usize,
    rows: usize,
    cells: Vec<Vec<[f32; 2]>>,
}

impl Taken {
    /// The most cells a side: few enough for any area.
    const CELLS: f32 = 256.0;

    fn new(area: Area, spacing: f32) -> Self {
        let [width, depth] = area.sides();
        let cell = spacing.max(width.max(depth) / Self::CELLS);
        let count = |side: f32| whole(f64::from(side / cell).floor()) + 1;
        let (columns, rows) = (count(width), count(depth));
        Self {
            first: area.least,
            cell,
            spacing,
            columns,
            rows,
            cells: vec![Vec::new(); columns * rows],
        }
    }

    /// The cell of a place, one more than asked for where rounding says so.
    fn cell(&self, place: [f32; 2]) -> [usize; 2] {
        let along = |axis: usize, count: usize| {
            let cells = f64::from((place[axis] - self.first[axis]) / self.cell);
            whole(cells.floor()).min(count - 1)
        };
        [along(0, self.columns), along(1, self.rows)]
    }

    fn is_free(&self, [x, z]: [f32; 2]) -> bool {
        let [column, row] = self.cell([x, z]);
        let near = |at: usize, count: usize| at.saturating_sub(1)..(at + 2).min(count);
        near(row, self.rows).all(|row| {
            near(column, self.columns).all(|column| {
                self.cells[row * self.columns + column].iter().all(|other| {
                    let (dx, dz) = (f64::from(x - other[0]), f64::from(z - other[1]));
                    let spacing = f64::from(self.spacing);
                    dx * dx + dz * dz >= spacing * spacing
                })
            })
        })
    }

    fn add(&mut self, place: [f32; 2]) {
        let [column, row] = self.cell(place);
        self.cells[row * self.columns + column].push(place);
    }
}

/// A whole number that is not negative.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a float becomes a count by the language's saturating cast"
)]
fn whole(number: f64) -> usize {
    number.min(f64::from(u32::MAX - 1)) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choice(names: &[&str], layout: Layout, count: u32, spacing: f32) -> ForestChoice {
        let species = |path: &&str| ForestSpecies {
            path: (*path).to_owned(),
            plant_digest: None,
        };
        ForestChoice {
            species: names.iter().map(species).collect(),
            plant_seed: 1,
            count,
            seed: 5,
            layout,
            area: Area::new([-20.0, 10.0, 30.0, 40.0]).expect("ascending"),
            spacing,
            scale: [0.5, 1.5],
        }
    }

    fn distance(one: &Tree, other: &Tree) -> f32 {
        let apart = one.at - other.at;
        (apart.x * apart.x + apart.z * apart.z).sqrt()
    }

    #[test]
    fn trees_keep_their_distance_and_stay_inside() {
        let forest = Forest::new(choice(&["a", "b", "c"], Layout::Scattered, 20, 3.0)).unwrap();
        let trees: Vec<Tree> = forest.trees(None).collect();
        assert_eq!(trees.len(), 60);
        for (number, tree) in trees.iter().enumerate() {
            assert!(
                forest.asked().area.contains(tree.at.x, tree.at.z),
                "{tree:?}"
            );
            assert!((0.5..=1.5).contains(&tree.scale) && (0.0..360.0).contains(&tree.turn));
            for other in &trees[..number] {
                assert!(distance(tree, other) > 2.999, "{tree:?} {other:?}");
            }
        }
        // All of the first species come first, and a fourth moves nobody.
        let more = choice(&["a", "b", "c", "d"], Layout::Scattered, 20, 3.0);
        let more = Forest::new(more).unwrap();
        assert_eq!(more.trees(None).take(60).collect::<Vec<_>>(), trees);
        assert!(more.species_of_trees().is_sorted());
    }

    #[test]
    fn grids_run_from_corner_to_corner() {
        // 50 m by 30 m in squares of 10 m: six columns, four rows.
        let forest = Forest::new(choice(&["a", "b"], Layout::Grid, 12, 10.0)).unwrap();
        let trees: Vec<Tree> = forest.trees(None).collect();
        assert_eq!(trees[0].at, Vec3::new(-20.0, 0.0, 10.0));
        assert_eq!(trees[7].at, Vec3::new(-10.0, 0.0, 20.0));
        assert_eq!(trees[23].at, Vec3::new(30.0, 0.0, 40.0));
        assert_eq!(trees[3].source, PlantSource::Species("b".to_owned()));
    }

    #[test]
    fn those_that_do_not_fit_are_counted() {
        let wanted = NoRoom {
            fit: 24,
            wanted: 26,
        };
        let crowded = choice(&["a", "b"], Layout::Grid, 13, 10.0);
        assert_eq!(Forest::new(crowded), Err(wanted));
        let crowded = choice(&["a"], Layout::Scattered, 10_000, 10.0);
        let NoRoom { fit, wanted } = Forest::new(crowded).unwrap_err();
        assert_eq!(wanted, 10_000);
        assert!((8..=24).contains(&fit), "{fit}");
        // The whole world is not cut into more cells than memory holds.
        let mut alone = choice(&["a"], Layout::Scattered, 1, 0.01);
        alone.area = Area::new([-1e5, -1e5, 1e5, 1e5]).unwrap();
        assert_eq!(Forest::new(alone).unwrap().tree_count(), 1);
    }
}
