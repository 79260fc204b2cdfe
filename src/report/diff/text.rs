//! What was found, in words for a terminal.

use super::{
    ChannelDifferences, FieldDifference, FileDifference, FileState, FrameDifference,
    ImageDifference, LookDifference, Metrics, RunDifference, SizeMismatch,
};
use crate::report::{Cell, Column, SampleKind, Table, decimal, grouped};

/// Rows of a table before the rest is only counted.
const MOST_ROWS: usize = 24;

/// A label and what is said under it.
pub(super) type Fact = (&'static str, String);

impl ImageDifference {
    /// What was found, for a terminal of so many columns.
    #[must_use]
    pub fn to_text(&self, width: usize) -> String {
        let mut text = String::new();
        if let Some(channels) = &self.channels {
            text += &channel_table(channels).to_text(width);
            for note in channel_notes(channels) {
                text += &format!("{note}\n");
            }
            if self.look.is_some() {
                text += "\nAs colours of 8 bits\n";
            }
        }
        if let Some(look) = &self.look {
            text += &lines(&look_facts(look));
        }
        text
    }
}

impl RunDifference {
    /// What was found, for a terminal of so many columns.
    #[must_use]
    pub fn to_text(&self, width: usize) -> String {
        let mut text = String::new();
        for sentence in self.sentences() {
            text += &format!("{sentence}\n");
        }
        for (heading, table) in self.tables() {
            text += &format!("\n{heading}\n{}", table.to_text(width));
        }
        for file in self.files.iter().filter(|file| !file.detail.is_empty()) {
            text += &format!("\n{}\n", file.name);
            for line in &file.detail {
                text += &format!("  {line}\n");
            }
        }
        text
    }

    /// How many of what differ.
    pub(super) fn sentences(&self) -> Vec<String> {
        let pictures = self.frames.iter().filter(|frame| frame.look.is_some());
        let beyond = self.frames.iter().filter(|frame| !frame.looks_same());
        let ledgers = self.frames.iter().filter(|frame| !frame.ledger.is_empty());
        let (unequal, beyond) = (pictures.count(), beyond.count());
        let within = match unequal - beyond {
            0 => String::new(),
            within => format!(", {within} of them within the tolerance"),
        };
        let mut sentences = vec![
            format!("{} frames compared", grouped(self.compared as u64, ",")),
            format!("pictures of {unequal} frames differ{within}"),
            format!("ledgers of {} frames differ", ledgers.count()),
            format!(
                "other files: {} equal, {} not",
                self.equal_files,
                self.files.len()
            ),
        ];
        for (frames, which) in [
            (&self.only_expected, "first"),
            (&self.only_actual, "second"),
        ] {
            if !frames.is_empty() {
                sentences.push(format!("only in the {which}: frames {}", ranges(frames)));
            }
        }
        sentences
    }

    /// Everything that differs, with its heading.
    pub(super) fn tables(&self) -> Vec<(String, Table)> {
        let files = &self.files;
        let all = [
            ("What was run", value_table(&self.head)),
            ("Pictures", picture_table(&self.frames)),
            ("Ledgers, sums of all frames", count_table(&self.totals)),
            ("Before the first frame", count_table(&self.initial)),
            ("Ledgers, frame by frame", frame_table(&self.frames)),
            ("Other files", file_table(files)),
        ];
        let some = all.into_iter().filter(|(_, table)| !table.rows.is_empty());
        some.map(|(heading, table)| shortened(heading, table))
            .collect()
    }
}

/// The first rows, and how many there are under the heading.
fn shortened(heading: &str, mut table: Table) -> (String, Table) {
    let count = table.rows.len();
    if count <= MOST_ROWS {
        return (heading.to_owned(), table);
    }
    table.rows.truncate(MOST_ROWS);
    let heading = format!("{heading} (the first {MOST_ROWS} of {count} rows)");
    (heading, table)
}

/// Numbers in ascending order as `0, 4..=9`.
fn ranges(numbers: &[u32]) -> String {
    let runs = numbers.chunk_by(|one, next| one + 1 == *next);
    let words = runs.map(|run| match run {
        [first, .., last] => format!("{first}..={last}"),
        single => single.iter().map(u32::to_string).collect(),
    });
    words.collect::<Vec<_>>().join(", ")
}

fn lines(facts: &[Fact]) -> String {
    let line = |(label, words): &Fact| format!("{label:<11}{words}\n");
    facts.iter().map(line).collect()
}

/// What two pictures have to say.
pub(super) fn look_facts(look: &LookDifference) -> Vec<Fact> {
    match &look.found {
        Ok(metrics) => metric_facts(metrics),
        Err(sizes) => vec![("size", sizes.to_string())],
    }
}

fn metric_facts(metrics: &Metrics) -> Vec<Fact> {
    let found = &metrics.difference;
    let [width, height] = found.size;
    let total = grouped(found.total(), ",");
    let mut facts = vec![("size", format!("{width} × {height} pixels"))];
    if found.unequal == 0 {
        facts.push(("pixels", format!("all {total} are equal")));
        return facts;
    }
    let count = |pixels: u64| {
        let share = decimal(100.0 * pixels as f64 / found.total() as f64, 2);
        format!("{} of {total} pixels ({share} %)", grouped(pixels, ","))
    };
    facts.push(("unequal", count(found.unequal)));
    if found.tolerance > 0 {
        let beyond = format!(
            "{}, by more than {} of 255",
            count(found.pixels),
            found.tolerance
        );
        facts.push(("differing", beyond));
    }
    let [x, y] = found.largest_at;
    facts.push(("largest", format!("{} of 255 at ({x}, {y})", found.largest)));
    if let Some([left, top, right, bottom]) = found.bounds {
        facts.push(("where", format!("x {left}..={right}, y {top}..={bottom}")));
    }
    let ssim = match metrics.ssim {
        Some(ssim) => decimal(ssim, 6),
        None => "– (smaller than its window of 11 × 11 pixels)".to_owned(),
    };
    let [x, y] = metrics.flip.largest_at;
    let flip = &metrics.flip;
    facts.extend([
        (
            "mean",
            format!("{} of 255 a channel", significant(found.mean)),
        ),
        (
            "PSNR",
            format!(
                "{} dB, mean square {}",
                decimal(found.psnr(), 3),
                significant(found.mean_square)
            ),
        ),
        ("SSIM", ssim),
        (
            "FLIP",
            format!(
                "{} in the mean, {} at ({x}, {y})",
                decimal(flip.mean, 6),
                decimal(flip.largest, 6)
            ),
        ),
    ]);
    facts
}

/// At least four digits that say something.
fn significant(value: f64) -> String {
    match value {
        _ if value == 0.0 || value >= 0.1 => decimal(value, 4),
        _ if value >= 0.0001 => decimal(value, 8),
        _ => format!("{value:.3e}"),
    }
}

/// One row a channel.
pub(super) fn channel_table(channels: &ChannelDifferences) -> Table {
    let rows = channels.both.iter().map(|channel| {
        let [one, other] = channel.kinds.map(SampleKind::name);
        let kind = match one == other {
            true => one.to_owned(),
            false => format!("{one}, {other}"),
        };
        let place = match channel.largest_at {
            Some([x, y]) => Cell::Text(format!("({x}, {y})")),
            None => Cell::Missing,
        };
        let largest = match channel.largest > 0.0 {
            true => Cell::Text(super::channels::short(channel.largest)),
            false => Cell::Count(0),
        };
        let counted = match channel.windows[0] == channel.windows[1] {
            true => [
                Cell::Count(channel.differing),
                Cell::Count(channel.bits_only),
                largest,
                place,
            ],
            false => [const { Cell::Missing }; 4],
        };
        let named = [Cell::Text(channel.name.clone()), Cell::Text(kind)];
        named.into_iter().chain(counted).collect()
    });
    Table {
        columns: vec![
            Column::words("channel"),
            Column::words("samples"),
            Column::numbers("differing"),
            Column::numbers("only bits"),
            Column::numbers("largest"),
            Column::numbers("at"),
        ],
        rows: rows.collect(),
    }
}

/// What the table does not say of channels.
pub(super) fn channel_notes(channels: &ChannelDifferences) -> Vec<String> {
    let mut notes = Vec::new();
    for channel in &channels.both {
        if channel.windows[0] != channel.windows[1] {
            notes.push(format!("{}: {channel}", channel.name));
        } else if channel.not_finite > 0 {
            let count = grouped(channel.not_finite, ",");
            notes.push(format!(
                "{}: {count} of the differing are no finite numbers",
                channel.name
            ));
        }
    }
    for (names, which) in [
        (&channels.only_expected, "first"),
        (&channels.only_actual, "second"),
    ] {
        if !names.is_empty() {
            notes.push(format!("only in the {which}: {}", names.join(", ")));
        }
    }
    notes
}

/// Frames whose pictures differ.
fn picture_table(frames: &[FrameDifference]) -> Table {
    let row = |frame: &FrameDifference| {
        let mut cells = vec![Cell::Count(u64::from(frame.frame))];
        cells.extend(look_cells(frame.look.as_ref()?));
        Some(cells)
    };
    let numbers = ["pixels", "by", "at", "PSNR, dB", "SSIM", "FLIP"];
    let headings = ["frame"].into_iter().chain(numbers);
    Table {
        columns: headings.map(Column::numbers).collect(),
        rows: frames.iter().filter_map(row).collect(),
    }
}

fn look_cells(look: &Result<Metrics, SizeMismatch>) -> Vec<Cell> {
    let metrics = match look {
        Ok(metrics) => metrics,
        Err(sizes) => {
            let [one, other] = [sizes.expected, sizes.actual];
            let words = format!("{}×{}, {}×{}", one[0], one[1], other[0], other[1]);
            return vec![Cell::Missing, Cell::Missing, Cell::Text(words)];
        }
    };
    let found = &metrics.difference;
    let [x, y] = found.largest_at;
    let number = |value, digits| Cell::Number { value, digits };
    vec![
        Cell::Count(found.unequal),
        Cell::Count(u64::from(found.largest)),
        Cell::Text(format!("({x}, {y})")),
        number(found.psnr(), 2),
        metrics.ssim.map_or(Cell::Missing, |ssim| number(ssim, 6)),
        number(metrics.flip.mean, 6),
    ]
}

/// Fields that count.
fn count_table(fields: &[FieldDifference]) -> Table {
    Table {
        columns: vec![
            Column::words("field"),
            Column::numbers("first"),
            Column::numbers("second"),
            Column::numbers("change"),
        ],
        rows: fields.iter().map(count_row).collect(),
    }
}

fn count_row(field: &FieldDifference) -> Vec<Cell> {
    let cell = |value: &Option<serde_json::Value>| match value {
        None => Cell::Missing,
        Some(value) => match (value.as_u64(), value.as_str()) {
            (Some(count), _) => Cell::Count(count),
            (None, Some(text)) => Cell::Text(text.chars().take(12).collect()),
            (None, None) => Cell::Text(value.to_string()),
        },
    };
    let change = match field.change() {
        None => Cell::Missing,
        Some(change) => {
            let sign = if change < 0 { "−" } else { "+" };
            let size = u64::try_from(change.unsigned_abs()).unwrap_or(u64::MAX);
            Cell::Text(format!("{sign}{}", grouped(size, ",")))
        }
    };
    let name = Cell::Text(field.name.clone());
    vec![name, cell(&field.expected), cell(&field.actual), change]
}

/// Fields that name.
fn value_table(fields: &[FieldDifference]) -> Table {
    let cell = |value: &Option<serde_json::Value>| match value {
        None => Cell::Missing,
        Some(serde_json::Value::String(text)) => Cell::Text(text.clone()),
        Some(value) => Cell::Text(value.to_string()),
    };
    let row = |field: &FieldDifference| {
        let name = Cell::Text(field.name.clone());
        vec![name, cell(&field.expected), cell(&field.actual)]
    };
    Table {
        columns: ["field", "first", "second"].map(Column::words).into(),
        rows: fields.iter().map(row).collect(),
    }
}

/// All fields of all frames.
fn frame_table(frames: &[FrameDifference]) -> Table {
    let row = |frame: u32, field: &FieldDifference| {
        let mut row = vec![Cell::Count(u64::from(frame))];
        row.extend(count_row(field));
        row
    };
    let rows = frames.iter().flat_map(|frame| {
        let fields = frame.ledger.iter();
        fields.map(|field| row(frame.frame, field))
    });
    let mut table = count_table(&[]);
    table.columns.insert(0, Column::numbers("frame"));
    table.rows = rows.collect();
    table
}

fn file_table(files: &[FileDifference]) -> Table {
    let row = |file: &FileDifference| {
        let state = match file.state {
            FileState::Differs => "differs",
            FileState::OnlyExpected => "only in the first",
            FileState::OnlyActual => "only in the second",
        };
        [file.name.as_str(), state]
            .map(|words| Cell::Text(words.to_owned()))
            .into()
    };
    Table {
        columns: ["file", "how"].map(Column::words).into(),
        rows: files.iter().map(row).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{example, variant};
    use super::*;
    use crate::report::ImageFile;

    #[test]
    fn every_measure_is_told_in_lines_that_fit() {
        let [one, other] = [example(), variant("spots")].map(ImageFile::Picture);
        let found = ImageDifference::between(&one, &other, 3).unwrap();
        let text = found.to_text(80);
        let wanted = "\
size       64 × 80 pixels
unequal    52 of 5,120 pixels (1.02 %)
differing  52 of 5,120 pixels (1.02 %), by more than 3 of 255
largest    215 of 255 at (0, 0)
where      x 0..=63, y 0..=78
mean       1.3339 of 255 a channel
PSNR       25.086 dB, mean square 201.6102
SSIM       0.896159
FLIP       0.043435 in the mean, 0.964382 at (0, 0)
";
        assert_eq!(text, wanted);
        assert!(text.lines().all(|line| line.chars().count() <= 80));
        let same = ImageDifference::between(&one, &one, 0).unwrap();
        assert!(same.is_within());
        let wanted = "size       64 × 80 pixels\npixels     all 5,120 are equal\n";
        assert_eq!(same.to_text(80), wanted);
    }

    #[test]
    fn numbers_stand_in_ranges() {
        assert_eq!(ranges(&[0, 4, 5, 6, 9]), "0, 4..=6, 9");
        assert_eq!(ranges(&[7, 8]), "7..=8");
    }

    #[test]
    fn long_tables_end_with_a_count() {
        let table = Table {
            columns: vec![Column::words("a")],
            rows: vec![vec![]; 30],
        };
        let (heading, table) = shortened("All", table);
        assert_eq!(heading, "All (the first 24 of 30 rows)");
        assert_eq!(table.rows.len(), 24);
    }
}
