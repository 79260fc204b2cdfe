//! Species out of TOML: what a file may say, and errors with line and column where it says otherwise.

use std::ops::RangeInclusive;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use super::{
    Blade, Clump, Crown, FoliageKind, LeafHabit, Pruning, SPECIES_SCHEMA, Shape, Species,
    StemLevel, Wood,
};
use crate::document::{Document, DocumentError};
use crate::limits;
use crate::plant::Silhouette;

impl Species {
    /// Reads a species file.
    ///
    /// # Errors
    ///
    /// When the file cannot be read, is no TOML, holds an unknown key, a value of the wrong type or
    /// one out of its range: with file, line and column, what was found and what would be right.
    pub fn read(path: &Path) -> Result<Self, DocumentError> {
        Self::parse(&Document::read(path)?)
    }

    /// The species that a document describes.
    ///
    /// # Errors
    ///
    /// As [`Species::read`], once the file is read.
    pub fn parse(document: &Document) -> Result<Self, DocumentError> {
        let raw: RawSpecies = document.parse_toml()?;
        Reader { document }.species(raw)
    }
}

type Number = Option<Spanned<f64>>;
type Levels = Option<[Spanned<f64>; 4]>;
type Whole = Option<Spanned<i64>>;
type WholeLevels = Option<[Spanned<i64>; 4]>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawSpecies {
    schema: Spanned<String>,
    name: Spanned<String>,
    #[serde(default)]
    latin: String,
    leaf_count: Whole,
    stop_leaves: Whole,
    trunk_polygons: Whole,
    #[serde(default)]
    crown: RawCrown,
    #[serde(default)]
    clump: RawClump,
    #[serde(default)]
    wood: RawWood,
    #[serde(default)]
    stems: RawStems,
    #[serde(default)]
    leaves: RawLeaves,
    foliage: Spanned<Vec<RawFoliage>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RawCrown {
    shape: Option<Shape>,
    levels: Whole,
    base_size: Number,
    scale: Number,
    scale_v: Number,
    vertical_scale: Number,
    vertical_scale_v: Number,
    attraction_up: Levels,
    prune_ratio: Number,
    prune_width: Number,
    prune_width_peak: Number,
    prune_power_low: Number,
    prune_power_high: Number,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RawClump {
    count: Whole,
    radius: Number,
    lean: Number,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RawWood {
    ratio: Number,
    ratio_power: Number,
    lobes: Whole,
    lobe_depth: Number,
    flare: Number,
    trunk_scale: Number,
    trunk_scale_v: Number,
    base_splits: Whole,
    bark_color: Option<Spanned<String>>,
    tube_edges: WholeLevels,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RawStems {
    length: Levels,
    length_v: Levels,
    taper: Levels,
    segment_splits: Levels,
    split_angle: Levels,
    split_angle_v: Levels,
    curve_res: WholeLevels,
    curve: Levels,
    curve_back: Levels,
    curve_v: Levels,
    down_angle: Levels,
    down_angle_v: Levels,
    rotate: Levels,
    rotate_v: Levels,
    branches: Levels,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RawLeaves {
    per_stem: Number,
    bend: Number,
    attraction_up: Number,
    bare: Number,
    omit: Option<Spanned<Vec<Spanned<i64>>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFoliage {
    silhouette: Silhouette,
    share: Number,
    length: Number,
    length_v: Number,
    width: Number,
    color: Option<Spanned<String>>,
    faces: Whole,
    droop: Number,
    fold: Number,
    needle_diameter: Number,
}

/// The most leaves, and the most trunk triangles, that a species may ask for.
#[expect(clippy::cast_possible_wrap, reason = "four millions fit")]
const MOST: i64 = limits::GROWN_LEAVES as i64;

/// The most faces of a leaf.
const MOST_FACES: i64 = 64;

/// Turns raw tables into checked ones; every default and range of the table of keys is stated here.
#[derive(Clone, Copy)]
struct Reader<'a> {
    document: &'a Document,
}

impl Reader<'_> {
    fn species(self, raw: RawSpecies) -> Result<Species, DocumentError> {
        if raw.schema.get_ref() != SPECIES_SCHEMA {
            let found = raw.schema.get_ref();
            let wanted = format!("schema is {found:?}, wanted {SPECIES_SCHEMA:?}");
            return Err(self.wrong(&raw.schema, wanted));
        }
        if raw.name.get_ref().trim().is_empty() {
            return Err(self.wrong(&raw.name, "name is empty, wanted what people call the tree"));
        }
        let leaf_count = self.count("leaf_count", &raw.leaf_count, 1..=MOST)?;
        let stop_leaves = self.count("stop_leaves", &raw.stop_leaves, 1..=MOST)?;
        if let (Some(stop), Some(leaves), Some(span)) = (stop_leaves, leaf_count, &raw.stop_leaves)
            && stop > leaves
        {
            let wanted = format!("stop_leaves is {stop}, wanted at most leaf_count = {leaves}");
            return Err(self.wrong(span, wanted));
        }
        let kinds = raw.foliage.get_ref().len();
        if !(1..=limits::SPECIES_KINDS).contains(&kinds) {
            let wanted = format!(
                "{kinds} tables [[foliage]], wanted 1..={}",
                limits::SPECIES_KINDS
            );
            return Err(self.wrong(&raw.foliage, wanted));
        }
        Ok(Species {
            name: raw.name.into_inner(),
            latin: raw.latin,
            leaf_count,
            stop_leaves,
            trunk_polygons: self.count("trunk_polygons", &raw.trunk_polygons, 0..=MOST)?,
            crown: self.crown(&raw.crown)?,
            clump: Clump {
                count: self.whole("clump.count", &raw.clump.count, 1, 1..=200)?,
                radius: self.number("clump.radius", &raw.clump.radius, 0.0, 0.0..=20.0)?,
                lean: self.number("clump.lean", &raw.clump.lean, 0.0, 0.0..=90.0)?,
            },
            wood: self.wood(&raw.wood)?,
            stems: self.stems(&raw.stems)?,
            leaves: LeafHabit {
                per_stem: self.number(
                    "leaves.per_stem",
                    &raw.leaves.per_stem,
                    25.0,
                    -500.0..=500.0,
                )?,
                bend: self.number("leaves.bend", &raw.leaves.bend, 0.0, 0.0..=1.0)?,
                attraction_up: self.number(
                    "leaves.attraction_up",
                    &raw.leaves.attraction_up,
                    0.0,
                    -10.0..=10.0,
                )?,
                bare: self.number("leaves.bare", &raw.leaves.bare, 0.0, 0.0..=0.95)?,
            },
            omitted_leaves: self.omitted(raw.leaves.omit.as_ref())?,
            foliage: raw
                .foliage
                .get_ref()
                .iter()
                .map(|kind| self.foliage(kind))
                .collect::<Result<_, _>>()?,
        })
    }

    fn omitted(self, raw: Option<&Spanned<Vec<Spanned<i64>>>>) -> Result<Vec<u32>, DocumentError> {
        let Some(raw) = raw else {
            return Ok(Vec::new());
        };
        let (found, most) = (raw.get_ref().len(), Species::MAX_OMITTED);
        if found > most {
            let message = format!("leaves.omit has {found} numbers, wanted at most {most}");
            return Err(self.wrong(raw, message));
        }
        let mut numbers: Vec<u32> = Vec::with_capacity(found);
        for entry in raw.get_ref() {
            let number = self.integer("leaves.omit", entry, &(0..=MOST - 1))?;
            if let Some(before) = numbers.last().filter(|before| **before >= number) {
                let message = format!("leaves.omit has {number} after {before}, wanted ascending");
                return Err(self.wrong(entry, message));
            }
            numbers.push(number);
        }
        Ok(numbers)
    }

    fn crown(self, raw: &RawCrown) -> Result<Crown, DocumentError> {
        let number = |key, found, default, range| self.number(key, found, default, range);
        let scale = number("crown.scale", &raw.scale, 13.0, 0.05..=150.0)?;
        let scale_v = number("crown.scale_v", &raw.scale_v, 0.0, 0.0..=149.0)?;
        self.less("crown.scale_v", &raw.scale_v, scale_v, scale)?;
        let key = "crown.vertical_scale";
        let vertical_scale = number(key, &raw.vertical_scale, 1.0, 0.1..=10.0)?;
        let key = "crown.vertical_scale_v";
        let vertical_scale_v = number(key, &raw.vertical_scale_v, 0.0, 0.0..=9.0)?;
        self.less(key, &raw.vertical_scale_v, vertical_scale_v, vertical_scale)?;
        Ok(Crown {
            shape: raw.shape.unwrap_or(Shape::TendFlame),
            levels: self.whole("crown.levels", &raw.levels, 3, 1..=4)?,
            base_size: number("crown.base_size", &raw.base_size, 0.4, 0.0..=0.95)?,
            scale,
            scale_v,
            vertical_scale,
            vertical_scale_v,
            attraction_up: self.levels(
                "crown.attraction_up",
                &raw.attraction_up,
                [0.0, 0.0, 0.5, 0.5],
                -10.0..=10.0,
            )?,
            pruning: Pruning {
                ratio: number("crown.prune_ratio", &raw.prune_ratio, 0.0, 0.0..=1.0)?,
                width: number("crown.prune_width", &raw.prune_width, 0.5, 0.0..=10.0)?,
                width_peak: number(
                    "crown.prune_width_peak",
                    &raw.prune_width_peak,
                    0.5,
                    0.0..=1.0,
                )?,
                power_low: number(
                    "crown.prune_power_low",
                    &raw.prune_power_low,
                    0.5,
                    0.0..=10.0,
                )?,
                power_high: number(
                    "crown.prune_power_high",
                    &raw.prune_power_high,
                    0.5,
                    0.0..=10.0,
                )?,
            },
        })
    }

    fn wood(self, raw: &RawWood) -> Result<Wood, DocumentError> {
        let number = |key, found, default, range| self.number(key, found, default, range);
        let trunk_scale = number("wood.trunk_scale", &raw.trunk_scale, 1.0, 0.01..=10.0)?;
        let key = "wood.trunk_scale_v";
        let trunk_scale_v = number(key, &raw.trunk_scale_v, 0.0, 0.0..=9.0)?;
        self.less(key, &raw.trunk_scale_v, trunk_scale_v, trunk_scale)?;
        let tube_edges =
            self.whole_levels("wood.tube_edges", &raw.tube_edges, [12, 6, 4, 3], 0..=64)?;
        if let (Some(found), Some(level)) = (
            &raw.tube_edges,
            tube_edges.iter().position(|edges| (1..3).contains(edges)),
        ) {
            let edges = tube_edges[level];
            let wanted = format!("wood.tube_edges holds {edges}, wanted 0 or at least 3");
            return Err(self.wrong(&found[level], wanted));
        }
        Ok(Wood {
            ratio: number("wood.ratio", &raw.ratio, 0.015, 0.0001..=0.5)?,
            ratio_power: number("wood.ratio_power", &raw.ratio_power, 1.2, 0.0..=10.0)?,
            lobes: self.whole("wood.lobes", &raw.lobes, 0, 0..=32)?,
            lobe_depth: number("wood.lobe_depth", &raw.lobe_depth, 0.0, 0.0..=0.9)?,
            flare: number("wood.flare", &raw.flare, 0.0, 0.0..=10.0)?,
            trunk_scale,
            trunk_scale_v,
            base_splits: self.whole("wood.base_splits", &raw.base_splits, 0, 0..=10)?,
            bark_color: self.color(
                "wood.bark_color",
                raw.bark_color.as_ref(),
                [0x6b, 0x5d, 0x4d],
            )?,
            tube_edges,
        })
    }

    fn stems(self, raw: &RawStems) -> Result<[StemLevel; 4], DocumentError> {
        let levels = |key, found, default, range| self.levels(key, found, default, range);
        let turn = -720.0..=720.0;
        let half = -180.0..=180.0;
        let none = [0.0; 4];
        let length = levels("stems.length", &raw.length, [1.0, 0.3, 0.6, 0.0], 0.0..=4.0)?;
        let length_v = levels("stems.length_v", &raw.length_v, none, 0.0..=4.0)?;
        let taper = levels("stems.taper", &raw.taper, [1.0; 4], 0.0..=3.0)?;
        let key = "stems.segment_splits";
        let segment_splits = levels(key, &raw.segment_splits, none, 0.0..=4.0)?;
        let split_angle = levels("stems.split_angle", &raw.split_angle, none, 0.0..=180.0)?;
        let key = "stems.split_angle_v";
        let split_angle_v = levels(key, &raw.split_angle_v, none, 0.0..=180.0)?;
        let curve_res =
            self.whole_levels("stems.curve_res", &raw.curve_res, [3, 5, 3, 1], 1..=64)?;
        let default = [0.0, -40.0, -40.0, 0.0];
        let curve = levels("stems.curve", &raw.curve, default, turn.clone())?;
        let curve_back = levels("stems.curve_back", &raw.curve_back, none, turn.clone())?;
        let default = [20.0, 50.0, 75.0, 0.0];
        let curve_v = levels("stems.curve_v", &raw.curve_v, default, turn)?;
        let default = [0.0, 60.0, 45.0, 45.0];
        let down_angle = levels("stems.down_angle", &raw.down_angle, default, half.clone())?;
        let default = [0.0, -50.0, 10.0, 10.0];
        let down_angle_v = levels("stems.down_angle_v", &raw.down_angle_v, default, half)?;
        let default = [0.0, 140.0, 140.0, 77.0];
        let rotate = levels("stems.rotate", &raw.rotate, default, -360.0..=360.0)?;
        let rotate_v = levels("stems.rotate_v", &raw.rotate_v, none, 0.0..=360.0)?;
        let default = [1.0, 50.0, 30.0, 10.0];
        let branches = levels("stems.branches", &raw.branches, default, 0.0..=2000.0)?;
        Ok([0, 1, 2, 3].map(|level: usize| StemLevel {
            length: length[level],
            length_v: length_v[level],
            taper: taper[level],
            segment_splits: segment_splits[level],
            split_angle: split_angle[level],
            split_angle_v: split_angle_v[level],
            curve_res: curve_res[level],
            curve: curve[level],
            curve_back: curve_back[level],
            curve_v: curve_v[level],
            down_angle: down_angle[level],
            down_angle_v: down_angle_v[level],
            rotate: rotate[level],
            rotate_v: rotate_v[level],
            branches: branches[level],
        }))
    }

    fn foliage(self, raw: &RawFoliage) -> Result<FoliageKind, DocumentError> {
        let number = |key, found, default, range| self.number(key, found, default, range);
        Ok(FoliageKind {
            silhouette: raw.silhouette,
            share: number("foliage.share", &raw.share, 1.0, 0.001..=1000.0)?,
            length: number("foliage.length", &raw.length, 0.17, 0.001..=5.0)?,
            length_v: number("foliage.length_v", &raw.length_v, 0.0, 0.0..=0.9)?,
            width: number("foliage.width", &raw.width, 1.0, 0.02..=5.0)?,
            color: self.color("foliage.color", raw.color.as_ref(), [0x4f, 0x7a, 0x2c])?,
            blade: self.blade(raw)?,
        })
    }

    fn blade(self, raw: &RawFoliage) -> Result<Blade, DocumentError> {
        let faces = self.whole("foliage.faces", &raw.faces, 2, 2..=MOST_FACES)?;
        if let Some(found) = raw.faces.as_ref().filter(|_| faces % 2 == 1) {
            let wanted = format!("foliage.faces is {faces}, wanted an even number");
            return Err(self.wrong(found, wanted));
        }
        let droop = self.number("foliage.droop", &raw.droop, 0.0, -180.0..=180.0)?;
        let fold = self.number("foliage.fold", &raw.fold, 0.0, -80.0..=80.0)?;
        let key = "foliage.needle_diameter";
        let diameter = self.number(key, &raw.needle_diameter, 0.001, 0.0001..=0.1)?;
        if let Some(found) = &raw.needle_diameter {
            if raw.faces.is_some() || raw.droop.is_some() || raw.fold.is_some() {
                let wanted = "foliage.needle_diameter is given, wanted no faces, droop or fold";
                return Err(self.wrong(found, wanted.to_owned()));
            }
            return Ok(Blade::Needle { diameter });
        }
        if faces > 2 {
            return Ok(Blade::Bent { faces, droop, fold });
        }
        for (key, found) in [("droop", &raw.droop), ("fold", &raw.fold)] {
            if let Some(found) = found {
                let wanted =
                    format!("foliage.{key} is given, wanted foliage.faces of at least 4 with it");
                return Err(self.wrong(found, wanted));
            }
        }
        Ok(Blade::Flat)
    }

    fn number(
        self,
        key: &str,
        found: &Number,
        default: f32,
        range: RangeInclusive<f32>,
    ) -> Result<f32, DocumentError> {
        found
            .as_ref()
            .map_or(Ok(default), |value| self.real(key, value, &range))
    }

    fn levels(
        self,
        key: &str,
        found: &Levels,
        default: [f32; 4],
        range: RangeInclusive<f32>,
    ) -> Result<[f32; 4], DocumentError> {
        let mut levels = default;
        for (level, value) in levels.iter_mut().zip(found.iter().flatten()) {
            *level = self.real(key, value, &range)?;
        }
        Ok(levels)
    }

    /// The value as `f32`; the comparison is false for NaN, so that it is refused too.
    fn real(
        self,
        key: &str,
        value: &Spanned<f64>,
        range: &RangeInclusive<f32>,
    ) -> Result<f32, DocumentError> {
        let found = *value.get_ref();
        #[expect(
            clippy::cast_possible_truncation,
            reason = "rounding to f32 is meant; what overflows becomes infinite and is refused"
        )]
        let rounded = found as f32;
        if range.contains(&rounded) {
            return Ok(rounded);
        }
        let (least, most) = (range.start(), range.end());
        Err(self.wrong(value, format!("{key} is {found}, wanted {least}..={most}")))
    }

    fn count(
        self,
        key: &str,
        found: &Whole,
        range: RangeInclusive<i64>,
    ) -> Result<Option<u32>, DocumentError> {
        found
            .as_ref()
            .map(|value| self.integer(key, value, &range))
            .transpose()
    }

    fn whole(
        self,
        key: &str,
        found: &Whole,
        default: u32,
        range: RangeInclusive<i64>,
    ) -> Result<u32, DocumentError> {
        Ok(self.count(key, found, range)?.unwrap_or(default))
    }

    fn whole_levels(
        self,
        key: &str,
        found: &WholeLevels,
        default: [u32; 4],
        range: RangeInclusive<i64>,
    ) -> Result<[u32; 4], DocumentError> {
        let mut levels = default;
        for (level, value) in levels.iter_mut().zip(found.iter().flatten()) {
            *level = self.integer(key, value, &range)?;
        }
        Ok(levels)
    }

    fn integer(
        self,
        key: &str,
        value: &Spanned<i64>,
        range: &RangeInclusive<i64>,
    ) -> Result<u32, DocumentError> {
        let found = *value.get_ref();
        let (least, most) = (range.start(), range.end());
        u32::try_from(found)
            .ok()
            .filter(|_| range.contains(&found))
            .ok_or_else(|| self.wrong(value, format!("{key} is {found}, wanted {least}..={most}")))
    }

    fn color(
        self,
        key: &str,
        found: Option<&Spanned<String>>,
        default: [u8; 3],
    ) -> Result<[u8; 3], DocumentError> {
        found.map_or(Ok(default), |text| {
            hexadecimal(text.get_ref()).ok_or_else(|| {
                let found = text.get_ref();
                self.wrong(text, format!("{key} is {found:?}, wanted \"#rrggbb\""))
            })
        })
    }

    fn less(self, key: &str, found: &Number, value: f32, limit: f32) -> Result<(), DocumentError> {
        match found {
            Some(span) if value >= limit => {
                Err(self.wrong(span, format!("{key} is {value}, wanted less than {limit}")))
            }
            _ => Ok(()),
        }
    }

    fn wrong<T>(self, value: &Spanned<T>, message: impl Into<String>) -> DocumentError {
        self.document.error(value.span().start, message)
    }
}

/// The bytes of `#rrggbb`.
fn hexadecimal(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6)?;
    let value = u32::from_str_radix(digits, 16).ok()?;
    let [_, red, green, blue] = value.to_be_bytes();
    digits
        .bytes()
        .all(|digit| digit.is_ascii_hexdigit())
        .then_some([red, green, blue])
}
