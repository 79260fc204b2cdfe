//! The table of keys holds together, and `keys.md` tells what it says.

use super::*;

/// The keys as a table in Markdown: what `keys.md` must hold.
fn key_table() -> String {
    let mut table =
        "| key | values | unit | if absent | meaning |\n|---|---|---|---|---|\n".to_owned();
    for key in KEYS {
        let absent = match key.absent {
            Absent::Required => "required".to_owned(),
            Absent::Value(value) => format!("`{value}`"),
            Absent::Rule(rule) => rule.to_owned(),
        };
        table += &format!(
            "| `{}` | {} | {} | {absent} | {} |\n",
            key.path,
            // Brackets would read as links.
            key.kind.wanted().replace('[', "\\[").replace(']', "\\]"),
            key.unit,
            key.meaning.replace('[', "\\[").replace(']', "\\]"),
        );
    }
    table
}

#[test]
fn documentation_tells_what_the_table_says() {
    // To renew: write the left side to keys.md.
    assert_eq!(key_table(), include_str!("keys.md"));
}

#[test]
fn every_key_stands_below_its_table_and_only_once() {
    for (index, key) in KEYS.iter().enumerate() {
        let before = &KEYS[..index];
        assert!(
            before.iter().all(|other| other.path != key.path),
            "{}",
            key.path
        );
        if let Some((table, _)) = key.path.rsplit_once('.') {
            let table = table.trim_end_matches("[]");
            assert!(
                before.iter().any(|other| other.path == table),
                "{}",
                key.path
            );
        }
    }
}

#[test]
fn help_names_every_key_with_unit_and_default() {
    let help = key_help();
    assert!(help.contains(
        "camera.near\n    Nothing nearer is drawn.\n    a number from 0.001 to 100000 (m); default 0.1\n"
    ));
    assert!(
        help.lines().all(|line| line.chars().count() <= 140),
        "{help}"
    );
}
