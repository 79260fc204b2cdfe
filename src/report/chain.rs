//! What an own tree's levels of detail hold, and the files that hold them.

use serde_json::{Value, json};

use super::{Cell, Column, OutputFolder, ReportError, Table};
use crate::run::LodChain;

/// The value of `schema` in `build.json`.
pub const BUILD_SCHEMA: &str = "spinney.build/1";

/// What was made of a tree.
#[derive(Debug, Clone, PartialEq)]
pub struct ChainReport {
    plant: String,
    levels: Vec<LevelFacts>,
    /// Names and bytes.
    files: Vec<(String, u64)>,
    remarks: Vec<String>,
}

#[derive(Debug, Clone, PartialEq)]
struct LevelFacts {
    chain: &'static str,
    file: String,
    leaves: u32,
    triangles: u64,
    lines: u64,
    error: Option<f32>,
    coverage: f32,
    bytes: u64,
}

impl ChainReport {
    /// Of a chain in these files; `remarks` are what importing had to say.
    #[must_use]
    pub fn new(
        plant: &str,
        chain: &LodChain,
        files: &[(String, Vec<u8>)],
        remarks: &[String],
    ) -> Self {
        let bytes = |name: &str| {
            let found = files.iter().find(|(file, _)| file == name);
            found.map_or(0, |(_, bytes)| bytes.len() as u64)
        };
        let rungs = chain.chains().flat_map(|(chain, rungs)| {
            let all = rungs.iter();
            all.map(move |rung| (chain, rung))
        });
        let levels = rungs.map(|(chain, rung)| {
            let file = format!("{}.glb", rung.level.name);
            LevelFacts {
                chain,
                leaves: rung.leaves,
                triangles: rung.triangles,
                lines: rung.lines,
                error: rung.error,
                coverage: rung.level.coverage,
                bytes: bytes(&file),
                file,
            }
        });
        let sizes = files
            .iter()
            .map(|(name, bytes)| (name.clone(), bytes.len() as u64));
        Self {
            plant: plant.to_owned(),
            levels: levels.collect(),
            files: sizes.collect(),
            remarks: remarks.to_vec(),
        }
    }

    /// A row a level.
    #[must_use]
    pub fn table(&self) -> Table {
        let columns = [
            "leaves",
            "triangles",
            "lines",
            "error, mm",
            "shown below, % of height",
            "bytes",
        ];
        let columns = columns.into_iter().map(Column::numbers);
        let number = |value: f32, digits| Cell::Number {
            value: f64::from(value),
            digits,
        };
        // A level shows once the one before is finer than needed.
        let mut before: Option<&LevelFacts> = None;
        let rows = self.levels.iter().map(|level| {
            let finer = before
                .replace(level)
                .filter(|finer| finer.chain == level.chain);
            vec![
                Cell::Text(level.file.clone()),
                Cell::Count(level.leaves.into()),
                Cell::Count(level.triangles),
                Cell::Count(level.lines),
                level
                    .error
                    .map_or(Cell::Missing, |error| number(1000.0 * error, 1)),
                finer.map_or(Cell::Missing, |finer| number(100.0 * finer.coverage, 2)),
                Cell::Count(level.bytes),
            ]
        });
        Table {
            rows: rows.collect(),
            columns: std::iter::once(Column::words("file"))
                .chain(columns)
                .collect(),
        }
    }
}

/// The levels as a table, for terminals.
#[must_use]
pub fn chain_text(report: &ChainReport, width: usize) -> String {
    report.table().to_text(width)
}

/// The levels and files as JSON: `build.json`.
#[must_use]
pub fn chain_json(report: &ChainReport) -> String {
    let levels = report.levels.iter().map(|level| {
        json!({
            "chain": level.chain,
            "file": level.file,
            "leaves": level.leaves,
            "triangles": level.triangles,
            "lines": level.lines,
            "error_m": level.error,
            "coverage": level.coverage,
            "bytes": level.bytes,
        })
    });
    let files = report.files.iter();
    let files = files.map(|(name, bytes)| json!({ "file": name, "bytes": bytes }));
    let document = json!({
        "schema": BUILD_SCHEMA,
        "plant": report.plant,
        "levels": levels.collect::<Vec<Value>>(),
        "files": files.collect::<Vec<Value>>(),
        "remarks": report.remarks,
    });
    format!("{document:#}\n")
}

/// Writes the files, `build.json` and `levels.csv`.
///
/// # Errors
///
/// When a file cannot be written.
pub fn write_chain(
    output: &OutputFolder,
    report: &ChainReport,
    files: &[(String, Vec<u8>)],
) -> Result<(), ReportError> {
    for (name, bytes) in files {
        output.write(name, bytes)?;
    }
    output.write("build.json", chain_json(report).as_bytes())?;
    output.write("levels.csv", report.table().to_csv().as_bytes())
}
