//! What was asked of two runs that is not the same: keys of scenes and of species.

use std::collections::BTreeMap;

use serde::Serialize;

use super::RecordedRun;
use crate::scene::PlantSource;

/// A key that two runs do not share the value of.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct AskedDifference {
    /// The key's path, such as `tree[1].at`; `version` is spinney's own.
    pub key: String,
    /// A's value, as TOML; `None` where A does not have the key.
    pub a: Option<String>,
    /// B's value.
    pub b: Option<String>,
}

/// A plant's file that two runs do not share the content of.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct PlantFileDifference {
    /// The first tree that comes from it.
    pub tree: u32,
    /// A's copy, relative to its folder.
    pub a: String,
    /// B's copy.
    pub b: String,
    /// The keys that differ, where both are species; empty where only comments do.
    pub keys: Vec<AskedDifference>,
}

/// The keys of both scenes that differ, ascending, after version, card and frames.
pub(super) fn asked(a: &RecordedRun, b: &RecordedRun) -> Vec<AskedDifference> {
    let mut list = Vec::new();
    let heads = [a, b].map(|run| {
        let frames: Vec<String> = run.frames().iter().map(u32::to_string).collect();
        let counted = run.ledger().totals.work.is_some();
        [
            ("version", run.ledger().head.version.clone()),
            ("frames drawn", format!("[{}]", frames.join(", "))),
            ("exact counters", counted.to_string()),
        ]
    });
    let [ours, theirs] = heads;
    for ((key, a), (_, b)) in ours.into_iter().zip(theirs) {
        if a != b {
            list.push(AskedDifference {
                key: key.to_owned(),
                a: Some(a),
                b: Some(b),
            });
        }
    }
    let keys = [a, b].map(|run| {
        let mut keys = flat(run.resolved());
        // An answer, not a question.
        keys.retain(|key, _| !key.ends_with(".plant_digest") && !key.ends_with(".plant_digests"));
        keys
    });
    list.extend(differences(keys));
    list
}

/// The files of plants that differ, once each, in the order of trees.
pub(super) fn plant_files(a: &RecordedRun, b: &RecordedRun) -> Vec<PlantFileDifference> {
    let mut list: Vec<PlantFileDifference> = Vec::new();
    let [ours, theirs] = [a, b].map(|run| run.scene().standing_trees());
    let trees = ours.iter().zip(&theirs);
    for (number, (ours, theirs)) in (0..).zip(trees) {
        let paths = [&ours.source, &theirs.source].map(|source| match source {
            PlantSource::Species(path) | PlantSource::File { path, .. } => path,
        });
        if list.iter().any(|known| [&known.a, &known.b] == paths) {
            continue;
        }
        let texts = [a.text(paths[0]), b.text(paths[1])];
        let keys = match &texts {
            [Some(ours), Some(theirs)] if ours == theirs => continue,
            [Some(ours), Some(theirs)] => differences([flat(ours), flat(theirs)]),
            // Binary files are told by their plants.
            _ => continue,
        };
        list.push(PlantFileDifference {
            tree: number,
            a: paths[0].clone(),
            b: paths[1].clone(),
            keys,
        });
    }
    list
}

fn differences([a, b]: [BTreeMap<String, String>; 2]) -> Vec<AskedDifference> {
    let mut keys: Vec<&String> = a.keys().chain(b.keys()).collect();
    keys.sort();
    keys.dedup();
    let differ = keys.into_iter().filter(|key| a.get(*key) != b.get(*key));
    differ
        .map(|key| AskedDifference {
            key: key.clone(),
            a: a.get(key).cloned(),
            b: b.get(key).cloned(),
        })
        .collect()
}

/// The values of a TOML text by their paths; nothing where it is no TOML.
fn flat(text: &str) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    if let Ok(table) = text.parse::<toml::Table>() {
        collect("", &toml::Value::Table(table), &mut found);
    }
    found
}

/// Nesting is bounded by the parser.
fn collect(path: &str, value: &toml::Value, found: &mut BTreeMap<String, String>) {
    match value {
        toml::Value::Table(table) => {
            for (key, below) in table {
                let path = match path {
                    "" => key.clone(),
                    _ => format!("{path}.{key}"),
                };
                collect(&path, below, found);
            }
        }
        toml::Value::Array(list) if list.iter().any(toml::Value::is_table) => {
            for (index, below) in list.iter().enumerate() {
                collect(&format!("{path}[{index}]"), below, found);
            }
        }
        _ => _ = found.insert(path.to_owned(), value.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_compared_by_path() {
        let a = "x = 1\n[[tree]]\nat = [0.0, 1.0]\n[[tree]]\nat = [0.0, 2.0]\n";
        let b = "[[tree]]\nat = [0.0, 1.0]\n[[tree]]\nat = [0.5, 2.0]\n";
        let found = differences([flat(a), flat(b)]);
        let said: Vec<_> = found
            .iter()
            .map(|one| (one.key.as_str(), one.a.as_deref(), one.b.as_deref()))
            .collect();
        assert_eq!(
            said,
            [
                ("tree[1].at", Some("[0.0, 2.0]"), Some("[0.5, 2.0]")),
                ("x", Some("1"), None)
            ]
        );
    }
}
