//! What a check found, for programs.

use serde_json::{Map, Value, json};

use super::bless::Blessing;
use super::change::Change;
use super::outcome::{Case, CaseOutcome, Finding, FindingKind, Outcome, SceneOutcome};
use crate::report::Difference;

/// The value of `schema` in the JSON of a check.
pub const GOLDEN_SCHEMA: &str = "spinney.golden/1";

impl Outcome {
    /// The outcome as JSON.
    ///
    /// ```text
    /// { "schema", "same", "summary", "counts": { "scenes", "same", "frames", "tolerated", "differ",
    ///     "missing", "unused", "oversized", "unreadable" },
    ///   "scenes": [ { "scene", "file", "line", "same", "tolerance", "reason",
    ///     "cases": [ { "case", "frame", "same", "tolerated": DIFFERENCE, "findings": [ FINDING ] } ] } ],
    ///   "strays": [ FINDING ] }
    /// FINDING: { "kind", "what", "file", "message", "difference": DIFFERENCE,
    ///     "changes": [ { "what", "before", "after", "by" } ], "parts": [ … ], "evidence" }
    /// DIFFERENCE: { "pixels", "unequal", "of", "largest", "at": [x, y],
    ///     "bounds": [left, top, right, bottom] }
    /// ```
    ///
    /// Of `of` pixels, `unequal` differ at all and `pixels` by more than the tolerance. What does not
    /// apply is null; `evidence` is a file below the output folder.
    #[must_use]
    pub fn to_json(&self) -> String {
        let counts = self.counts();
        let mut counted = Map::new();
        let all = [
            ("scenes", counts.scenes),
            ("same", counts.same),
            ("frames", counts.frames),
            ("tolerated", counts.tolerated),
        ];
        for (name, count) in all.into_iter().chain(counts.wrong()) {
            counted.insert(name.to_owned(), count.into());
        }
        let scenes: Vec<Value> = self.scenes.iter().map(scene).collect();
        let strays: Vec<Value> = self.strays.iter().map(finding).collect();
        let json = json!({
            "schema": GOLDEN_SCHEMA,
            "same": self.is_same(),
            "summary": self.summary(),
            "counts": counted,
            "scenes": scenes,
            "strays": strays,
        });
        format!("{json:#}")
    }
}

impl Blessing {
    /// What blessing did, as JSON: `{ "schema", "extent", "deeds": [ { "deed", … FINDING } ] }` with the
    /// findings of [`Outcome::to_json`].
    #[must_use]
    pub fn to_json(&self) -> String {
        let deeds: Vec<Value> = self
            .findings()
            .map(|(found, deed)| {
                let mut value = finding(found);
                value["deed"] = deed.name().into();
                value
            })
            .collect();
        let extent = self.outcome.extent();
        let json = json!({ "schema": GOLDEN_SCHEMA, "extent": extent, "deeds": deeds });
        format!("{json:#}")
    }
}

fn scene(scene: &SceneOutcome) -> Value {
    let cases: Vec<Value> = scene.cases.iter().map(case).collect();
    json!({
        "scene": scene.name,
        "file": scene.file.display().to_string(),
        "line": scene.line,
        "same": scene.is_same(),
        "tolerance": scene.tolerance,
        "reason": scene.reason,
        "cases": cases,
    })
}

fn case(case: &CaseOutcome) -> Value {
    let frame = match case.case {
        Case::Frame(number) => Some(number),
        Case::Scene | Case::Digests => None,
    };
    let findings: Vec<Value> = case.findings.iter().map(finding).collect();
    json!({
        "case": case.case.to_string(),
        "frame": frame,
        "same": case.findings.is_empty(),
        "tolerated": case.tolerated.as_ref().map(difference),
        "findings": findings,
    })
}

fn finding(finding: &Finding) -> Value {
    let (mut changes, mut parts, mut differs) = (Value::Null, Value::Null, Value::Null);
    match &finding.kind {
        FindingKind::Picture(found) => differs = difference(found),
        FindingKind::Ledger(found) => changes = found.iter().map(change).collect(),
        FindingKind::Digests(found) => parts = found.clone().into(),
        _ => {}
    }
    json!({
        "kind": finding.kind.name(),
        "what": finding.what(),
        "file": finding.file.display().to_string(),
        "message": finding.words(),
        "difference": differs,
        "changes": changes,
        "parts": parts,
        "evidence": finding.evidence.as_ref().map(|evidence| &evidence.name),
    })
}

fn difference(difference: &Difference) -> Value {
    json!({
        "pixels": difference.pixels,
        "unequal": difference.unequal,
        "of": difference.total(),
        "largest": difference.largest,
        "at": difference.largest_at,
        "bounds": difference.bounds,
    })
}

fn change(change: &Change) -> Value {
    json!({
        "what": change.what,
        "before": change.before,
        "after": change.after,
        // No count of 64 bits changes by more than fits, but its difference may.
        "by": change.by().and_then(|by| i64::try_from(by).ok()),
    })
}
