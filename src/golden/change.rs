//! Two tables of a ledger: which counts became more or less.

use std::fmt;

/// A fact of a table that differs.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Change {
    /// Which: `leaves`, `upload payload`, `cause cluster transfers`.
    pub what: String,
    /// What the reference says; a row that it lacks says nothing.
    pub before: Option<String>,
    /// What is so now.
    pub after: Option<String>,
}

impl Change {
    /// By how much a count changed; a row that is absent counts 0. `None` for what is no count.
    #[must_use]
    pub fn by(&self) -> Option<i128> {
        let count = |value: &Option<String>| match value {
            None => Some(0),
            Some(text) => text.parse::<u64>().ok().map(i128::from),
        };
        Some(count(&self.after)? - count(&self.before)?)
    }
}

/// `upload payload 65716 → 65720 (+4)`.
impl fmt::Display for Change {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (before, after) = (shown(self.before.as_ref()), shown(self.after.as_ref()));
        write!(out, "{} {before} → {after}", self.what)?;
        match self.by() {
            Some(by) => write!(out, " ({by:+})"),
            None => Ok(()),
        }
    }
}

/// A value for people.
pub(super) fn shown(value: Option<&String>) -> String {
    match value {
        None => "none".to_owned(),
        // A digest is told apart by its first digits.
        Some(text) if text.len() == 64 => format!("{}…", text.get(..12).unwrap_or(text)),
        Some(text) => text.clone(),
    }
}

/// What differs between two tables: first what the second says, then what it does not say any more,
/// last what is no count, since counts tell more.
pub(super) fn changes(before: &str, after: &str) -> Vec<Change> {
    let (before, after) = (facts(before), facts(after));
    let value_in = |facts: &[(String, String)], what: &str| {
        let found = facts.iter().find(|(name, _)| name == what);
        found.map(|(_, value)| value.clone())
    };
    let mut changes: Vec<Change> = after
        .iter()
        .filter_map(|(what, value)| {
            let before = value_in(&before, what);
            (before.as_ref() != Some(value)).then(|| Change {
                what: what.clone(),
                before,
                after: Some(value.clone()),
            })
        })
        .collect();
    let gone = before
        .iter()
        .filter(|(what, _)| after.iter().all(|(name, _)| name != what));
    changes.extend(gone.map(|(what, value)| Change {
        what: what.clone(),
        before: Some(value.clone()),
        after: None,
    }));
    changes.sort_by_key(|change| change.by().is_none());
    changes
}

/// The facts of a table with their names, in order.
///
/// Names end with two spaces; below a line of headings, each of a row's values is a fact.
fn facts(table: &str) -> Vec<(String, String)> {
    let mut facts = Vec::new();
    let mut headings: Vec<&str> = Vec::new();
    let mut begins = false;
    for line in table.lines().map(str::trim_end) {
        if line.is_empty() {
            begins = true;
            continue;
        }
        let words: Vec<&str> = line
            .split("  ")
            .map(str::trim)
            .filter(|word| !word.is_empty())
            .collect();
        let Some((name, values)) = words.split_first() else {
            continue;
        };
        if begins {
            begins = false;
            headings = words;
            continue;
        }
        match headings.split_first() {
            None => facts.push(((*name).to_owned(), values.join(", "))),
            Some((kind, columns)) => {
                // The rows of streams say themselves what they are.
                let row = match *kind {
                    "stream" => (*name).to_owned(),
                    kind => format!("{kind} {name}"),
                };
                for (column, value) in columns.iter().zip(values) {
                    facts.push((format!("{row} {column}"), (*value).to_owned()));
                }
            }
        }
    }
    facts
}

#[cfg(test)]
mod tests {
    use super::*;

    const TABLE: &str = "\
frame                      4  112 x 112, samples 1
picture           795c7e13b97cf853fa834afd123b540e15da654e95987b3bf4aee2296fd99e9d
leaves                  4090
clusters touched         116

stream            transfers     payload        wire      bus ns
initial upload            16     1464780     1602276      416569
upload                   233       65716       75964      251991

cause             transfers     payload
cluster                  116       65152

buffer            transfers     payload
a label of more than sixteen characters         116         464
";

    fn words(after: &str) -> Vec<String> {
        let changes = changes(TABLE, after);
        changes.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn what_became_more_or_less_is_named() {
        assert_eq!(words(TABLE), [""; 0]);
        assert_eq!(words(&TABLE.replace('\n', "\r\n")), [""; 0]);
        let after = TABLE
            .replace("4090", "4089")
            .replace("      65716", "      65720")
            .replace("cluster                  116       65152\n", "")
            .replace("         464\n", "         468\nnew              1  2\n")
            .replace("795c7e13b97cf853f", "895c7e13b97cf853f")
            .replace("samples 1", "samples 4");
        assert_eq!(
            words(&after),
            [
                "leaves 4090 → 4089 (-1)",
                "upload payload 65716 → 65720 (+4)",
                "buffer a label of more than sixteen characters payload 464 → 468 (+4)",
                "buffer new transfers none → 1 (+1)",
                "buffer new payload none → 2 (+2)",
                "cause cluster transfers 116 → none (-116)",
                "cause cluster payload 65152 → none (-65152)",
                "frame 4, 112 x 112, samples 1 → 4, 112 x 112, samples 4",
                "picture 795c7e13b97c… → 895c7e13b97c…",
            ]
        );
    }
}
