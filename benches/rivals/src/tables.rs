//! What was found, as Markdown, CSV and SVG.

use std::error::Error;
use std::path::Path;

use spinney::report::{Axis, Cell, Column, Plot, QualitySummary, Scale, Series, Spread, Table};

use crate::SHARES;

/// One plant at one share by one method.
#[derive(Debug, Clone)]
pub struct Row {
    /// The plant's name.
    pub plant: String,
    /// Percent of the leaves.
    pub share: u32,
    /// Whose leaves.
    pub method: String,
    /// The best of the method's options.
    pub option: String,
    /// Triangles that are drawn.
    pub triangles: u32,
    /// Triangles that may be drawn: two a leaf.
    pub wanted: u32,
    /// The leaves' area as a share of full detail's.
    pub area: f64,
    /// The 26 views.
    pub quality: QualitySummary,
}

/// What is compared: its name, whether less is better, its value.
type Measure = (&'static str, fn(&QualitySummary) -> f64);

/// Measures of which the least wins.
const MEASURES: [Measure; 4] = [
    ("FLIP", |quality| quality.flip.mean),
    ("SSIM", |quality| 1.0 - quality.ssim.mean),
    ("silhouette", |quality| quality.silhouette.mean),
    ("covered", |quality| (quality.covered.mean - 1.0).abs()),
];

fn columns() -> Vec<Column> {
    let words = ["plant", "leaves, %", "method", "option"].map(Column::words);
    let numbers = [
        "triangles",
        "wanted",
        "area",
        "covered",
        "covered, worst",
        "silhouette",
        "silhouette, worst",
        "FLIP",
        "FLIP, worst",
        "SSIM",
        "SSIM, worst",
    ];
    words
        .into_iter()
        .chain(numbers.map(Column::numbers))
        .collect()
}

fn cells(row: &Row) -> Vec<Cell> {
    let number = |value, digits| Cell::Number { value, digits };
    let spread = |Spread { mean, worst }, digits| [number(mean, digits), number(worst, digits)];
    let quality = &row.quality;
    let mut cells = vec![
        Cell::Text(row.plant.clone()),
        Cell::Count(u64::from(row.share)),
        Cell::Text(row.method.clone()),
        Cell::Text(row.option.clone()),
        Cell::Count(u64::from(row.triangles)),
        Cell::Count(u64::from(row.wanted)),
        number(row.area, 3),
    ];
    cells.extend(spread(quality.covered, 3));
    cells.extend(spread(quality.silhouette, 3));
    cells.extend(spread(quality.flip, 4));
    cells.extend(spread(quality.ssim, 4));
    cells
}

fn table(rows: &[Row]) -> Table {
    Table {
        columns: columns(),
        rows: rows.iter().map(cells).collect(),
    }
}

/// Rows for a terminal, a line each.
pub fn lines(rows: &[Row]) -> String {
    let line = |row: &Row| {
        let quality = &row.quality;
        format!(
            "{:24} {:3} %  {:16} {:18} {:6} triangles  area {:.3}  covered {:.3} ({:.3})  \
             silhouette {:.3}  FLIP {:.4}  SSIM {:.4}\n",
            row.plant,
            row.share,
            row.method,
            row.option,
            row.triangles,
            row.area,
            quality.covered.mean,
            quality.covered.worst,
            quality.silhouette.mean,
            quality.flip.mean,
            quality.ssim.mean,
        )
    };
    rows.iter().map(line).collect()
}

/// How often each method is best of all, and how often FSA is better than each.
pub fn wins(rows: &[Row]) -> String {
    let mut text = String::new();
    let mut methods: Vec<&str> = Vec::new();
    for row in rows {
        if !methods.contains(&row.method.as_str()) {
            methods.push(&row.method);
        }
    }
    for share in SHARES {
        for (name, measure) in MEASURES {
            let of = |method: &str| {
                let rows = rows.iter().filter(move |row| row.share == share);
                let rows = rows.filter(|row| row.method == method);
                rows.map(|row| (row.plant.as_str(), measure(&row.quality)))
                    .collect::<Vec<_>>()
            };
            let own = of("FSA");
            for rival in methods.iter().filter(|method| **method != "FSA") {
                let others = of(rival);
                let loses: Vec<&str> = own
                    .iter()
                    .filter(|(plant, value)| {
                        let mut others = others.iter().filter(|(other, _)| other == plant);
                        others.any(|(_, other)| other <= value)
                    })
                    .map(|(plant, _)| *plant)
                    .collect();
                let won = own.len() - loses.len();
                let list = match loses.len() {
                    0 => String::new(),
                    _ => format!("; {rival} on {}", loses.join(", ")),
                };
                text += &format!(
                    "{share} %, {name}: FSA before {rival} on {won} of {}{list}\n",
                    own.len()
                );
            }
        }
    }
    text
}

/// The mean over all plants, a row a share and method.
fn means(rows: &[Row]) -> Table {
    let mut keys: Vec<(u32, &str)> = Vec::new();
    for row in rows {
        if !keys.contains(&(row.share, &row.method)) {
            keys.push((row.share, &row.method));
        }
    }
    keys.sort_by_key(|key| std::cmp::Reverse(key.0));
    let headings = ["plants", "area", "covered", "silhouette", "FLIP", "SSIM"];
    let row = |(share, method): (u32, &str)| {
        let fits = |row: &&Row| row.share == share && row.method == method;
        let rows: Vec<&Row> = rows.iter().filter(fits).collect();
        let mean = |value: &dyn Fn(&Row) -> f64, digits| Cell::Number {
            value: rows.iter().map(|row| value(row)).sum::<f64>() / rows.len() as f64,
            digits,
        };
        vec![
            Cell::Count(u64::from(share)),
            Cell::Text(method.to_owned()),
            Cell::Count(rows.len() as u64),
            mean(&|row| row.area, 3),
            mean(&|row| row.quality.covered.mean, 3),
            mean(&|row| row.quality.silhouette.mean, 3),
            mean(&|row| row.quality.flip.mean, 4),
            mean(&|row| row.quality.ssim.mean, 4),
        ]
    };
    let columns = [Column::numbers("leaves, %"), Column::words("method")];
    Table {
        columns: columns
            .into_iter()
            .chain(headings.map(Column::numbers))
            .collect(),
        rows: keys.into_iter().map(row).collect(),
    }
}

/// Writes `rivals.csv`, `rivals.md` and a plot a measure.
pub fn write(out: &Path, rows: &[Row]) -> Result<(), Box<dyn Error>> {
    let table = table(rows);
    std::fs::write(out.join("rivals.csv"), table.to_csv())?;
    let text = format!(
        "Means over the plants\n\n{}\nWho is before whom\n\n```text\n{}```\n\nEvery plant\n\n{}",
        means(rows).to_markdown(),
        wins(rows),
        table.to_markdown()
    );
    std::fs::write(out.join("rivals.md"), text)?;
    let plots: [Measure; 4] = [
        ("flip", |quality| quality.flip.mean),
        ("ssim", |quality| quality.ssim.mean),
        ("silhouette", |quality| quality.silhouette.mean),
        ("covered", |quality| quality.covered.mean),
    ];
    for (name, value) in plots {
        let file = out.join(format!("rivals-{name}.svg"));
        std::fs::write(file, plot(name, value, rows).to_svg())?;
    }
    Ok(())
}

/// A line a method: the mean over the plants against the share of leaves.
fn plot(name: &str, value: fn(&QualitySummary) -> f64, rows: &[Row]) -> Plot {
    let mut series: Vec<Series> = Vec::new();
    for row in rows {
        if !series.iter().any(|known| known.name == row.method) {
            let points = SHARES.iter().filter_map(|&share| {
                let fits = |other: &&Row| other.share == share && other.method == row.method;
                let values: Vec<f64> = rows
                    .iter()
                    .filter(fits)
                    .map(|row| value(&row.quality))
                    .collect();
                let mean = values.iter().sum::<f64>() / values.len() as f64;
                (!values.is_empty()).then_some([f64::from(share), mean])
            });
            series.push(Series {
                name: row.method.clone(),
                points: points.collect(),
            });
        }
    }
    Plot {
        title: format!("{name}: the mean over the plants and 26 views"),
        x: Axis {
            label: "leaves kept, %".to_owned(),
            scale: Scale::Log,
        },
        y: Axis {
            label: name.to_owned(),
            scale: Scale::Linear,
        },
        series,
    }
}
