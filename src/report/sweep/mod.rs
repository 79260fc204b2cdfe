//! What a walk along the axis of detail leaves: numbers, curves, and the table of all models.
//!
//! ```text
//! Sweep ─┬─ sweep_json, sweep_csv ──▶ sweep.json, sweep.csv     every step of every model
//!        ├─ sweep_plots ────────────▶ plots/*.svg
//!        ├─ sweep_table, _notes ────▶ terminal, Markdown         one row a model
//!        └─ sweep_page ─────────────▶ report.html, with the SweepPictures of some levels
//! ```
//!
//! With a [`SweepQuality`] each also tells what the levels do to the picture; without, all files are
//! the same byte for byte as if there were no such thing.
//!
//! **Invariant.** "Changes" are uploads but for the view's, which follow the camera. Bytes of
//! different streams are never added; modelled times are.

mod causes;
mod page;
mod pareto;
mod pictures;
mod plots;
mod quality;
mod table;

pub use page::sweep_page;
pub use pictures::SweepPictures;
pub use plots::sweep_plots;
pub use quality::{quality_notes, quality_plots, quality_table};
pub use table::{sweep_markdown, sweep_notes, sweep_table, sweep_text};

use serde::Serialize;

use self::quality::{QualityEntry, quality_cells, quality_columns, quality_heading};

use super::run::{LedgerEntry, TrafficEntry, json};
use super::{Cell, Column, OutputFolder, Plot, ReportError, SweepQuality, Table};
use crate::gpu::{Card, Link, nanoseconds};
use crate::run::{Sweep, SweepModel, SweepStep};

/// The value of `schema` in `sweep.json`.
pub const SWEEP_SCHEMA: &str = "spinney.sweep/1";

/// What was walked.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SweepHeader {
    /// The scene's name.
    pub scene: String,
    /// The link by which wire bytes and bus times are modelled.
    pub link: Link,
    /// The card by which GPU times are modelled.
    pub card: Card,
    /// The scene with all that decided the walk, as a scene file, for the page.
    pub resolved: String,
}

/// A step or a sum of steps; fields in the order of the file.
#[derive(Debug, Clone, Default, Serialize)]
struct StepEntry {
    #[serde(skip_serializing_if = "Option::is_none")]
    level: Option<f64>,
    leaves: u64,
    triangles: u64,
    collapses: u64,
    splits: u64,
    clusters_touched: u64,
    host_records: u64,
    /// Of a trunk that has levels.
    #[serde(skip_serializing_if = "Option::is_none")]
    trunk: Option<TrunkEntry>,
    upload: TrafficEntry,
    fetch: TrafficEntry,
    command_bytes: u64,
    bus_ns: u64,
    gpu_ns: Option<u64>,
    frame_ns: Option<u64>,
    #[serde(flatten)]
    shown: Option<Shown>,
    #[serde(skip_serializing_if = "Option::is_none")]
    quality: Option<QualityEntry>,
}

/// What a change of detail took of trunks.
#[derive(Debug, Clone, Copy, Default, Serialize)]
struct TrunkEntry {
    triangles: u64,
    collapses: u64,
    splits: u64,
    host_records: u64,
}

impl TrunkEntry {
    /// Of a model whose trunk is one of its own.
    fn of(model: &SweepModel, step: &SweepStep) -> Option<Self> {
        model.variant.trunk.map(|_| Self {
            triangles: step.trunk_triangles,
            collapses: u64::from(step.trunk_change.collapses),
            splits: u64::from(step.trunk_change.splits),
            host_records: step.trunk_change.host_records,
        })
    }

    fn add(&mut self, other: Self) {
        self.triangles += other.triangles;
        self.collapses += other.collapses;
        self.splits += other.splits;
        self.host_records += other.host_records;
    }
}

/// What only a step has.
#[derive(Debug, Clone, Serialize)]
struct Shown {
    image_digest: String,
    covered_pixels: u64,
    leaf_area: f64,
    folded_leaves: u64,
}

impl StepEntry {
    fn of(model: &SweepModel, step: &SweepStep) -> Self {
        let ledger = &step.ledger;
        Self {
            level: Some(step.level()),
            leaves: step.leaves,
            triangles: step.triangles,
            collapses: u64::from(step.change.collapses),
            splits: u64::from(step.change.splits),
            clusters_touched: u64::from(step.change.clusters_touched),
            host_records: step.change.host_records,
            trunk: TrunkEntry::of(model, step),
            upload: TrafficEntry::of(&ledger.upload),
            fetch: TrafficEntry::of(&ledger.fetch),
            command_bytes: ledger.command_bytes,
            bus_ns: nanoseconds(ledger.upload.ticks + ledger.fetch.ticks),
            gpu_ns: ledger.gpu_ticks.map(nanoseconds),
            frame_ns: step.frame_ticks().map(nanoseconds),
            shown: Some(Shown {
                image_digest: step.image_digest.to_string(),
                covered_pixels: step.covered_pixels,
                leaf_area: step.leaf_area,
                folded_leaves: step.folded_leaves,
            }),
            quality: None,
        }
    }

    fn add(&mut self, step: &Self) {
        if let Some(trunk) = step.trunk {
            self.trunk.get_or_insert_default().add(trunk);
        }
        self.leaves += step.leaves;
        self.triangles += step.triangles;
        self.collapses += step.collapses;
        self.splits += step.splits;
        self.clusters_touched += step.clusters_touched;
        self.host_records += step.host_records;
        self.upload.add(step.upload);
        self.fetch.add(step.fetch);
        self.command_bytes += step.command_bytes;
        self.bus_ns += step.bus_ns;
        for (sum, time) in [
            (&mut self.gpu_ns, step.gpu_ns),
            (&mut self.frame_ns, step.frame_ns),
        ] {
            if let Some(time) = time {
                *sum.get_or_insert_default() += time;
            }
        }
    }
}

/// The steps with their place on the axis of detail.
fn entries(model: &SweepModel, quality: Option<&SweepQuality>) -> Vec<StepEntry> {
    let entry = |step| StepEntry {
        quality: quality
            .and_then(|quality| quality.of(model, step))
            .map(QualityEntry::of),
        ..StepEntry::of(model, step)
    };
    model.steps.iter().map(entry).collect()
}

/// `sweep.json`: one step a line. The sums of the steps are sums of what the file says of them.
#[must_use]
pub fn sweep_json(header: &SweepHeader, sweep: &Sweep, quality: Option<&SweepQuality>) -> String {
    let models = sweep.models.iter();
    let models: Vec<String> = models.map(|model| model_json(model, quality)).collect();
    let (schema, scene) = (json(&SWEEP_SCHEMA), json(&header.scene));
    let (link, card) = (json(&header.link.name()), json(&header.card.name()));
    let models = models.join(",");
    format!(
        "{{\"schema\":{schema},\"scene\":{scene},\"link\":{link},\"card\":{card},\"models\":[{models}\n]}}\n"
    )
}

fn model_json(model: &SweepModel, quality: Option<&SweepQuality>) -> String {
    let entries = entries(model, quality);
    let mut totals = StepEntry::default();
    entries.iter().for_each(|entry| totals.add(entry));
    let steps: Vec<String> = entries
        .iter()
        .map(|entry| format!("\n{}", json(entry)))
        .collect();
    format!(
        "\n{{\"model\":{},\n\"initial\":{},\n\"steps\":[{}\n],\n\"totals\":{}}}",
        json(&model.variant.label()),
        json(&LedgerEntry::of_ledger(&model.initial)),
        steps.join(","),
        json(&totals)
    )
}

/// `sweep.csv`: a row a model and step. `changes` are the uploads but for the view's. What levels do to
/// the picture stands in columns at the end, if that was asked.
#[must_use]
pub fn sweep_csv(sweep: &Sweep, quality: Option<&SweepQuality>) -> String {
    let numbers = [
        "step",
        "level",
        "leaves",
        "triangles",
        "collapses",
        "splits",
        "clusters_touched",
        "host_records",
        "changes_payload",
        "upload_transfers",
        "upload_payload",
        "upload_wire",
        "upload_ns",
        "fetch_transfers",
        "fetch_payload",
        "fetch_wire",
        "fetch_ns",
        "command_bytes",
        "bus_ns",
        "gpu_ns",
        "frame_ns",
    ];
    let shown = ["covered_pixels", "leaf_area", "folded_leaves"];
    let mut columns = vec![Column::words("model")];
    columns.extend(numbers.into_iter().map(Column::numbers));
    columns.push(Column::words("image_digest"));
    columns.extend(shown.into_iter().map(Column::numbers));
    // A table of foliage alone says nothing of trunks.
    let trunks = sweep
        .models
        .iter()
        .any(|model| model.variant.trunk.is_some());
    if trunks {
        let names = [
            "trunk_triangles",
            "trunk_collapses",
            "trunk_splits",
            "trunk_host_records",
        ];
        columns.extend(names.into_iter().map(Column::numbers));
    }
    if quality.is_some() {
        columns.extend(quality_columns());
    }
    let row = |model, step| {
        let mut cells = csv_cells(model, step);
        if trunks {
            cells.extend(trunk_cells(TrunkEntry::of(model, step)));
        }
        cells.extend(
            quality
                .into_iter()
                .flat_map(|quality| quality_cells(quality.of(model, step))),
        );
        cells
    };
    let models = sweep.models.iter();
    let rows = models.flat_map(|model| model.steps.iter().map(move |step| row(model, step)));
    Table {
        columns,
        rows: rows.collect(),
    }
    .to_csv()
}

fn trunk_cells(trunk: Option<TrunkEntry>) -> [Cell; 4] {
    trunk.map_or([const { Cell::Missing }; 4], |trunk| {
        [
            trunk.triangles,
            trunk.collapses,
            trunk.splits,
            trunk.host_records,
        ]
        .map(Cell::Count)
    })
}

fn csv_cells(model: &SweepModel, step: &SweepStep) -> Vec<Cell> {
    let entry = StepEntry::of(model, step);
    let number = |value| Cell::Number { value, digits: 6 };
    let maybe = |count: Option<u64>| count.map_or(Cell::Missing, Cell::Count);
    let traffic = |traffic: TrafficEntry| {
        let TrafficEntry {
            transfers,
            payload_bytes,
            wire_bytes,
            bus_ns,
        } = traffic;
        [transfers, payload_bytes, wire_bytes, bus_ns].map(Cell::Count)
    };
    let mut cells = vec![
        Cell::Text(model.variant.label()),
        Cell::Count(u64::from(step.step)),
        number(step.level()),
    ];
    cells.extend(
        [
            entry.leaves,
            entry.triangles,
            entry.collapses,
            entry.splits,
            entry.clusters_touched,
            entry.host_records,
            changes(step),
        ]
        .map(Cell::Count),
    );
    cells.extend(traffic(entry.upload));
    cells.extend(traffic(entry.fetch));
    cells.extend([entry.command_bytes, entry.bus_ns].map(Cell::Count));
    cells.extend([maybe(entry.gpu_ns), maybe(entry.frame_ns)]);
    cells.extend([
        Cell::Text(step.image_digest.to_string()),
        Cell::Count(step.covered_pixels),
        number(step.leaf_area),
        Cell::Count(step.folded_leaves),
    ]);
    cells
}

/// Payload of a step's uploads, but for the view's.
fn changes(step: &SweepStep) -> u64 {
    let uploads = step.ledger.transfers.iter();
    uploads
        .filter(|transfer| transfer.stream == crate::gpu::Stream::Upload)
        .filter(|transfer| transfer.cause.kind != super::run::VIEW)
        .map(|transfer| transfer.payload_bytes)
        .sum()
}

/// Writes all that a walk leaves: `sweep.json`, `sweep.csv`, `plots/*.svg`, `table.md`,
/// `report.html`; the page shows the `pictures`, if there are any.
///
/// # Errors
///
/// When a file cannot be written.
pub fn write_sweep(
    folder: &OutputFolder,
    header: &SweepHeader,
    sweep: &Sweep,
    quality: Option<&SweepQuality>,
    pictures: &SweepPictures,
) -> Result<(), ReportError> {
    let (json, csv) = (
        sweep_json(header, sweep, quality),
        sweep_csv(sweep, quality),
    );
    folder.write("sweep.json", json.as_bytes())?;
    folder.write("sweep.csv", csv.as_bytes())?;
    let plots = sweep_plots(sweep).into_iter();
    let mut plots: Vec<(String, Plot)> =
        plots.map(|(name, plot)| (name.to_owned(), plot)).collect();
    plots.extend(quality.into_iter().flat_map(quality_plots));
    for (name, plot) in plots {
        folder.write(&format!("plots/{name}.svg"), plot.to_svg().as_bytes())?;
    }
    let pareto = pareto::plot(sweep, quality);
    folder.write("plots/pareto.svg", pareto.to_svg().as_bytes())?;
    folder.write("table.md", sweep_markdown(sweep, quality).as_bytes())?;
    let page = sweep_page(header, sweep, quality, pictures)?;
    folder.write("report.html", page.as_bytes())
}
