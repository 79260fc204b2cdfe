//! What the levels of a walk do to the picture, in every form in which a walk is told.

use serde::Serialize;

use super::plots::plot;
use crate::models::Vertices;
use crate::report::run::evenly;
use crate::report::{
    Cell, Column, Plot, QualitySummary, Scale, Section, Series, Spread, StepQuality, SweepQuality,
    Table, ViewQuality, decimal, grouped,
};
use crate::run::{Appearance, Sweep, SweepModel, VIEW_SIDE, directions};

/// What the measures mean.
const CAPTION: &str = "Each level against full detail. Area is that of the leaves; covered are pixels \
     that show a leaf; silhouette are pixels that show one in one of the two pictures alone, as a \
     share of those at full detail; FLIP is the difference that is seen, 0 none, the mean over whole \
     pictures; SSIM is structural similarity, 1 equal. Of several views the mean, and in brackets the \
     worst.";

/// A step's `quality` in `sweep.json`; fields in the order of the file.
#[derive(Debug, Clone, Serialize)]
pub(super) struct QualityEntry {
    leaf_area: f64,
    covered: SpreadEntry,
    silhouette: SpreadEntry,
    flip: SpreadEntry,
    ssim: SpreadEntry,
    frame: FrameEntry,
}

#[derive(Debug, Clone, Copy, Serialize)]
struct SpreadEntry {
    mean: f64,
    worst: f64,
}

/// The scene's own picture.
#[derive(Debug, Clone, Copy, Serialize)]
struct FrameEntry {
    covered: f64,
    silhouette: f64,
    flip: f64,
    ssim: Option<f64>,
}

impl QualityEntry {
    pub(super) fn of(step: &StepQuality) -> Self {
        let spread = |Spread { mean, worst }| SpreadEntry { mean, worst };
        let QualitySummary {
            covered,
            silhouette,
            flip,
            ssim,
        } = step.foliage;
        let frame = step.frame;
        Self {
            leaf_area: step.leaf_area,
            covered: spread(covered),
            silhouette: spread(silhouette),
            flip: spread(flip),
            ssim: spread(ssim),
            frame: FrameEntry {
                covered: frame.covered,
                silhouette: frame.silhouette,
                flip: frame.flip,
                ssim: frame.ssim,
            },
        }
    }
}

/// The columns of `sweep.csv`.
pub(super) fn quality_columns() -> impl Iterator<Item = Column> {
    let names = [
        "area_share",
        "covered_mean",
        "covered_worst",
        "silhouette_mean",
        "silhouette_worst",
        "flip_mean",
        "flip_worst",
        "ssim_mean",
        "ssim_worst",
        "frame_covered",
        "frame_silhouette",
        "frame_flip",
        "frame_ssim",
    ];
    names.into_iter().map(Column::numbers)
}

/// A step's cells in these columns.
pub(super) fn quality_cells(step: Option<&StepQuality>) -> Vec<Cell> {
    let Some(step) = step else {
        return vec![Cell::Missing; quality_columns().count()];
    };
    let number = |value| Cell::Number { value, digits: 6 };
    let QualitySummary {
        covered,
        silhouette,
        flip,
        ssim,
    } = step.foliage;
    let mut cells = vec![number(step.leaf_area)];
    for Spread { mean, worst } in [covered, silhouette, flip, ssim] {
        cells.extend([mean, worst].map(number));
    }
    let ViewQuality {
        covered,
        silhouette,
        flip,
        ssim,
    } = step.frame;
    cells.extend([covered, silhouette, flip].map(number));
    cells.push(ssim.map_or(Cell::Missing, number));
    cells
}

/// A row a level of a [look](SweepQuality::looks), as the scene simplifies foliage and pruned; of more than `most` only some, evenly chosen, with
/// both ends.
#[must_use]
pub fn quality_table(quality: &SweepQuality, look: Appearance, most: usize) -> Table {
    let headings = [
        "detail",
        "area",
        "covered",
        "silhouette",
        "FLIP",
        "SSIM",
        "FLIP, scene",
        "SSIM, scene",
    ];
    let steps = quality.of_look(look);
    let rows = evenly(steps.len(), most).into_iter();
    let names = has_pruned(&steps).then(|| Column::words("foliage"));
    let numbers = headings.into_iter().map(Column::numbers);
    let row = |step: &StepQuality| {
        let name = || Cell::Text(foliage_name(step.appearance.pruned).to_owned());
        let name = names.is_some().then(name);
        name.into_iter().chain(table_cells(quality, step)).collect()
    };
    Table {
        rows: rows.map(|index| row(steps[index])).collect(),
        columns: names.into_iter().chain(numbers).collect(),
    }
}

/// Whether some of the foliage is pruned beside what the scene says.
fn has_pruned(steps: &[&StepQuality]) -> bool {
    steps.iter().any(|step| step.appearance.pruned)
}

/// How foliage is simplified.
fn foliage_name(pruned: bool) -> &'static str {
    if pruned {
        "pruned"
    } else {
        "as the scene says"
    }
}

fn table_cells(quality: &SweepQuality, step: &StepQuality) -> Vec<Cell> {
    let number = |value, digits| Cell::Number { value, digits };
    let spread = |Spread { mean, worst }| {
        let [mean, worst] = [mean, worst].map(|value| decimal(value, 3));
        Cell::Text(format!("{mean} ({worst})"))
    };
    let foliage = &step.foliage;
    let (flip, ssim) = (step.frame.flip, step.frame.ssim);
    vec![
        number(detail(quality, step), 3),
        number(step.leaf_area, 3),
        spread(foliage.covered),
        spread(foliage.silhouette),
        spread(foliage.flip),
        spread(foliage.ssim),
        number(flip, 4),
        ssim.map_or(Cell::Missing, |ssim| number(ssim, 4)),
    ]
}

/// Where a step stands: 0 is full detail, 1 the coarsest.
fn detail(quality: &SweepQuality, step: &StepQuality) -> f64 {
    let last = quality.steps.last().map_or(1, |last| last.step.max(1));
    f64::from(step.step) / f64::from(last)
}

/// From where foliage was seen, and whether all models show the same.
#[must_use]
pub fn quality_notes(sweep: &Sweep, quality: &SweepQuality) -> Vec<String> {
    let plants = match quality.plants {
        1 => "the plant".to_owned(),
        more => format!("each of {} plants", grouped(more as u64, ",")),
    };
    let seen = format!(
        "Foliage alone: {plants} from {} fixed directions, {VIEW_SIDE} × {VIEW_SIDE} pixels with the \
         leaves' sphere at 90 %. The scene: from its own camera at frame 0.",
        directions().len()
    );
    vec![seen, agreement(sweep, quality)]
}

fn agreement(sweep: &Sweep, quality: &SweepQuality) -> String {
    let first_other = |model: &&SweepModel| {
        let mut steps = model.steps.iter();
        let other = steps.find(|step| quality.agrees(model, step) == Some(false))?;
        Some(format!(
            "{} from step {} on",
            model.variant.label(),
            other.step
        ))
    };
    let others: Vec<String> = sweep
        .models
        .iter()
        .filter_map(|m| first_other(&m))
        .collect();
    let looked_at = quality.of_look(Appearance::USUAL).len();
    if others.is_empty() && quality.looks().len() > 1 {
        return format!(
            "At all {looked_at} levels that were looked at, all {} models show the picture of the scene \
             that others with such trunks and vertices show, bit for bit.",
            sweep.models.len()
        );
    }
    if others.is_empty() {
        return format!(
            "At all {looked_at} levels that were looked at, all {} models show the same picture of \
             the scene, bit for bit.",
            sweep.models.len()
        );
    }
    format!(
        "Pictures of the scene differ from those that were looked at, and nothing is said of them: {}.",
        others.join(", ")
    )
}

/// What a look is, after the usual one: words, and a part of a file's name.
fn other(look: Appearance) -> Option<(String, String)> {
    let mut parts: Vec<(&str, &str)> = Vec::new();
    if !look.foliage_has_levels {
        parts.push(("foliage at full detail", "full-foliage"));
    }
    match look.trunk_has_levels {
        None => {}
        Some(true) => parts.push(("trunks that have levels", "trunks")),
        Some(false) => parts.push(("trunks at full detail", "full-trunks")),
    }
    if look.vertices == Vertices::Quantised {
        parts.push(("quantised vertices", "quantised"));
    }
    let (words, names): (Vec<&str>, Vec<&str>) = parts.into_iter().unzip();
    (!words.is_empty()).then(|| (words.join(", "), names.join("-")))
}

/// What stands above the table of a look; nothing above that of the usual one.
pub(super) fn quality_heading(look: Appearance) -> Option<String> {
    other(look).map(|(words, _)| format!("With {words}, against full detail with exact vertices"))
}

/// The plots with the names of their files, without `.svg`, of each [look](SweepQuality::looks).
#[must_use]
pub fn quality_plots(quality: &SweepQuality) -> Vec<(String, Plot)> {
    let of_look = |look: Appearance| {
        let plots = look_plots(quality, look).into_iter();
        plots.map(move |(name, mut plot)| match other(look) {
            None => (name.to_owned(), plot),
            Some((words, part)) => {
                plot.title += &format!(" ({words})");
                (format!("{name}-{part}"), plot)
            }
        })
    };
    quality.looks().into_iter().flat_map(of_look).collect()
}

fn look_plots(quality: &SweepQuality, look: Appearance) -> Vec<(&'static str, Plot)> {
    let steps = quality.of_look(look);
    let both = has_pruned(&steps);
    // A line of each foliage.
    let line = |name: &str, value: &dyn Fn(&StepQuality) -> f64| -> Vec<Series> {
        let point = |step: &&StepQuality| [detail(quality, step), value(step)];
        let of = |pruned: bool| Series {
            name: match both {
                true => format!("{name}, {}", foliage_name(pruned)),
                false => name.to_owned(),
            },
            points: steps
                .iter()
                .filter(|step| step.appearance.pruned == pruned)
                .map(point)
                .collect(),
        };
        let lines = [false, true].map(of).into_iter();
        lines.filter(|line| !line.points.is_empty()).collect()
    };
    let views = |spread: fn(&QualitySummary) -> Spread| {
        [
            line("mean of the views", &|step| spread(&step.foliage).mean),
            line("worst view", &|step| spread(&step.foliage).worst),
        ]
        .concat()
    };
    let with_scene = |mut lines: Vec<Series>, value: &dyn Fn(&ViewQuality) -> f64| {
        lines.extend(line("the scene's camera", &|step| value(&step.frame)));
        lines
    };
    let area = line("leaves", &|step| step.leaf_area);
    let share = "share of full detail";
    let of = |title, label, lines| plot(title, label, Scale::Linear, lines);
    vec![
        ("quality-area", of("Area of the leaves", share, area)),
        (
            "quality-covered",
            of(
                "Covered pixels, foliage alone",
                share,
                views(|foliage| foliage.covered),
            ),
        ),
        (
            "quality-silhouette",
            of(
                "Silhouette: pixels where a leaf came or went, foliage alone",
                share,
                views(|foliage| foliage.silhouette),
            ),
        ),
        (
            "quality-flip",
            of(
                "FLIP to full detail",
                "0 equal, 1 black and white",
                with_scene(views(|foliage| foliage.flip), &|frame| frame.flip),
            ),
        ),
        (
            "quality-ssim",
            of(
                "SSIM to full detail",
                "1 equal",
                with_scene(views(|foliage| foliage.ssim), &|frame| {
                    frame.ssim.unwrap_or(f64::NAN)
                }),
            ),
        ),
    ]
}

/// The part of the page.
pub(super) fn quality_sections(sweep: &Sweep, quality: &SweepQuality) -> Vec<Section> {
    let heading = "What detail does to the picture".to_owned();
    let mut sections = vec![Section::Heading(heading)];
    sections.extend(quality.looks().into_iter().map(|look| Section::Table {
        caption: quality_heading(look).unwrap_or_default(),
        table: quality_table(quality, look, usize::MAX),
    }));
    sections.push(Section::Text(CAPTION.to_owned()));
    sections.extend(quality_notes(sweep, quality).into_iter().map(Section::Text));
    let plots = quality_plots(quality).into_iter();
    sections.extend(plots.map(|(_, plot)| Section::Figure(plot.to_svg())));
    sections
}
