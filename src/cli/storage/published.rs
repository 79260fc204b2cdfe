//! Tables I to V of the framework's paper, beside what follows from their own numbers and beside our
//! trees of the same names.

use crate::models::Kind;
use crate::report::{Cell, Column, StorageReport, Table, hundredths, is_paper_tree};
use crate::simplify::{PUBLISHED_ROWS, PublishedCell, PublishedRow, mebibyte_hundredths};

/// The paper's tables in their order, with notes; nothing where none of the trees is of the paper.
pub(super) fn published(reports: &[StorageReport], width: usize) -> String {
    let rows = || {
        PUBLISHED_ROWS
            .iter()
            .filter_map(|row| Some((row, ours(reports, row)?)))
    };
    let mut text = String::new();
    for (number, caption, kind) in TABLES {
        let of_table: Vec<_> = rows().filter(|(row, _)| row.table == number).collect();
        if of_table.is_empty() {
            continue;
        }
        let table = table(&of_table, kind).to_text(width);
        text += &format!("Table {number}: {caption}\n{table}");
        for (row, _) in of_table {
            for note in notes(row) {
                text += &note;
            }
        }
        text.push('\n');
    }
    if !text.is_empty() {
        text += NOTE;
    }
    text
}

/// What the tables are of, and the model whose true bytes stand beside.
const TABLES: [(&str, &str, Option<Kind>); 5] = [
    ("I", "the trees and their original storage cost", None),
    ("II", "VDF", Some(Kind::VdfHost)),
    ("III", "LoDF, not hardware-oriented", Some(Kind::LodfHost)),
    ("IV", "LoDF, not hardware-oriented", Some(Kind::LodfHost)),
    ("V", "LoDF, hardware-oriented", Some(Kind::LodfCluster)),
];

const NOTE: &str = "\
!: the printed cell does not follow from the others of its row. L − C: leaves less
collapses, which the groups must be. \"follows\": the size by the accounting that gives
the table's sound rows. n counts approximations in Tables II and III, collapses in
IV and V. \"ours\": our tree of that name, \"built\": the true bytes of its structures.
";

fn ours<'a>(reports: &'a [StorageReport], row: &PublishedRow) -> Option<&'a StorageReport> {
    let named = |report: &&StorageReport| is_paper_tree(&report.plant, row.tree);
    reports.iter().find(named)
}

fn table(rows: &[(&PublishedRow, &StorageReport)], kind: Option<Kind>) -> Table {
    let numbers = |headings: &[&str]| -> Vec<Column> {
        let columns = headings.iter().copied();
        columns.map(Column::numbers).collect()
    };
    let mut columns = vec![Column::words("tree")];
    columns.extend(match kind {
        None => numbers(&["vertices", "polygons", "leaves", "ours", "MB", "follows"]),
        Some(Kind::VdfHost) => numbers(&["n", "leaves", "ours", "MB", "follows", "ratio", "built"]),
        Some(_) => numbers(&[
            "n", "leaves", "groups", "L − C", "ours", "MB", "follows", "ratio", "built",
        ]),
    });
    let row = |(row, report): &(&PublishedRow, &StorageReport)| {
        let counts = &report.counts;
        let leaves = u64::from(row.leaves);
        let size = marked(hundredths(row.size), row.is_corrupt(PublishedCell::Size));
        let computed = Cell::Text(hundredths(row.computed_size()));
        let mut cells = vec![Cell::Text(row.tree.to_owned())];
        let Some(kind) = kind else {
            let [vertices, polygons] = [4 * leaves, 2 * leaves].map(Cell::Count);
            cells.extend([vertices, polygons, Cell::Count(leaves)]);
            cells.extend([Cell::Count(counts.leaves), size, computed]);
            return cells;
        };
        let count =
            |count: Option<u32>| count.map_or(Cell::Missing, |count| Cell::Count(u64::from(count)));
        cells.extend([count(row.approximations), Cell::Count(leaves)]);
        match row.groups {
            None => cells.push(Cell::Count(counts.records)),
            Some(groups) => {
                let corrupt = row.is_corrupt(PublishedCell::Groups);
                cells.push(marked(groups.to_string(), corrupt));
                cells.extend([row.computed_groups(), counts.groups].map(Cell::Count));
            }
        }
        let ratio = row.ratio.map_or(Cell::Missing, |ratio| {
            let corrupt = row.is_corrupt(PublishedCell::Ratio);
            marked(hundredths(u64::from(ratio)), corrupt)
        });
        cells.extend([size, computed, ratio, built(report, kind)]);
        cells
    };
    Table {
        columns,
        rows: rows.iter().map(row).collect(),
    }
}

/// The bytes of what is built, in MiB.
fn built(report: &StorageReport, kind: Kind) -> Cell {
    let label = kind.label();
    let found = report.models.iter().find(|entry| entry.model == label);
    found.map_or(Cell::Missing, |entry| {
        let bytes = entry.host_bytes + entry.shared_bytes + entry.instance_bytes;
        Cell::Text(hundredths(mebibyte_hundredths(bytes)))
    })
}

fn marked(text: String, corrupt: bool) -> Cell {
    let mark = if corrupt { "!" } else { "" };
    Cell::Text(text + mark)
}

/// What is known of a row's corrupt cells.
fn notes(row: &PublishedRow) -> impl Iterator<Item = String> {
    let cells = [
        (PublishedCell::Groups, "groups"),
        (PublishedCell::Size, "MB"),
        (PublishedCell::Ratio, "ratio"),
    ];
    cells.into_iter().filter_map(|(cell, name)| {
        let why = row.erratum(cell)?;
        Some(format!("{}, {name}: {why}\n", row.tree))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corrupt_cells_are_marked_and_others_are_not() {
        assert_eq!(
            marked(hundredths(150), true),
            Cell::Text("1.50!".to_owned())
        );
        assert_eq!(marked(hundredths(7), false), Cell::Text("0.07".to_owned()));
        let juniper = |row: &&PublishedRow| row.table == "IV" && row.tree == "J. Oxycedrus";
        let row = PUBLISHED_ROWS.iter().find(juniper).unwrap();
        let found: Vec<String> = notes(row).collect();
        assert_eq!(found.len(), 2);
        assert!(found[0].starts_with("J. Oxycedrus, groups: "), "{found:?}");
    }

    #[test]
    fn scenes_without_the_papers_trees_say_nothing() {
        assert_eq!(published(&[], 80), "");
    }
}
