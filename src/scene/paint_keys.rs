//! The table `painting` of a scene file: read, written, and in the scene's digest.

use crate::math::Digester;

use super::parse::small;
use super::reader::Reader;
use super::write::{Text, quoted};
use super::{PaintLook, PaintMark, PaintOptions, PaintReach, PaintRows, SceneError};

pub(super) fn read(table: &Reader<'_>, scene_seed: u64) -> Result<PaintOptions, SceneError> {
    /// The table of keys holds the same names as the type.
    const NAMED: &str = "the table of keys allows these names only";
    let list = |key| -> Result<Option<Vec<u32>>, SceneError> {
        let given: Option<Vec<u64>> = table.get(key)?;
        Ok(given.map(|given| given.into_iter().map(small).collect()))
    };
    let angles: Vec<u32> = list("angles")?.expect("there is a default");
    let (distances, strokes) = (list("distances")?, list("strokes")?);
    let reach = match (&distances, &strokes) {
        (Some(_), Some(_)) => {
            let wanted = "nothing, since `distances` are given";
            return Err(table.refuse("strokes", wanted));
        }
        (Some(distances), None) => PaintReach::Distances(distances),
        (None, Some(strokes)) => PaintReach::Strokes(strokes),
        (None, None) => PaintRows::USUAL_REACH,
    };
    let (PaintReach::Distances(rows) | PaintReach::Strokes(rows)) = reach;
    let Some(rows_of) = PaintRows::new(reach, &angles) else {
        let wanted = format!("an angle for each of {} rows after the first", rows.len());
        return Err(table.refuse("angles", &wanted));
    };
    Ok(PaintOptions {
        look: PaintLook::from_name(&table.have::<String>("look")?).expect(NAMED),
        rows: rows_of,
        hulls: small(table.have("hulls")?),
        core_percent: small(table.have("core_percent")?),
        at_once: small(table.have("at_once")?),
        inward: table.have("inward")?,
        branch_least: small(table.have("branch_least")?),
        branch_step: small(table.have("branch_step")?),
        full_distance: table.have("full_distance")?,
        least_pixels: table.have("least_pixels")?,
        leaf_scale: table.have("leaf_scale")?,
        branch_scale: table.have("branch_scale")?,
        grain: table.have("grain")?,
        seed: table.get("seed")?.unwrap_or(scene_seed),
        mark: PaintMark::from_name(&table.have::<String>("mark")?).expect(NAMED),
    })
}

pub(super) fn write(text: &mut Text, painting: &PaintOptions) {
    let list = |numbers: &[u32]| {
        let numbers: Vec<String> = numbers.iter().map(u32::to_string).collect();
        format!("[{}]", numbers.join(", "))
    };
    text.heading("[painting]");
    text.key("look", &quoted(painting.look.name()));
    match painting.rows.reach() {
        PaintReach::Distances(given) => text.key("distances", &list(given)),
        PaintReach::Strokes(given) => text.key("strokes", &list(given)),
    }
    text.key("angles", &list(painting.rows.angles()));
    text.key("hulls", &painting.hulls.to_string());
    text.key("core_percent", &painting.core_percent.to_string());
    text.key("at_once", &painting.at_once.to_string());
    text.key("inward", &painting.inward.to_string());
    text.key("branch_least", &painting.branch_least.to_string());
    text.key("branch_step", &painting.branch_step.to_string());
    text.key("full_distance", &painting.full_distance.to_string());
    text.key("least_pixels", &painting.least_pixels.to_string());
    text.key("leaf_scale", &painting.leaf_scale.to_string());
    text.key("branch_scale", &painting.branch_scale.to_string());
    text.key("grain", &painting.grain.to_string());
    text.key("seed", &painting.seed.to_string());
    text.key("mark", &quoted(painting.mark.name()));
}

/// The options, where they are not those of a scene that says nothing.
pub(super) fn unlike_usual(painting: &PaintOptions, scene_seed: u64) -> Option<&PaintOptions> {
    let usual = PaintOptions {
        seed: scene_seed,
        ..PaintOptions::USUAL
    };
    (*painting != usual).then_some(painting)
}

pub(super) fn digest(digester: &mut Digester, painting: &PaintOptions) {
    let (kind, given) = match painting.rows.reach() {
        PaintReach::Distances(given) => (0, given),
        PaintReach::Strokes(given) => (1, given),
    };
    digester.u32(painting.look as u32).u32(kind);
    for numbers in [given, painting.rows.angles()] {
        digester.u64(numbers.len() as u64);
        for &number in numbers {
            digester.u32(number);
        }
    }
    digester
        .u32(painting.hulls)
        .u32(painting.core_percent)
        .u32(painting.at_once)
        .f32(painting.inward)
        .u32(painting.branch_least)
        .u32(painting.branch_step)
        .f32(painting.full_distance)
        .f32(painting.least_pixels)
        .f32(painting.leaf_scale)
        .f32(painting.branch_scale)
        .f32(painting.grain)
        .u64(painting.seed)
        .u32(painting.mark as u32);
}
