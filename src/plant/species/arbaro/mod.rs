//! Arbaro's tree files as species: the same parameters of Weber and Penn, by the paper's names.
//!
//! ```text
//! <arbaro><species name='…'>  <param name='Shape' value='7'/> …  </species></arbaro>
//! ```
//!
//! Lengths are metres and angles degrees, as here. What a file does not say is Arbaro's own default, not this
//! program's.

#[cfg(test)]
mod tests;

use super::{
    Blade, Clump, Crown, FoliageKind, LeafHabit, Pruning, Shape, Species, StemLevel, Wood,
};
use crate::document::{Document, DocumentError, parse_xml};
use crate::plant::Silhouette;
use crate::plant::import::{ImportReport, ReportKind};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// A species of Arbaro's, and how it was understood.
#[derive(Debug, Clone, PartialEq)]
pub struct ArbaroSpecies {
    /// The species.
    pub species: Species,
    /// What has no counterpart here, or another value.
    pub report: ImportReport,
}

impl ArbaroSpecies {
    /// Whether a document looks like one of Arbaro's.
    #[must_use]
    pub fn is_one(document: &Document) -> bool {
        let text = document.text.trim_start_matches('\u{feff}').trim_start();
        text.starts_with('<') && text.contains("<arbaro")
    }

    /// The species that a document describes.
    ///
    /// # Errors
    ///
    /// When the document is no XML, names entities of its own, has no species, or holds a value that is no
    /// number: with file, line and column, what was found and what would be right.
    pub fn parse(document: &Document) -> Result<Self, DocumentError> {
        let xml = parse_xml(&document.file, &document.text, "an Arbaro file")?;
        let root = xml.root_element();
        let species = root.descendants().find(|node| node.has_tag_name("species"));
        let Some(species) = species.filter(|_| root.has_tag_name("arbaro")) else {
            let message = "no <arbaro> with a <species> in it; it holds the parameters";
            return Err(document.error(root.range().start, message));
        };
        let mut params = Params {
            document,
            values: BTreeMap::new(),
            defaults: 0,
            report: ImportReport::default(),
        };
        for param in species
            .descendants()
            .filter(|node| node.has_tag_name("param"))
        {
            let (name, value) = (param.attribute("name"), param.attribute("value"));
            let (Some(name), Some(value)) = (name, value) else {
                let message = "a <param> without name or value, wanted both";
                return Err(document.error(param.range().start, message));
            };
            let value = (value.trim(), param.range().start);
            if params.values.insert(name, value).is_some() {
                let message = format!("{name} is given again: the last counts");
                params.note(ReportKind::Repaired, param.range().start, message);
            }
        }
        let name = species.attribute("name").unwrap_or_default().trim();
        let name = if name.is_empty() { "tree" } else { name };
        let species = params.species(name)?;
        params.note_rest();
        let report = params.report;
        Ok(Self { species, report })
    }
}

/// The parameters of a file; each is taken out when it is used.
struct Params<'a> {
    document: &'a Document,
    /// By name, the value and the byte offset of its element.
    values: BTreeMap<&'a str, (&'a str, usize)>,
    defaults: u64,
    report: ImportReport,
}

impl Params<'_> {
    fn species(&mut self, name: &str) -> Result<Species, DocumentError> {
        let crown = self.crown()?;
        let wood = self.wood()?;
        let stems = [self.stem(0)?, self.stem(1)?, self.stem(2)?, self.stem(3)?];
        self.distances(crown.levels)?;
        let leaves = LeafHabit {
            per_stem: self.number("Leaves", 0.0, -500.0..=500.0)?,
            bend: self.number("LeafBend", 0.3, 0.0..=1.0)?,
            attraction_up: 0.0,
            bare: 0.0,
        };
        let foliage = vec![self.foliage()?];
        Ok(Species {
            name: name.to_owned(),
            latin: String::new(),
            leaf_count: None,
            stop_leaves: None,
            trunk_polygons: None,
            crown,
            clump: Clump {
                count: 1,
                radius: 0.0,
                lean: 0.0,
            },
            wood,
            stems,
            leaves,
            omitted_leaves: Vec::new(),
            foliage,
        })
    }

    fn crown(&mut self) -> Result<Crown, DocumentError> {
        let shape = self.shape()?;
        let scale = self.number("Scale", 10.0, 0.05..=150.0)?;
        let vertical_scale = self.number("ZScale", 1.0, 0.1..=10.0)?;
        let attraction = self.number("AttractionUp", 0.0, -10.0..=10.0)?;
        Ok(Crown {
            shape,
            levels: self.whole("Levels", 3, 1..=4)?,
            base_size: self.number("BaseSize", 0.25, 0.0..=0.95)?,
            scale,
            scale_v: self.below("ScaleV", scale, 149.0)?,
            vertical_scale,
            vertical_scale_v: self.below("ZScaleV", vertical_scale, 9.0)?,
            // The paper has one number, for levels 2 and 3.
            attraction_up: [0.0, 0.0, attraction, attraction],
            pruning: Pruning {
                ratio: self.number("PruneRatio", 0.0, 0.0..=1.0)?,
                width: self.number("PruneWidth", 0.5, 0.0..=10.0)?,
                width_peak: self.number("PruneWidthPeak", 0.5, 0.0..=1.0)?,
                power_low: self.number("PrunePowerLow", 0.5, 0.0..=10.0)?,
                power_high: self.number("PrunePowerHigh", 0.5, 0.0..=10.0)?,
            },
        })
    }

    fn shape(&mut self) -> Result<Shape, DocumentError> {
        let at = self.values.get("Shape").map(|&(_, at)| at);
        let number = self.whole("Shape", 0, 0..=u32::MAX)?;
        let Some(&shape) = Shape::ALL.get(number as usize) else {
            let message = format!("Shape is {number}, wanted 0..=8");
            return Err(self.document.error(at.unwrap_or(0), message));
        };
        if shape == Shape::Conical {
            let message =
                "Shape 0: stems at the top have a fifth of the longest's length, in Arbaro none";
            self.note(ReportKind::NotUnderstood, at.unwrap_or(0), message);
        }
        Ok(shape)
    }

    fn wood(&mut self) -> Result<Wood, DocumentError> {
        let trunk_scale = self.number("0Scale", 1.0, 0.01..=10.0)?;
        Ok(Wood {
            ratio: self.number("Ratio", 0.05, 0.0001..=0.5)?,
            ratio_power: self.number("RatioPower", 1.0, 0.0..=10.0)?,
            lobes: self.whole("Lobes", 0, 0..=32)?,
            lobe_depth: self.number("LobeDepth", 0.0, 0.0..=0.9)?,
            flare: self.number("Flare", 0.5, 0.0..=10.0)?,
            trunk_scale,
            trunk_scale_v: self.below("0ScaleV", trunk_scale, 9.0)?,
            base_splits: self.whole("0BaseSplits", 0, 0..=10)?,
            bark_color: [0x6b, 0x5d, 0x4d],
            tube_edges: [12, 6, 4, 3],
        })
    }

    /// A level's stems; defaults are those of Arbaro's levels 0, 1, 2 and 3.
    fn stem(&mut self, level: usize) -> Result<StemLevel, DocumentError> {
        let is_trunk = level == 0;
        let of = |trunk: f32, others: f32| if is_trunk { trunk } else { others };
        let key = |name: &str| format!("{level}{name}");
        let turn = -720.0..=720.0;
        let half = -180.0..=180.0;
        Ok(StemLevel {
            length: self.number(&key("Length"), of(1.0, 0.5), 0.0..=4.0)?,
            length_v: self.number(&key("LengthV"), 0.0, 0.0..=4.0)?,
            taper: self.number(&key("Taper"), 1.0, 0.0..=3.0)?,
            segment_splits: self.number(&key("SegSplits"), 0.0, 0.0..=4.0)?,
            split_angle: self.number(&key("SplitAngle"), 0.0, 0.0..=180.0)?,
            split_angle_v: self.number(&key("SplitAngleV"), 0.0, 0.0..=180.0)?,
            curve_res: self.whole(&key("CurveRes"), [3, 3, 1, 1][level], 1..=64)?,
            curve: self.number(&key("Curve"), 0.0, turn.clone())?,
            curve_back: self.number(&key("CurveBack"), 0.0, turn.clone())?,
            curve_v: self.number(&key("CurveV"), 0.0, turn)?,
            down_angle: self.number(&key("DownAngle"), of(0.0, 30.0), half.clone())?,
            down_angle_v: self.number(&key("DownAngleV"), 0.0, half)?,
            rotate: self.number(&key("Rotate"), of(0.0, 120.0), -360.0..=360.0)?,
            // A variation has no sign.
            rotate_v: self.number(&key("RotateV"), 0.0, -360.0..=360.0)?.abs(),
            branches: self.number(&key("Branches"), [1.0, 10.0, 5.0, 5.0][level], 0.0..=2000.0)?,
        })
    }

    /// How branches lie along a segment: evenly here, which is 1 there.
    fn distances(&mut self, levels: u32) -> Result<(), DocumentError> {
        for level in 0..4_u32 {
            let key = format!("{level}BranchDist");
            let at = self.values.get(key.as_str()).map(|&(_, at)| at);
            let distance = self.number(&key, if level == 0 { 0.0 } else { 1.0 }, 0.0..=1.0)?;
            let differs = (1..levels).contains(&level) && distance < 1.0;
            if let Some(at) = at.filter(|_| differs) {
                let message = "nBranchDist below 1: branches lie evenly along their parent";
                self.note(ReportKind::NotUnderstood, at, message);
            }
        }
        Ok(())
    }

    fn foliage(&mut self) -> Result<FoliageKind, DocumentError> {
        for (key, same, message) in [
            (
                "LeafQuality",
                1.0,
                "LeafQuality: all leaves are there, as at 1",
            ),
            (
                "LeafStemLen",
                0.0,
                "LeafStemLen: leaves sit on their stems, as at 0",
            ),
            ("LeafDistrib", 4.0, "LeafDistrib: leaves are spread as at 4"),
        ] {
            let at = self.values.get(key).map(|&(_, at)| at);
            let value = self.number(key, same, -1000.0..=1000.0)?;
            if let Some(at) = at.filter(|_| value != same) {
                self.note(ReportKind::NotUnderstood, at, message);
            }
        }
        let (form, at) = self.values.remove("LeafShape").unwrap_or(("0", 0));
        let length = self.number("LeafScale", 0.2, 0.001..=5.0)?;
        let width = self.number("LeafScaleX", 0.5, 0.02..=5.0)?;
        let is_round = form.eq_ignore_ascii_case("sphere");
        let blade = if is_round && width <= MOST_NEEDLE {
            let diameter = (length * width).clamp(0.0001, 0.1);
            let message = "LeafShape sphere, narrow: needles";
            self.note(ReportKind::Guessed, at, message);
            Blade::Needle { diameter }
        } else {
            let message = format!("LeafShape {form:?}: an ellipse as an image on a flat leaf");
            self.note(ReportKind::Guessed, at, message);
            Blade::Flat
        };
        Ok(FoliageKind {
            silhouette: Silhouette::Elliptic,
            share: 1.0,
            length,
            length_v: 0.0,
            width,
            color: [0x4f, 0x7a, 0x2c],
            blade,
        })
    }

    /// A number in a range; beyond it the nearest that is in it.
    fn number(
        &mut self,
        key: &str,
        default: f32,
        range: RangeInclusive<f32>,
    ) -> Result<f32, DocumentError> {
        let Some((text, at)) = self.values.remove(key) else {
            self.defaults += 1;
            return Ok(default);
        };
        let value = text.parse::<f32>().ok().filter(|value| value.is_finite());
        let Some(value) = value else {
            let message = format!("{key} is {text:?}, wanted a finite number");
            return Err(self.document.error(at, message));
        };
        let (least, most) = (*range.start(), *range.end());
        if range.contains(&value) {
            return Ok(value);
        }
        let taken = value.clamp(least, most);
        let message = format!("{key} is {value}, beyond {least}..={most}: taken as {taken}");
        self.note(ReportKind::Repaired, at, message);
        Ok(taken)
    }

    /// A variation, which is less than what varies.
    fn below(&mut self, key: &str, of: f32, most: f32) -> Result<f32, DocumentError> {
        self.number(key, 0.0, 0.0..=most.min(0.999 * of))
    }

    fn whole(
        &mut self,
        key: &str,
        default: u32,
        range: RangeInclusive<u32>,
    ) -> Result<u32, DocumentError> {
        let Some(&(text, at)) = self.values.get(key) else {
            self.defaults += 1;
            return Ok(default);
        };
        self.values.remove(key);
        let value = text
            .parse::<f64>()
            .ok()
            .filter(|value| value.fract() == 0.0);
        let Some(value) = value else {
            let message = format!("{key} is {text:?}, wanted a whole number");
            return Err(self.document.error(at, message));
        };
        let (least, most) = (*range.start(), *range.end());
        let taken = crate::math::whole_u32(value).clamp(least, most);
        if f64::from(taken) != value {
            let message = format!("{key} is {value}, beyond {least}..={most}: taken as {taken}");
            self.note(ReportKind::Repaired, at, message);
        }
        Ok(taken)
    }

    /// What nothing here answers to.
    fn note_rest(&mut self) {
        for (key, (_, at)) in std::mem::take(&mut self.values) {
            if ["Smooth", "Seed", "Species"].contains(&key) {
                let message = format!("{key}: of Arbaro's own output");
                self.note(ReportKind::Ignored, at, message);
            } else {
                self.note(ReportKind::NotUnderstood, at, format!("parameter {key:?}"));
            }
        }
        let message = "parameters that are not given: Arbaro's defaults";
        // The trunk's level and Arbaro's own keys are among them.
        self.report
            .add(ReportKind::Missing, self.defaults, "line 1", message);
    }

    fn note(&mut self, kind: ReportKind, at: usize, message: impl Into<String>) {
        let place = self.document.error(at, "");
        let place = format!("line {}, column {}", place.line, place.column);
        self.report.add(kind, 1, place, message);
    }
}

/// Spheres narrower than this share of their length are needles.
const MOST_NEEDLE: f32 = 0.2;
