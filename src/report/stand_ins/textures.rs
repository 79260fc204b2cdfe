//! What impostors' textures take for how they look: bytes at equal FLIP.

use serde_json::{Value, json};

use crate::math::det;
use crate::report::{
    Cell, Column, PictureView, QualitySummary, ReportError, Spread, Table, ViewQuality, decimal,
};
use crate::run::{TextureCost, TextureFound, TextureLook, TextureSetting, ViewScale};

/// What was found of all settings.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TextureReport {
    /// Setting by setting.
    pub settings: Vec<TextureQuality>,
    /// What does not fit, and why.
    pub refused: Vec<(TextureSetting, String)>,
}

/// What textures take, and how they look.
#[derive(Debug, Clone, PartialEq)]
pub struct TextureQuality {
    /// What they take.
    pub cost: TextureCost,
    /// Against leaves in the same planes: FLIP at each scale, by its number.
    pub flip: Vec<(usize, Spread)>,
}

/// Takes what is found one after another.
#[derive(Debug, Default)]
pub(super) struct TextureMeter {
    pub(super) report: TextureReport,
    /// By scale, the leaves in their planes.
    references: Vec<(usize, Vec<PictureView>)>,
}

impl TextureMeter {
    pub(super) fn add(&mut self, found: TextureFound) -> Result<(), ReportError> {
        match found {
            TextureFound::Cost(cost) => self.report.settings.push(TextureQuality {
                cost,
                flip: Vec::new(),
            }),
            TextureFound::Refused(setting, why) => self.report.refused.push((setting, why)),
            TextureFound::Look(look) => self.look(look)?,
        }
        Ok(())
    }

    fn look(&mut self, look: TextureLook) -> Result<(), ReportError> {
        let views = PictureView::all(look.shots)?;
        if look.setting.is_none() {
            self.references.push((look.scale, views));
            return Ok(());
        }
        let reference = self
            .references
            .iter()
            .find(|(scale, _)| *scale == look.scale);
        let (Some((_, reference)), Some(quality)) = (reference, self.report.settings.last_mut())
        else {
            return Ok(());
        };
        let found = ViewQuality::all(reference, &views)?;
        let flip = QualitySummary::of(&found).flip;
        quality.flip.push((look.scale, flip));
        Ok(())
    }
}

impl TextureQuality {
    fn flip_at(&self, scale: usize) -> Option<Spread> {
        let found = self.flip.iter().find(|(known, _)| *known == scale);
        found.map(|(_, flip)| *flip)
    }
}

/// The direct textures that look as something does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EqualDirect {
    /// Those of so many texels a side, which take so many bytes: between two that were looked at.
    Between {
        /// Texels of a side.
        side: f64,
        /// Bytes on the device.
        bytes: f64,
    },
    /// Even the smallest look better.
    Smaller,
    /// Even the largest look worse.
    Larger,
}

/// The direct textures with a front and a back whose mean FLIP at a scale is that of a setting; `None` where
/// no two of them were looked at.
///
/// Between two sizes FLIP is taken to be linear in the logarithm of the size, and so is that of the
/// bytes.
#[must_use]
pub fn equal_direct(
    report: &TextureReport,
    setting: TextureSetting,
    scale: usize,
) -> Option<EqualDirect> {
    let wanted = report
        .settings
        .iter()
        .find(|one| one.cost.setting == setting)?;
    let wanted = wanted.flip_at(scale)?.mean;
    // Side, bytes, FLIP; the smallest first.
    let curve: Vec<[f64; 3]> = report
        .settings
        .iter()
        .filter_map(|one| match one.cost.setting {
            TextureSetting::Direct { side } => {
                let bytes = one.cost.resident_bytes as f64;
                Some([f64::from(side), bytes, one.flip_at(scale)?.mean])
            }
            TextureSetting::FrontAlone { .. } | TextureSetting::Indirect { .. } => None,
        })
        .collect();
    let (first, last) = (curve.first()?, curve.last()?);
    if curve.len() < 2 {
        return None;
    }
    if wanted > first[2] {
        return Some(EqualDirect::Smaller);
    }
    if wanted < last[2] {
        return Some(EqualDirect::Larger);
    }
    // The smallest that look as well.
    let pair = curve.windows(2).find(|pair| pair[1][2] <= wanted)?;
    let [smaller, larger] = [pair[0], pair[1]];
    let fall = smaller[2] - larger[2];
    let share = if fall > 0.0 {
        ((smaller[2] - wanted) / fall).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let between = |axis: usize| {
        let [from, to] = [smaller[axis], larger[axis]].map(det::log_f64);
        det::exp_f64(from + share * (to - from))
    };
    Some(EqualDirect::Between {
        side: between(0),
        bytes: between(1),
    })
}

/// A row a setting; of each scale its FLIP, and the direct textures that look the same.
#[must_use]
pub fn texture_table(report: &TextureReport, scales: &[ViewScale]) -> Table {
    let looked_at = |number: usize| {
        let mut settings = report.settings.iter();
        settings.any(|one| one.flip_at(number).is_some())
    };
    let scales: Vec<(usize, &ViewScale)> = scales
        .iter()
        .enumerate()
        .filter(|(number, _)| looked_at(*number))
        .collect();
    let mut columns = vec![Column::words("textures")];
    let numbers = [
        "uploaded, B",
        "resident, B",
        "leaves a texel",
        "turn off, °",
    ];
    columns.extend(numbers.map(Column::numbers));
    for (_, scale) in &scales {
        columns.push(Column::numbers(format!("FLIP, {} (worst)", scale.name)));
        columns.push(Column::numbers("as direct"));
        columns.push(Column::numbers("B of that"));
        columns.push(Column::numbers("times"));
    }
    let row = |one: &TextureQuality| {
        let cost = &one.cost;
        let (most, turn) = cost.maps.map_or((Cell::Missing, Cell::Missing), |maps| {
            let turn = Cell::Number {
                value: f64::from(maps.greatest_turn),
                digits: 1,
            };
            (Cell::Count(u64::from(maps.most_leaves)), turn)
        });
        let mut cells = vec![
            Cell::Text(cost.setting.label()),
            Cell::Count(cost.upload_bytes),
            Cell::Count(cost.resident_bytes),
            most,
            turn,
        ];
        for (number, _) in &scales {
            cells.extend(at_scale(report, one, *number));
        }
        cells
    };
    Table {
        columns,
        rows: report.settings.iter().map(row).collect(),
    }
}

/// FLIP; and the size of direct textures with the same, their bytes, and how many times the setting's they
/// are.
fn at_scale(report: &TextureReport, one: &TextureQuality, scale: usize) -> [Cell; 4] {
    let flip = one.flip_at(scale).map_or(Cell::Missing, |flip| {
        let [mean, worst] = [flip.mean, flip.worst].map(|value| decimal(value, 4));
        Cell::Text(format!("{mean} ({worst})"))
    });
    let missing = [Cell::Missing, Cell::Missing, Cell::Missing];
    let is_direct = matches!(one.cost.setting, TextureSetting::Direct { .. });
    let equal = equal_direct(report, one.cost.setting, scale).filter(|_| !is_direct);
    let [size, bytes, times] = match equal {
        None => missing,
        Some(EqualDirect::Smaller) => {
            let [_, bytes, times] = missing;
            [Cell::Text("smaller than all".to_owned()), bytes, times]
        }
        Some(EqualDirect::Larger) => {
            let [_, bytes, times] = missing;
            [Cell::Text("larger than all".to_owned()), bytes, times]
        }
        Some(EqualDirect::Between { side, bytes }) => [
            Cell::Number {
                value: side,
                digits: 0,
            },
            Cell::Number {
                value: bytes,
                digits: 0,
            },
            Cell::Number {
                value: bytes / one.cost.resident_bytes.max(1) as f64,
                digits: 2,
            },
        ],
    };
    [flip, size, bytes, times]
}

/// What the table tells.
pub(super) const CAPTION: &str = "Textures of impostors, held against leaves that lie in the same planes, so that nothing but \
     textures differs: over 8 directions, the worst in brackets. An indirect texture is as good as a direct one \
     of the size that follows, which takes so many times its bytes. Of a map the most leaves that a texel names, \
     and the greatest angle by which a leaf is off its sprite. Where the front alone has a texture it is seen from \
     behind too, with leaves in the wrong order.";

/// What does not fit, a sentence each.
pub(super) fn refused(report: &TextureReport) -> impl Iterator<Item = String> + '_ {
    let refused = report.refused.iter();
    refused.map(|(setting, why)| format!("{}: refused: {why}.", setting.label()))
}

/// The same for programs.
pub(super) fn texture_json(report: &TextureReport, scales: &[ViewScale]) -> Value {
    let name = |scale: usize| scales.get(scale).map_or("", |scale| scale.name);
    let entry = |one: &TextureQuality| {
        let looks = one.flip.iter().map(|(scale, flip)| {
            let equal = equal_direct(report, one.cost.setting, *scale);
            let equal = match equal {
                Some(EqualDirect::Between { side, bytes }) => {
                    json!({ "side": side, "bytes": bytes })
                }
                Some(EqualDirect::Smaller) => json!("smaller"),
                Some(EqualDirect::Larger) => json!("larger"),
                None => Value::Null,
            };
            json!({
                "scale": name(*scale),
                "flip": { "mean": flip.mean, "worst": flip.worst },
                "as_direct": equal,
            })
        });
        json!({
            "textures": one.cost.setting.label(),
            "upload_bytes": one.cost.upload_bytes,
            "resident_bytes": one.cost.resident_bytes,
            "most_leaves": one.cost.maps.map(|maps| maps.most_leaves),
            "entries": one.cost.maps.map(|maps| maps.entries),
            "greatest_turn_degrees": one.cost.maps.map(|maps| maps.greatest_turn),
            "looks": looks.collect::<Vec<_>>(),
        })
    };
    let refused = report.refused.iter();
    let refused = refused.map(|(setting, why)| json!({ "textures": setting.label(), "why": why }));
    json!({
        "settings": report.settings.iter().map(entry).collect::<Vec<_>>(),
        "refused": refused.collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(setting: TextureSetting, resident_bytes: u64, mean: f64) -> TextureQuality {
        TextureQuality {
            cost: TextureCost {
                setting,
                upload_bytes: resident_bytes,
                resident_bytes,
                maps: None,
            },
            flip: vec![(0, Spread { mean, worst: mean })],
        }
    }

    #[test]
    fn equal_looks_lie_between_two_sizes() {
        let direct = |side| TextureSetting::Direct { side };
        let front = TextureSetting::FrontAlone { side: 64 };
        let of = |mean| TextureReport {
            settings: vec![
                found(direct(32), 1000, 0.4),
                found(direct(64), 4000, 0.2),
                found(direct(128), 16_000, 0.1),
                found(front, 2000, mean),
            ],
            refused: Vec::new(),
        };
        let equal = |mean| equal_direct(&of(mean), front, 0);
        assert_eq!(equal(0.41), Some(EqualDirect::Smaller));
        assert_eq!(equal(0.09), Some(EqualDirect::Larger));
        let between = |mean, wanted: [f64; 2]| {
            let Some(EqualDirect::Between { side, bytes }) = equal(mean) else {
                panic!("{mean} lies between");
            };
            assert!((side - wanted[0]).abs() < 1e-9, "{side}");
            assert!((bytes - wanted[1]).abs() < 1e-9, "{bytes}");
        };
        between(0.2, [64.0, 4000.0]);
        // Half way, on scales of ratios.
        between(0.3, [32.0 * 2.0_f64.sqrt(), 2000.0]);
        between(0.15, [64.0 * 2.0_f64.sqrt(), 8000.0]);
        assert_eq!(equal_direct(&of(0.3), front, 1), None);
    }
}
