//! Ledgers field by field.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use serde_json::Value;

/// A field that two ledgers do not agree about.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldDifference {
    /// The keys that lead to it, with dots between them: `upload.payload_bytes`,
    /// `by_buffer.leaves.transfers`.
    pub name: String,
    /// What the first says, if anything.
    pub expected: Option<Value>,
    /// What the second says.
    pub actual: Option<Value>,
}

impl FieldDifference {
    /// Where two values of one type differ, sorted by name. A count that is missing on one side, such
    /// as that of a buffer nobody wrote to, is missing, not 0.
    pub(super) fn all(expected: &impl Serialize, actual: &impl Serialize) -> Vec<Self> {
        let [one, other] = [fields(expected), fields(actual)];
        let names: BTreeSet<&String> = one.keys().chain(other.keys()).collect();
        let difference = |name: &String| {
            let [expected, actual] = [one.get(name), other.get(name)];
            (expected != actual).then(|| Self {
                name: name.clone(),
                expected: expected.cloned(),
                actual: actual.cloned(),
            })
        };
        names.into_iter().filter_map(difference).collect()
    }

    /// How much more the second has, what is missing counted as 0; none for words.
    #[must_use]
    pub fn change(&self) -> Option<i128> {
        let count = |value: &Option<Value>| match value {
            None => Some(0),
            Some(value) => value.as_u64().map(i128::from),
        };
        Some(count(&self.actual)? - count(&self.expected)?)
    }
}

/// The values at the ends of a tree of objects, by the keys that lead there.
fn fields(value: &impl Serialize) -> BTreeMap<String, Value> {
    let mut fields = BTreeMap::new();
    let value = serde_json::to_value(value).expect("keys are texts, values numbers and texts");
    collect(String::new(), value, &mut fields);
    fields
}

fn collect(name: String, value: Value, fields: &mut BTreeMap<String, Value>) {
    match value {
        Value::Object(map) => {
            let dot = if name.is_empty() { "" } else { "." };
            for (key, value) in map {
                collect(format!("{name}{dot}{key}"), value, fields);
            }
        }
        Value::Null => {}
        value => {
            fields.insert(name, value);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::{LedgerEntry, ShareEntry};

    #[test]
    fn fields_are_named_by_the_way_to_them() {
        let mut one = LedgerEntry {
            frame: Some(7),
            draws: 3,
            ..LedgerEntry::default()
        };
        let mut other = one.clone();
        assert_eq!(FieldDifference::all(&one, &other), []);
        one.upload.payload_bytes = 12;
        other.draws = 5;
        let share = ShareEntry {
            transfers: 1,
            payload_bytes: 9,
        };
        other.by_buffer.insert("a.b".to_owned(), share);
        let found = FieldDifference::all(&one, &other);
        let told: Vec<_> = found
            .iter()
            .map(|field| (field.name.as_str(), field.change()))
            .collect();
        let wanted = [
            ("by_buffer.a.b.payload_bytes", Some(9)),
            ("by_buffer.a.b.transfers", Some(1)),
            ("draws", Some(2)),
            ("upload.payload_bytes", Some(-12)),
        ];
        assert_eq!(told, wanted);
        assert_eq!(found[0].expected, None);
    }
}
