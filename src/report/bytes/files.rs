//! What a walk for bytes leaves: numbers for programs, and a page.

use serde::Serialize;

use super::ByteReport;
use super::entries::{Entry, bases, entries};
use super::plots::{MARKS, bytes_plots, plant_plot, together_plot};
use super::sums::{Part, ticks};
use super::table::{
    bytes_markdown, groups, heading, notes, plant_heading, plant_table, together_heading,
    together_table,
};
use crate::gpu::nanoseconds;
use crate::report::run::{TrafficEntry, json};
use crate::report::{Cell, Column, OutputFolder, Page, ReportError, Section, Table};
use crate::run::PlantBytes;

/// The value of `schema` in `bytes.json`.
pub const BYTES_SCHEMA: &str = "spinney.bytes/1";

/// A model of a plant on a link; fields in the order of the file.
#[derive(Debug, Clone, Serialize)]
struct LinkEntry {
    link: &'static str,
    initial: TrafficEntry,
    /// All steps, with the frame of step 0.
    walk: PartEntry,
    /// Steps 1 to the last.
    changes: PartEntry,
    longest_change_ns: u64,
    against: Vec<AgainstEntry>,
    /// Whether no other model beats it; null for what has no levels.
    unbeaten: Option<bool>,
}

/// Some steps together.
#[derive(Debug, Clone, Copy, Serialize)]
struct PartEntry {
    upload: TrafficEntry,
    fetch: TrafficEntry,
    command_bytes: u64,
    vertices: u64,
    bus_ns: u64,
}

/// How a model compares with another.
#[derive(Debug, Clone, Copy, Serialize)]
struct AgainstEntry {
    model: &'static str,
    verdict: &'static str,
}

impl LinkEntry {
    fn of(report: &ByteReport, bases: &[&'static str], entry: &Entry, link: usize) -> Self {
        let sums = &entry.sums;
        let part = |part: &Part| {
            let traffic = part.on(link);
            PartEntry {
                upload: TrafficEntry::of(&traffic.upload),
                fetch: TrafficEntry::of(&traffic.fetch),
                command_bytes: part.command_bytes,
                vertices: part.vertices,
                bus_ns: nanoseconds(ticks(&traffic)),
            }
        };
        let verdicts = bases.iter().zip(&entry.against);
        let against = verdicts.filter_map(|(model, of_links)| {
            let verdict = of_links.get(link)?.first()?.words();
            Some(AgainstEntry { model, verdict })
        });
        let initial = sums.initial.get(link).copied().unwrap_or_default();
        let longest = sums.longest.get(link).copied().unwrap_or(0);
        let unbeaten = entry.unbeaten.get(link).copied().flatten();
        Self {
            link: report.links[link].name(),
            initial: TrafficEntry::of(&initial),
            walk: part(&sums.walk),
            changes: part(&sums.changes),
            longest_change_ns: nanoseconds(longest),
            against: against.collect(),
            unbeaten: unbeaten.map(|count| count > 0),
        }
    }
}

/// The models of a plant with what they send on each link.
fn link_entries(report: &ByteReport, plant: &PlantBytes) -> Vec<(Entry, Vec<LinkEntry>)> {
    let of_group = |group| {
        let bases = bases(report, group);
        let of_entry = move |entry: Entry| {
            let links = 0..report.links.len();
            let of_link = |link| LinkEntry::of(report, &bases, &entry, link);
            let links = links.map(of_link).collect();
            (entry, links)
        };
        entries(report, plant, group).into_iter().map(of_entry)
    };
    groups(report).flat_map(of_group).collect()
}

/// `bytes.json`: a model a line.
#[must_use]
pub fn bytes_json(report: &ByteReport) -> String {
    let plant = |plant: &PlantBytes| {
        let models = link_entries(report, plant).into_iter();
        let models = models.map(|(entry, links)| {
            format!(
                "\n{{\"model\":{},\"resident_bytes\":{},\"links\":{}}}",
                json(&entry.variant),
                entry.sums.resident_bytes,
                json(&links)
            )
        });
        let models: Vec<String> = models.collect();
        format!(
            "\n{{\"plant\":{},\"leaves\":{},\"clusters\":{},\"models\":[{}\n]}}",
            json(&plant.name),
            plant.leaves,
            plant.clusters,
            models.join(",")
        )
    };
    let plants: Vec<String> = report.plants.iter().map(plant).collect();
    format!(
        "{{\"schema\":{},\"scene\":{},\"steps\":{},\"plants\":[{}\n]}}\n",
        json(&BYTES_SCHEMA),
        json(&report.scene),
        report.steps,
        plants.join(",")
    )
}

/// `bytes.csv`: a row a plant, model and link. Columns of a walk are of all steps, those of changes of
/// steps 1 to the last.
#[must_use]
pub fn bytes_csv(report: &ByteReport) -> String {
    let traffic = ["transfers", "payload", "wire", "ns"];
    let part = ["command_bytes", "vertices", "bus_ns"];
    let mut columns = ["plant", "model", "link"].map(Column::words).to_vec();
    let mut numbers = |names: &[String]| columns.extend(names.iter().map(Column::numbers));
    numbers(&["leaves", "clusters", "steps", "resident_bytes"].map(str::to_owned));
    numbers(&traffic.map(|name| format!("initial_{name}")));
    for steps in ["walk", "changes"] {
        for stream in ["upload", "fetch"] {
            numbers(&traffic.map(|name| format!("{steps}_{stream}_{name}")));
        }
        numbers(&part.map(|name| format!("{steps}_{name}")));
    }
    numbers(&["longest_change_ns".to_owned()]);
    let known = groups(report).flat_map(|group| bases(report, group));
    let known: Vec<&str> = known.collect();
    let against = known.iter().map(|base| format!("against_{base}"));
    columns.extend(against.map(Column::words));
    columns.push(Column::words("unbeaten"));
    let row = |plant: &PlantBytes, entry: &Entry, of_link: &LinkEntry| {
        let count = Cell::Count;
        let traffic = |traffic: &TrafficEntry| {
            let TrafficEntry {
                transfers,
                payload_bytes,
                wire_bytes,
                bus_ns,
            } = *traffic;
            [transfers, payload_bytes, wire_bytes, bus_ns].map(count)
        };
        let mut cells = vec![
            Cell::Text(plant.name.clone()),
            Cell::Text(entry.variant.label()),
            Cell::Text(of_link.link.to_owned()),
        ];
        let sizes = [plant.leaves, plant.clusters, u64::from(report.steps)];
        cells.extend(sizes.map(count));
        cells.push(count(entry.sums.resident_bytes));
        cells.extend(traffic(&of_link.initial));
        for part in [&of_link.walk, &of_link.changes] {
            cells.extend(traffic(&part.upload));
            cells.extend(traffic(&part.fetch));
            cells.extend([part.command_bytes, part.vertices, part.bus_ns].map(count));
        }
        cells.push(count(of_link.longest_change_ns));
        let verdict = |base: &&str| {
            let found = of_link.against.iter().find(|other| other.model == *base);
            found.map_or(Cell::Missing, |found| Cell::Text(found.verdict.to_owned()))
        };
        cells.extend(known.iter().map(verdict));
        cells.push(match of_link.unbeaten {
            None => Cell::Missing,
            Some(true) => Cell::Text("yes".to_owned()),
            Some(false) => Cell::Text("no".to_owned()),
        });
        cells
    };
    let mut rows = Vec::new();
    for plant in &report.plants {
        for (entry, links) in link_entries(report, plant) {
            rows.extend(links.iter().map(|of_link| row(plant, &entry, of_link)));
        }
    }
    Table { columns, rows }.to_csv()
}

/// `report.html`.
///
/// # Errors
///
/// When the page is larger than a page may be.
pub fn bytes_page(report: &ByteReport) -> Result<String, ReportError> {
    let links = report.links.iter().map(|link| link.name());
    let links: Vec<&str> = links.collect();
    let mut sections = vec![Section::Text(format!(
        "Scene {}: each plant alone, from full detail to the coarsest in {} equal steps. Times are modelled \
         for {}. No picture was drawn. spinney {}.",
        report.scene,
        report.steps,
        links.join(" and "),
        env!("CARGO_PKG_VERSION")
    ))];
    sections.push(Section::Heading(together_heading(report)));
    for group in groups(report) {
        sections.push(Section::Table {
            caption: heading(group).to_owned(),
            table: together_table(report, group),
        });
        sections.push(Section::Figure(together_plot(report, group).to_svg()));
    }
    let notes = notes(report).into_iter().chain([MARKS]);
    sections.extend(notes.map(|text| Section::Text(text.to_owned())));
    if report.plants.len() > 1 {
        for plant in 0..report.plants.len() {
            sections.push(Section::Heading(plant_heading(report, plant)));
            for group in groups(report) {
                sections.push(Section::Table {
                    caption: heading(group).to_owned(),
                    table: plant_table(report, plant, group),
                });
                sections.push(Section::Figure(plant_plot(report, plant, group).to_svg()));
            }
        }
    }
    sections.extend(Section::scene(&report.resolved));
    Page {
        title: format!("{}: the bytes of every model", report.scene),
        sections,
    }
    .to_html()
}

/// Writes all that a walk for bytes leaves: `bytes.json`, `bytes.csv`, `plots/*.svg`, `table.md`,
/// `report.html`.
///
/// # Errors
///
/// When a file cannot be written.
pub fn write_bytes(folder: &OutputFolder, report: &ByteReport) -> Result<(), ReportError> {
    folder.write("bytes.json", bytes_json(report).as_bytes())?;
    folder.write("bytes.csv", bytes_csv(report).as_bytes())?;
    for (name, plot) in bytes_plots(report) {
        folder.write(&format!("plots/{name}.svg"), plot.to_svg().as_bytes())?;
    }
    folder.write("table.md", bytes_markdown(report).as_bytes())?;
    folder.write("report.html", bytes_page(report)?.as_bytes())
}
