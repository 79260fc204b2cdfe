//! `spinney selftest`: whether the laws catch every shipped mutant, and nothing else.

use serde_json::{Value, json};

use super::Verdict;
use super::arguments::Shared;
use super::error::CliError;
use super::terminal::Terminal;
use crate::testkit::{self, Law, MutantReport, SelftestReport};

pub(super) fn selftest(shared: &Shared, terminal: &Terminal) -> Result<Verdict, CliError> {
    let report = testkit::selftest();
    if shared.json {
        terminal.print(&format!("{:#}", as_json(&report)))?;
    } else {
        terminal.print(&as_text(&report, terminal))?;
    }
    Ok(if report.is_passed() {
        Verdict::Passed
    } else {
        Verdict::Failed
    })
}

fn as_text(report: &SelftestReport, terminal: &Terminal) -> String {
    let caught = report.mutants.len() - report.escaped().count();
    let mut text = format!(
        "{caught} of {} mutants are caught\n\n",
        report.mutants.len()
    );
    text.push_str(&line("mutant", "caught by", "cases"));
    for mutant in &report.mutants {
        text.push('\n');
        let by = mutant.caught_by().map_or("NOTHING", Law::name);
        text.push_str(&line(&mutant.name, by, &mutant.cases.to_string()));
        text.push_str(&indented(terminal, &mutant.fault));
        if let Some(counterexample) = &mutant.counterexample {
            let example = format!("smallest: {}", counterexample.example);
            text.push_str(&indented(terminal, &example));
            text.push_str(&indented(terminal, &counterexample.violation.to_string()));
        }
    }
    let kept = report.sound.len() - report.false_alarms().count();
    text.push_str(&format!(
        "\n{kept} of {} sound models pass\n\n",
        report.sound.len()
    ));
    text.push_str(&line("sound model", "result", "cases"));
    for model in &report.sound {
        let result = model.caught_by().map_or("passes", Law::name);
        text.push_str(&line(&model.name, result, &model.cases.to_string()));
        if let Some(counterexample) = &model.counterexample {
            text.push_str(&indented(terminal, &counterexample.example));
            text.push_str(&indented(terminal, &counterexample.violation.to_string()));
        }
    }
    text.push('\n');
    text.push_str(&terminal.wrapped(&format!("Checks: {}.", report.tally)));
    text
}

fn line(name: &str, result: &str, cases: &str) -> String {
    format!("{name:<26}  {result:<25}  {cases:>8}\n")
}

/// A sentence as indented lines.
fn indented(terminal: &Terminal, sentence: &str) -> String {
    let lines = terminal.wrapped(sentence);
    lines.lines().map(|line| format!("    {line}\n")).collect()
}

/// The schema `spinney.selftest/1`.
fn as_json(report: &SelftestReport) -> Value {
    let subject = |subject: &MutantReport| {
        let violation = subject
            .counterexample
            .as_ref()
            .map(|found| &found.violation);
        json!({
            "name": subject.name,
            "fault": subject.fault,
            "caught_by": subject.caught_by().map(Law::name),
            "cases": subject.cases,
            "smallest": subject.counterexample.as_ref().map(|found| &found.example),
            "place": violation.map(|violation| &violation.place),
            "what": violation.map(|violation| &violation.what),
            "expected": violation.map(|violation| &violation.expected),
            "found": violation.map(|violation| &violation.found),
        })
    };
    let checks = Law::ALL.map(|law| (law.name().to_owned(), report.tally.checked(law).into()));
    json!({
        "schema": "spinney.selftest/1",
        "passed": report.is_passed(),
        "mutants": report.mutants.iter().map(subject).collect::<Vec<_>>(),
        "sound": report.sound.iter().map(subject).collect::<Vec<_>>(),
        "checks": Value::Object(checks.into_iter().collect()),
    })
}
