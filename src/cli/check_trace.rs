//! `spinney check-trace`: a recorded trace against the laws.

use std::fs::File;
use std::io::{BufReader, stdin};

use serde_json::{Value, json};

use super::Verdict;
use super::arguments::{CheckTraceOptions, Shared};
use super::error::CliError;
use super::terminal::Terminal;
use crate::document::DocumentError;
use crate::report::{Cell, Column, Table};
use crate::testkit::trace::{self, LawReport, TraceReport};

pub(super) fn check_trace(
    options: &CheckTraceOptions,
    shared: &Shared,
    terminal: &Terminal,
) -> Result<Verdict, CliError> {
    let mut file = options.file.display().to_string();
    let report = if file == "-" {
        "standard input".clone_into(&mut file);
        trace::check_trace(&file, stdin().lock())?
    } else {
        let opened = File::open(&options.file).map_err(|error| DocumentError {
            file: file.clone(),
            line: 1,
            column: 1,
            message: format!("cannot read: {error}"),
        })?;
        trace::check_trace(&file, BufReader::new(opened))?
    };
    if shared.json {
        terminal.print(&format!("{:#}", as_json(&file, &report)))?;
    } else {
        terminal.print(&as_text(&file, &report, terminal.width()))?;
    }
    Ok(if report.is_kept() {
        Verdict::Passed
    } else {
        Verdict::Failed
    })
}

fn as_text(file: &str, report: &TraceReport, width: usize) -> String {
    let (leaves, collapses, steps) = (report.leaves, report.collapses, report.steps);
    let mut text = format!("{file}: leaves {leaves}, collapses {collapses}, steps {steps}\n\n");
    let table = Table {
        columns: vec![
            Column::words("law"),
            Column::numbers("checked"),
            Column::words("result"),
        ],
        rows: report.laws.iter().map(row).collect(),
    };
    text.push_str(&table.to_text(width));
    for law in &report.laws {
        if let Some((line, violation)) = &law.first {
            text.push_str(&format!("\n{file}:{line}: {violation}\n"));
        }
    }
    if report.forgotten > 0 {
        text.push_str(&format!(
            "\nThere were more states than are remembered: {} steps were not compared with earlier ones.\n",
            report.forgotten
        ));
    }
    text
}

fn row(law: &LawReport) -> Vec<Cell> {
    let result = match (law.checked, law.broken) {
        (0, _) => "not recorded".to_owned(),
        (_, 0) => "kept".to_owned(),
        (_, broken) => format!("broken: {broken}"),
    };
    vec![
        Cell::Text(law.law.name().to_owned()),
        Cell::Count(law.checked),
        Cell::Text(result),
    ]
}

/// The schema `spinney.trace-report/1`.
fn as_json(file: &str, report: &TraceReport) -> Value {
    let laws: Vec<Value> = report
        .laws
        .iter()
        .map(|law| {
            let result = match (law.checked, law.broken) {
                (0, _) => "not recorded",
                (_, 0) => "kept",
                _ => "broken",
            };
            let first = law.first.as_ref().map(|(line, violation)| {
                json!({
                    "line": line,
                    "place": violation.place,
                    "what": violation.what,
                    "expected": violation.expected,
                    "found": violation.found,
                })
            });
            json!({
                "law": law.law.name(),
                "checked": law.checked,
                "broken": law.broken,
                "result": result,
                "first": first,
            })
        })
        .collect();
    json!({
        "schema": "spinney.trace-report/1",
        "file": file,
        "leaves": report.leaves,
        "collapses": report.collapses,
        "steps": report.steps,
        "not_compared": report.forgotten,
        "kept": report.is_kept(),
        "laws": laws,
    })
}
