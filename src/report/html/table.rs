//! Tables on a page. With its script they sort by a heading.

use super::text::{THIN_SPACE, escape};
use crate::report::table::{Align, Cell, Column, Table};

/// What a last row is called that holds the sums of the others: it stays below when a table is sorted.
const SUMS: &str = "all";

/// A table below its caption; wide ones scroll sideways in a box of their own.
pub(super) fn table_html(caption: &str, table: &Table) -> String {
    let mut html = "<figure class=\"table\">\n".to_owned();
    if !caption.is_empty() {
        html += &format!("<figcaption>{}</figcaption>\n", escape(caption));
    }
    html += "<div class=\"wide\"><table>\n<thead><tr>";
    for column in &table.columns {
        html += &format!(
            "<th{} scope=\"col\">{}</th>",
            class(column),
            escape(&column.heading)
        );
    }
    html += "</tr></thead>\n<tbody>\n";
    let (rows, sums) = match table.rows.split_last() {
        Some((last, rows)) if last.first() == Some(&Cell::Text(SUMS.to_owned())) => {
            (rows, Some(last))
        }
        _ => (&table.rows[..], None),
    };
    rows.iter().for_each(|row| html += &row_html(table, row));
    html += "</tbody>\n";
    if let Some(sums) = sums {
        html += &format!("<tfoot>\n{}</tfoot>\n", row_html(table, sums));
    }
    html + "</table></div>\n</figure>\n"
}

fn row_html(table: &Table, row: &[Cell]) -> String {
    let cell = |(index, column): (usize, &Column)| {
        let cell = row.get(index).unwrap_or(&Cell::Missing).shown(THIN_SPACE);
        format!("<td{}>{}</td>", class(column), escape(&cell))
    };
    let cells: String = table.columns.iter().enumerate().map(cell).collect();
    format!("<tr>{cells}</tr>\n")
}

fn class(column: &Column) -> &'static str {
    match column.align {
        Align::Left => "",
        Align::Right => " class=\"n\"",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stand_at_the_right_in_groups() {
        let table = Table {
            columns: vec![Column::words("a"), Column::numbers("b")],
            rows: vec![vec![Cell::Text("x".to_owned()), Cell::Count(1_234_567)]],
        };
        let html = table_html("", &table);
        assert!(
            html.contains("<th scope=\"col\">a</th><th class=\"n\" scope=\"col\">b</th>"),
            "{html}"
        );
        assert!(
            html.contains("<td>x</td><td class=\"n\">1\u{202f}234\u{202f}567</td>"),
            "{html}"
        );
    }

    #[test]
    fn sums_stand_apart_from_what_is_sorted() {
        let row = |name: &str, count| vec![Cell::Text(name.to_owned()), Cell::Count(count)];
        let table = |last: &str| Table {
            columns: vec![Column::words("a"), Column::numbers("b")],
            rows: vec![row("x", 1), row("y", 2), row(last, 3)],
        };
        let html = table_html("Some <things>", &table("all"));
        let foot = "</tbody>\n<tfoot>\n<tr><td>all</td><td class=\"n\">3</td></tr>\n</tfoot>";
        assert!(
            html.contains(foot) && html.matches("<tr>").count() == 4,
            "{html}"
        );
        assert!(
            html.contains("<figcaption>Some &lt;things&gt;</figcaption>"),
            "{html}"
        );
        assert!(!table_html("", &table("z")).contains("<tfoot>"));
    }
}
