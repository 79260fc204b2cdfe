//! Species files: the table of keys is true, and errors stand where the fault is.

use super::Species;
use crate::document::{Document, DocumentError};

/// A species with one line added to a section: `""` the head, `foliage` its table, or a table's name.
fn with(section: &str, line: &str) -> String {
    let [head, foliage, table] = match section {
        "" => [line, "", ""],
        "foliage" => ["", line, ""],
        _ => ["", "", line],
    };
    let table = if table.is_empty() {
        String::new()
    } else {
        format!("[{section}]\n{table}\n")
    };
    format!(
        "schema = \"spinney.species/1\"\nname = \"x\"\n{head}\n[[foliage]]\nsilhouette = \"round\"\n{foliage}\n{table}"
    )
}

fn parse(text: &str) -> Result<Species, DocumentError> {
    Species::parse(&Document {
        file: "x.toml".to_owned(),
        text: text.to_owned(),
    })
}

/// Line and column of a mark in a text, both from 1; ASCII only.
fn place_of(text: &str, mark: &str) -> (usize, usize) {
    let offset = text.find(mark).expect("the text holds the mark");
    crate::document::line_and_column(text, offset)
}

/// The rows of the table of keys that state a range of numbers: key, default, range.
fn rows() -> Vec<[&'static str; 4]> {
    Species::HELP
        .lines()
        .filter(|line| line.starts_with("| `"))
        .map(|line| {
            let cells: Vec<&str> = line.split('|').map(str::trim).collect();
            let key = cells[1].trim_matches('`');
            let (section, key) = key.split_once('.').unwrap_or(("", key));
            [section, key, cells[3], cells[4]]
        })
        .filter(|row| row[3].contains("..="))
        .collect()
}

fn value(default: &str, number: f64) -> String {
    if default.starts_with('[') {
        format!("[{number}, {number}, {number}, {number}]")
    } else {
        format!("{number}")
    }
}

#[test]
fn the_table_of_keys_states_the_ranges() {
    let rows = rows();
    assert!(rows.len() >= 50, "only {} rows found", rows.len());
    for [section, key, default, range] in rows {
        let (least, most) = range.split_once("..=").expect("filtered for it");
        let [least, most]: [f64; 2] = [least, most].map(|end| end.parse().expect("a number"));
        for wrong in [least - 1.0, most + 1.0] {
            let text = with(section, &format!("{key} = {}", value(default, wrong)));
            let error = parse(&text).expect_err(key);
            let (line, column) = place_of(&text, &format!("{key} = "));
            let inside = usize::from(default.starts_with('['));
            assert_eq!(error.line, line, "{error}");
            assert_eq!(error.column, column + key.len() + 3 + inside, "{error}");
            assert!(error.message.contains(key), "{error}");
            assert!(error.message.contains(&wrong.to_string()), "{error}");
            assert!(error.message.contains("wanted"), "{error}");
        }
        // Variations have to stay below what they vary, so their greatest value needs company.
        let ends = if key.ends_with("scale_v") {
            vec![least]
        } else {
            vec![least, most]
        };
        for end in ends {
            let text = with(
                section,
                &format!("{}{key} = {}", company(key), value(default, end)),
            );
            parse(&text).unwrap_or_else(|error| panic!("{error}"));
        }
    }
}

/// What has to be said with a key.
fn company(key: &str) -> &'static str {
    match key {
        "droop" | "fold" => "faces = 10\n",
        _ => "",
    }
}

#[test]
fn the_table_of_keys_states_the_defaults() {
    for [section, key, default, _] in rows() {
        if default != "none" {
            let alone = company(key);
            let plain = parse(&with(if alone.is_empty() { "" } else { section }, alone)).unwrap();
            let stated = parse(&with(section, &format!("{alone}{key} = {default}"))).unwrap();
            assert_eq!(stated, plain, "{section}.{key} = {default}");
        }
    }
}

#[test]
fn wrong_values_are_named_with_line_and_column() {
    let cases = [
        ("wood", "ratio = nan", "nan", "wanted 0.0001..=0.5"),
        ("crown", "scale = inf", "inf", "wanted 0.05..=150"),
        ("crown", "scale = 1e300", "1e300", "wanted 0.05..=150"),
        ("crown", "scale = -3", "-3", "crown.scale is -3"),
        ("crown", "scale_v = 13", "13", "wanted less than 13"),
        ("crown", "scale = \"tall\"", "\"tall\"", "expected"),
        (
            "crown",
            "shape = \"square\"",
            "\"square\"",
            "unknown variant `square`",
        ),
        ("crown", "levels = 2.5", "2.5", "expected"),
        ("crown", "heigth = 3", "heigth", "unknown field `heigth`"),
        ("stems", "length = [1, 2, 3]", "[1, 2, 3]", "length 3"),
        ("stems", "curve = [0, 0, nan, 0]", "nan", "stems.curve"),
        (
            "wood",
            "tube_edges = [12, 2, 0, 0]",
            "2, 0",
            "0 or at least 3",
        ),
        ("wood", "bark_color = \"brown\"", "\"brown\"", "#rrggbb"),
        ("wood", "bark_color = \"#+12345\"", "\"#+12345\"", "#rrggbb"),
        (
            "leaves",
            "omit = [3, 3]",
            "3]",
            "3 after 3, wanted ascending",
        ),
        ("leaves", "omit = [-1]", "-1", "wanted 0..=3999999"),
        ("foliage", "length = 0", "0\n", "wanted 0.001..=5"),
        ("foliage", "faces = 7", "7\n", "wanted an even number"),
        ("foliage", "faces = 66", "66", "wanted 2..=64"),
        (
            "foliage",
            "fold = 10",
            "10\n",
            "wanted foliage.faces of at least 4",
        ),
        ("foliage", "faces = 4\nfold = 90", "90", "wanted -80..=80"),
        (
            "foliage",
            "faces = 2\nneedle_diameter = 0.002",
            "0.002",
            "wanted no faces",
        ),
        (
            "",
            "leaf_count = 10000000000",
            "10000000000",
            "wanted 1..=4000000",
        ),
        ("", "leaf_count = 0", "0\n", "wanted 1..=4000000"),
        (
            "",
            "leaf_count = 99999999999999999999",
            "99999999999999999999",
            "",
        ),
        (
            "",
            "leaf_count = 5\nstop_leaves = 6",
            "6",
            "at most leaf_count = 5",
        ),
    ];
    for (section, line, mark, message) in cases {
        let text = with(section, line);
        let error = parse(&text).expect_err(line);
        let start = text.find(line).expect("the line is in the text");
        let offset = start + text[start..].find(mark).expect("the mark is in the line");
        let place = crate::document::line_and_column(&text, offset);
        assert_eq!((error.line, error.column), place, "{error}");
        assert!(error.message.contains(message), "{error}");
    }
}

#[test]
fn documents_that_are_no_species_are_refused() {
    let whole = with("", "");
    let cases = [
        (
            whole.replace("species/1", "species/2"),
            (1, 10),
            "wanted \"spinney.species/1\"",
        ),
        (whole.replace("\"x\"", "\" \""), (2, 8), "name is empty"),
        (
            whole.replace("\"round\"", "\"square\""),
            (5, 14),
            "unknown variant",
        ),
        (whole.replace("schema", "scheme"), (1, 1), "unknown field"),
        (
            "foliage = []\n".to_owned() + whole.split("[[").next().expect("the head"),
            (1, 11),
            "0 tables",
        ),
        ("= 3".to_owned(), (1, 1), ""),
    ];
    for (text, place, message) in cases {
        let error = parse(&text).expect_err(&text);
        assert_eq!((error.line, error.column), place, "{error}");
        assert!(error.message.contains(message), "{error}");
    }
    let missing = parse("schema = \"spinney.species/1\"\nname = \"x\"\n").unwrap_err();
    assert!(
        missing.message.contains("missing field `foliage`"),
        "{missing}"
    );
}

/// The shipped species, and young trees.
fn shipped() -> Vec<(String, Species)> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/species");
    let mut species = Vec::new();
    for folder in [folder.clone(), folder.join("young")] {
        for entry in std::fs::read_dir(folder).expect("a folder") {
            let path = entry.expect("readable").path();
            if path.extension().is_some_and(|ending| ending == "toml") {
                let name = path.display().to_string();
                species.push((
                    name,
                    Species::read(&path).expect("shipped species are sound"),
                ));
            }
        }
    }
    species
}

#[test]
fn what_is_written_reads_back_equal() {
    let shipped = shipped();
    assert!(shipped.len() >= 20, "only {} species", shipped.len());
    for (name, species) in shipped {
        let text = species.to_toml();
        assert_eq!(parse(&text).as_ref(), Ok(&species), "{name}");
    }
    for line in [
        "needle_diameter = 0.0003",
        "faces = 10\ndroop = -7.1\nfold = 1e-3",
    ] {
        let species = parse(&with("foliage", line)).unwrap();
        assert_eq!(parse(&species.to_toml()), Ok(species));
    }
    let named = Species {
        name: "a \"quoted\" \\ name\nof two lines".to_owned(),
        latin: "Bäume".to_owned(),
        leaf_count: Some(7),
        stop_leaves: Some(3),
        trunk_polygons: Some(0),
        omitted_leaves: vec![1, 5],
        ..parse(&with("", "")).unwrap()
    };
    assert_eq!(parse(&named.to_toml()), Ok(named));
}
