//! How foliage moves with the camera, as tables, files and pictures.

use serde::Serialize;

use super::run::json;
use super::{Cell, Column, OutputFolder, Page, PageImage, ReportError, Section, Table, encode_png};
use crate::run::{
    FlowPicture, FlowPixel, Parallax, ParallaxDistance, ParallaxMeasure, ParallaxScale, PixelSpread,
};

/// The value of `schema` in `parallax.json`.
pub const PARALLAX_SCHEMA: &str = "spinney.parallax/1";

/// What the table tells.
const CAPTION: &str = "How far each model's optical flow ends from the original's, in pixels: the mean, and what \
     95 % of the pixels stay within; and the pixels of the original for which the model shows nothing, or \
     something that is gone when the camera has moved. The first row is how far leaves move beside the centre \
     of the foliage: what a picture that faces the camera lacks.";

/// What the pictures show.
const PICTURES: &str = "Flow beside that of the foliage's centre: orange moves as what is near, blue as what is \
     far, grey not at all; pink is gone when the camera has moved.";

/// Bytes of all pictures of a page: as text they take a third more.
const MOST_PICTURES: usize = Page::MAX_BYTES / 2;

/// Fields in the order of the file.
#[derive(Debug, Serialize)]
struct ParallaxEntry<'p> {
    plant: &'p str,
    radius_m: f64,
    side: u32,
    field_of_view: f64,
    steps: u32,
    distances: Vec<DistanceEntry>,
    models: Vec<ModelEntry<'p>>,
}

#[derive(Debug, Serialize)]
struct DistanceEntry {
    name: &'static str,
    radii: f64,
    metres: f64,
    step_m: f64,
    parallax: SpreadEntry,
}

#[derive(Debug, Serialize)]
struct ModelEntry<'p> {
    model: &'p str,
    distances: Vec<MeasureEntry>,
}

#[derive(Debug, Serialize)]
struct MeasureEntry {
    distance: &'static str,
    pixels: u64,
    missing: u64,
    error: SpreadEntry,
}

#[derive(Debug, Clone, Copy, Serialize)]
struct SpreadEntry {
    mean_px: f64,
    p95_px: f64,
}

impl SpreadEntry {
    fn of(spread: PixelSpread) -> Self {
        Self {
            mean_px: spread.mean,
            p95_px: spread.most,
        }
    }
}

impl<'p> ParallaxEntry<'p> {
    fn of(parallax: &'p Parallax) -> Self {
        let distance = |scale: &ParallaxScale| DistanceEntry {
            name: scale.distance.name,
            radii: scale.distance.radii,
            metres: scale.metres,
            step_m: scale.step,
            parallax: SpreadEntry::of(scale.parallax),
        };
        let model = |measures: &'p [ParallaxMeasure]| ModelEntry {
            model: &measures[0].label,
            distances: measures
                .iter()
                .map(|measure| MeasureEntry {
                    distance: measure.distance.name,
                    pixels: measure.pixels,
                    missing: measure.missing,
                    error: SpreadEntry::of(measure.error),
                })
                .collect(),
        };
        Self {
            plant: &parallax.plant,
            radius_m: parallax.radius,
            side: parallax.options.side,
            field_of_view: parallax.options.field_of_view,
            steps: parallax.options.steps,
            distances: parallax.scales.iter().map(distance).collect(),
            models: models(parallax).map(model).collect(),
        }
    }
}

/// The measures of each model, none without one.
fn models(parallax: &Parallax) -> impl Iterator<Item = &[ParallaxMeasure]> {
    parallax.measures.chunks(parallax.scales.len().max(1))
}

/// All plants as JSON.
#[must_use]
pub fn parallax_json(plants: &[Parallax]) -> String {
    let entries: Vec<ParallaxEntry<'_>> = plants.iter().map(ParallaxEntry::of).collect();
    let report = serde_json::json!({ "schema": PARALLAX_SCHEMA, "plants": entries });
    json(&report) + "\n"
}

/// A plant's models as a table: three columns a distance.
#[must_use]
pub fn parallax_table(parallax: &Parallax) -> Table {
    let mut columns = vec![Column::words("model")];
    let mut first = vec![Cell::Text("(parallax itself)".to_owned())];
    let number = |value| Cell::Number { value, digits: 2 };
    for scale in &parallax.scales {
        let name = scale.distance.name;
        columns.push(Column::numbers(name));
        columns.push(Column::numbers("95 %"));
        columns.push(Column::numbers("lost %"));
        first.extend([
            number(scale.parallax.mean),
            number(scale.parallax.most),
            Cell::Missing,
        ]);
    }
    let row = |measures: &[ParallaxMeasure]| {
        let mut cells = vec![Cell::Text(measures[0].label.clone())];
        for measure in measures {
            let lost = 100.0 * measure.missing as f64 / measure.pixels.max(1) as f64;
            cells.extend([
                number(measure.error.mean),
                number(measure.error.most),
                Cell::Number {
                    value: lost,
                    digits: 1,
                },
            ]);
        }
        cells
    };
    let rows = models(parallax).map(row);
    Table {
        columns,
        rows: std::iter::once(first).chain(rows).collect(),
    }
}

/// All plants as CSV: a row a model and distance.
fn csv(plants: &[Parallax]) -> String {
    let names = [
        "radii",
        "metres",
        "step_m",
        "pixels",
        "missing",
        "error_mean_px",
        "error_p95_px",
        "parallax_mean_px",
        "parallax_p95_px",
    ];
    let words = ["plant", "model", "distance"].map(Column::words);
    let number = |value| Cell::Number { value, digits: 6 };
    let row = |parallax: &Parallax, measure: &ParallaxMeasure, scale: &ParallaxScale| {
        let ParallaxDistance { name, radii } = measure.distance;
        vec![
            Cell::Text(parallax.plant.clone()),
            Cell::Text(measure.label.clone()),
            Cell::Text(name.to_owned()),
            number(radii),
            number(scale.metres),
            number(scale.step),
            Cell::Count(measure.pixels),
            Cell::Count(measure.missing),
            number(measure.error.mean),
            number(measure.error.most),
            number(scale.parallax.mean),
            number(scale.parallax.most),
        ]
    };
    let rows = plants.iter().flat_map(|parallax| {
        let measures = parallax.measures.iter();
        let scales = parallax.scales.iter().cycle();
        measures
            .zip(scales)
            .map(move |(measure, scale)| row(parallax, measure, scale))
    });
    let table = Table {
        columns: words
            .into_iter()
            .chain(names.map(Column::numbers))
            .collect(),
        rows: rows.collect(),
    };
    table.to_csv()
}

/// What the tables of all plants say to people, at so many columns.
#[must_use]
pub fn parallax_text(plants: &[Parallax], width: usize) -> String {
    let plant = |parallax: &Parallax| {
        let table = parallax_table(parallax).to_text(width);
        format!("{}\n{table}", heading(parallax))
    };
    plants.iter().map(plant).collect::<Vec<_>>().join("\n")
}

fn heading(parallax: &Parallax) -> String {
    let scale = |scale: &ParallaxScale| {
        format!(
            "{} {:.1} m ({:.2} m a step)",
            scale.distance.name, scale.metres, scale.step
        )
    };
    let scales: Vec<String> = parallax.scales.iter().map(scale).collect();
    format!(
        "{}: foliage within {:.1} m, seen from {}; {} steps sideways, {}² pixels over {}°",
        parallax.plant,
        parallax.radius,
        scales.join(", "),
        parallax.options.steps,
        parallax.options.side,
        parallax.options.field_of_view
    )
}

/// Writes `parallax.json`, `parallax.csv`, `report.html`, and for each plant, model and distance a picture
/// of the flow.
///
/// # Errors
///
/// When something cannot be written.
pub fn write_parallax(output: &OutputFolder, plants: &[Parallax]) -> Result<(), ReportError> {
    output.write("parallax.json", parallax_json(plants).as_bytes())?;
    output.write("parallax.csv", csv(plants).as_bytes())?;
    let mut page = Page {
        title: "Parallax".to_owned(),
        sections: vec![Section::Text(CAPTION.to_owned())],
    };
    let (mut shown, mut bytes) = (0, 0);
    for (number, parallax) in plants.iter().enumerate() {
        page.sections.push(Section::Table {
            caption: heading(parallax),
            table: parallax_table(parallax),
        });
        let truth = parallax.scales.iter();
        let truth = truth.map(|scale| ("original", scale, &scale.flow));
        let scales = parallax.scales.iter().cycle();
        let measures = parallax.measures.iter().zip(scales);
        let measures = measures.map(|(measure, scale)| (&*measure.label, scale, &measure.flow));
        let mut images = Vec::new();
        for (label, scale, flow) in truth.chain(measures) {
            let png = encode_png(flow.side, flow.side, &colours(flow, scale.most))?;
            let distance = scale.distance.name;
            output.write(&format!("flow-{number}-{label}-{distance}.png"), &png)?;
            // As many as a page holds; all lie beside it.
            if shown < Page::MAX_IMAGES && bytes + png.len() <= MOST_PICTURES {
                (shown, bytes) = (shown + 1, bytes + png.len());
                let caption = format!("{label}, {distance}");
                images.push(PageImage { caption, png });
            }
        }
        page.sections.push(Section::Text(PICTURES.to_owned()));
        page.sections.push(Section::Images(images));
    }
    output.write("report.html", page.to_html()?.as_bytes())
}

/// A flow picture's pixels: R, G, B, A each.
fn colours(flow: &FlowPicture, most: f64) -> Vec<u8> {
    let pixel = |pixel: &FlowPixel| match pixel {
        FlowPixel::Empty => [22, 24, 28],
        FlowPixel::Gone => [232, 60, 170],
        // The camera moves to the right, so what is near moves to the left.
        FlowPixel::Moves(flow) => {
            tone((-f64::from(flow.x) / most.max(f64::MIN_POSITIVE)).clamp(-1.0, 1.0))
        }
    };
    let pixels = flow.pixels.iter();
    pixels
        .flat_map(|found| {
            let [red, green, blue] = pixel(found);
            [red, green, blue, 255]
        })
        .collect()
}

/// From blue at −1 over grey at 0 to orange at 1.
fn tone(share: f64) -> [u8; 3] {
    const ENDS: [[f64; 3]; 3] = [
        [38.0, 108.0, 196.0],
        [205.0, 205.0, 205.0],
        [236.0, 118.0, 18.0],
    ];
    let end = if share < 0.0 { ENDS[0] } else { ENDS[2] };
    let share = share.abs();
    [0, 1, 2].map(|channel: usize| {
        let value = ENDS[1][channel] + (end[channel] - ENDS[1][channel]) * share;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "between two bytes"
        )]
        let byte = value as u8;
        byte
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tones_go_from_blue_to_orange() {
        assert_eq!(tone(0.0), [205; 3]);
        assert_eq!(tone(1.0), [236, 118, 18]);
        assert_eq!(tone(-1.0), [38, 108, 196]);
        assert_eq!(tone(-0.5), [121, 156, 200]);
    }
}
