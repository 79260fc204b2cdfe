//! `report.html`: a walk on one page.

use super::pictures::SweepPictures;
use super::quality::quality_sections;
use super::{SweepHeader, causes, pareto, sweep_notes, sweep_plots, sweep_table, table};
use crate::report::html::fitting;
use crate::report::{Cell, Column, Page, ReportError, Section, SweepQuality, Table};
use crate::run::{Sweep, SweepModel};

/// `report.html`. Pictures become smaller until it is as small as a page must be.
///
/// # Errors
///
/// When the page is larger than a page may be, even without pictures.
pub fn sweep_page(
    header: &SweepHeader,
    sweep: &Sweep,
    quality: Option<&SweepQuality>,
    pictures: &SweepPictures,
) -> Result<String, ReportError> {
    let mut after = vec![
        Section::Heading("What each model costs".to_owned()),
        Section::Table {
            caption: String::new(),
            table: sweep_table(sweep),
        },
        Section::Text(table::CAPTION.to_owned()),
    ];
    after.extend(sweep_notes(sweep).into_iter().map(Section::Text));
    after.extend([
        Section::Heading("Which models nothing beats".to_owned()),
        Section::Figure(pareto::plot(sweep, quality).to_svg()),
        Section::Text(pareto::MARKS.to_owned()),
    ]);
    let stacks = causes::stacks(sweep);
    if !stacks.is_empty() {
        after.extend([
            Section::Heading("Bytes of each step by cause".to_owned()),
            Section::Text(
                "Each model on its own scale; models that send the same share a plot.".to_owned(),
            ),
            Section::Panels(stacks.iter().map(|stack| stack.to_svg()).collect()),
        ]);
    }
    after.push(Section::Heading("Along the axis of detail".to_owned()));
    let plots = sweep_plots(sweep).into_iter();
    after.extend(plots.map(|(_, plot)| Section::Figure(plot.to_svg())));
    after.extend(
        quality
            .into_iter()
            .flat_map(|quality| quality_sections(sweep, quality)),
    );
    after.push(Section::Heading("Device memory at full detail".to_owned()));
    after.push(Section::Table {
        caption: String::new(),
        table: resident_table(sweep),
    });
    after.extend(Section::scene(&header.resolved));
    let gallery = pictures.gallery(sweep);
    let pictures = pictures.of(&gallery);
    let note = gallery.note();
    fitting(pictures, |files| {
        let mut sections = vec![Section::Text(what_was_walked(header, sweep))];
        if !files.is_empty() {
            sections.push(Section::Comparison(gallery.comparison(files)));
            sections.push(Section::Text(note.clone()));
        }
        sections.extend(after.iter().cloned());
        Page {
            title: format!("{}: all models along the axis of detail", header.scene),
            sections,
        }
    })
}

fn what_was_walked(header: &SweepHeader, sweep: &Sweep) -> String {
    let steps = sweep.models.first().map_or(0, |model| model.steps.len());
    format!(
        "Scene {}: from full detail to the coarsest in {} equal steps, {} models. Times are \
         modelled for the link {} and the card {}. spinney {}.",
        header.scene,
        steps.saturating_sub(1),
        sweep.models.len(),
        header.link.name(),
        header.card.name(),
        env!("CARGO_PKG_VERSION")
    )
}

/// Device memory by label, a column a model.
fn resident_table(sweep: &Sweep) -> Table {
    let all = sweep.models.iter().flat_map(|model| &model.resident);
    let mut labels: Vec<&str> = all.map(|(label, _)| label.as_str()).collect();
    labels.sort_unstable();
    labels.dedup();
    let bytes = |model: &SweepModel, label: &str| {
        let found = model.resident.iter().find(|(known, _)| known == label);
        found.map_or(Cell::Missing, |(_, bytes)| Cell::Count(*bytes))
    };
    let row = |label: &&str| {
        let cells = sweep.models.iter().map(|model| bytes(model, label));
        let name = Cell::Text((*label).to_owned());
        std::iter::once(name).chain(cells).collect()
    };
    let mut rows: Vec<Vec<Cell>> = labels.iter().map(row).collect();
    let sum = |model: &SweepModel| model.resident.iter().map(|(_, bytes)| bytes).sum();
    let sums = sweep.models.iter().map(|model| Cell::Count(sum(model)));
    rows.push(
        std::iter::once(Cell::Text("all".to_owned()))
            .chain(sums)
            .collect(),
    );
    let models = sweep.models.iter();
    let models = models.map(|model| Column::numbers(model.variant.label()));
    Table {
        columns: std::iter::once(Column::words("label, B"))
            .chain(models)
            .collect(),
        rows,
    }
}
