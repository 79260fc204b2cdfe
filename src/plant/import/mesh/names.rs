//! Names: those that the user gave, and those that say what they name.

use std::collections::BTreeSet;

/// The names that the user gave, and whether anything bears them.
#[derive(Debug)]
pub(in crate::plant) struct Names<'a> {
    asked: Vec<(&'a str, bool)>,
}

impl<'a> Names<'a> {
    /// Names that nothing bears yet.
    pub(in crate::plant) fn new(names: &'a [String]) -> Self {
        Self {
            asked: names.iter().map(|name| (name.as_str(), false)).collect(),
        }
    }

    /// Whether a name is one of them.
    pub(in crate::plant) fn has(&mut self, name: Option<&str>) -> bool {
        let mut any = false;
        for (asked, found) in &mut self.asked {
            if Some(*asked) == name {
                *found = true;
                any = true;
            }
        }
        any
    }

    /// A name that nothing bears.
    pub(in crate::plant) fn unknown(&self) -> Option<&'a str> {
        let unknown = self.asked.iter().find(|(_, found)| !found);
        unknown.map(|(name, _)| *name)
    }
}

/// Names for the user to choose from, as an error lists them.
pub(in crate::plant) fn listed(names: &BTreeSet<String>) -> String {
    let shown: Vec<String> = names
        .iter()
        .take(SHOWN)
        .map(|name| format!("{name:?}"))
        .collect();
    match names.len() {
        0 => "no names at all".to_owned(),
        count if count > SHOWN => format!("{} and {} more", shown.join(", "), count - SHOWN),
        _ => shown.join(", "),
    }
}

const SHOWN: usize = 24;

/// Whether a name says that it is borne by leaves.
pub(in crate::plant) fn says_leaves(name: Option<&str>) -> bool {
    let name = name.unwrap_or_default().to_lowercase();
    LEAVES.iter().any(|word| name.contains(word))
}

/// What leaves are called, in English and the languages of French and German tree programs.
const LEAVES: [&str; 8] = [
    "leaf", "leaves", "foliage", "needle", "frond", "feuille", "blatt", "blätter",
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_are_told_by_their_names() {
        for (name, says) in [
            (Some("Leaves.001"), true),
            (Some("oak_LEAF"), true),
            (Some("Bl\u{e4}tter"), true),
            (Some("bark"), false),
            (None, false),
        ] {
            assert_eq!(says_leaves(name), says, "{name:?}");
        }
    }

    #[test]
    fn long_lists_are_cut() {
        let names = |count: u32| (0..count).map(|n| format!("n{n:02}")).collect();
        assert_eq!(listed(&names(0)), "no names at all");
        assert_eq!(listed(&names(2)), "\"n00\", \"n01\"");
        assert!(listed(&names(30)).ends_with("\"n23\" and 6 more"));
    }
}
