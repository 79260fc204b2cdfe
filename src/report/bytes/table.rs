//! The tables of bytes, for people.

use super::ByteReport;
use super::entries::{Entry, Group, bases, entries, together};
use super::sums::{Verdict, ticks};
use crate::gpu::{Link, Ticks};
use crate::report::run::microseconds;
use crate::report::{Cell, Column, Table, grouped};

/// What the columns mean.
const CAPTION: &str = "First: everything that is sent before step 0. Resident: device memory \
     in use then, but for what is drawn into. A walk: all changes of detail and the frame after each, with \
     the frame of step 0, which changes nothing; a change: the mean of the others. Payload is what \
     changes upload, without the view; fetched is what draws pull from host memory, again each frame; \
     commands are counted, not timed. Times are modelled, uploads and fetches on the bus.";

/// What the comparisons mean.
const COMPARED: &str = "Better: fewer bytes down the bus, uploaded, fetched and commands \
     together, and less time. Unbeaten: no other model with levels is at least as good in all of bytes, \
     time, vertices and device memory, and better in one.";

/// What mode `device` is sent.
const DICTATED: &str = "Mode device is told here how far to go, 4 B a change; where it follows the camera by \
     itself, it is sent the camera, 24 B a frame, and nothing else.";

/// What the tables mean.
pub(super) fn notes(report: &ByteReport) -> Vec<&'static str> {
    let mut models = report.plants.iter().flat_map(|plant| &plant.models);
    let mut notes = vec![CAPTION, COMPARED];
    if models.any(|model| model.variant.kind.selects()) {
        notes.push(DICTATED);
    }
    notes
}

/// What a group's table is of.
pub(super) fn heading(group: Group) -> &'static str {
    match group {
        Group::Foliage => "Models of foliage",
        Group::Trunks => "Models of trunks, the foliage at full detail",
    }
}

/// A row a model of one plant.
pub(super) fn plant_table(report: &ByteReport, plant: usize, group: Group) -> Table {
    table(
        report,
        group,
        &entries(report, &report.plants[plant], group),
    )
}

/// A row a model of all plants together.
pub(super) fn together_table(report: &ByteReport, group: Group) -> Table {
    table(report, group, &together(report, group))
}

fn table(report: &ByteReport, group: Group, entries: &[Entry]) -> Table {
    let links: Vec<String> = report.links.iter().map(|link| title(*link)).collect();
    let bases = bases(report, group);
    let mut columns = vec![Column::words("model")];
    let mut numbers = |headings: &[String]| {
        columns.extend(headings.iter().map(Column::numbers));
    };
    let of_links = |unit: &str| -> Vec<String> {
        let heading = |link: &String| format!("{link}, {unit}");
        links.iter().map(heading).collect()
    };
    numbers(&["first, B", "resident, B", "payload, B", "transfers"].map(str::to_owned));
    numbers(&["commands, B", "fetched, B", "vertices"].map(str::to_owned));
    numbers(&of_links("ms"));
    numbers(&["a change, B", "transfers", "commands, B", "fetched, B"].map(str::to_owned));
    numbers(&of_links("µs"));
    // At the right as what they judge, where pages do not break them.
    let of_bases = |base: &&str| -> Vec<Column> {
        let heading = |link: &String| Column::numbers(format!("{link}: than {base}"));
        links.iter().map(heading).collect()
    };
    columns.extend(bases.iter().flat_map(of_bases));
    let heading = |link: &String| Column::numbers(format!("{link}: unbeaten"));
    columns.extend(links.iter().map(heading));
    Table {
        columns,
        rows: entries.iter().map(|entry| cells(report, entry)).collect(),
    }
}

fn cells(report: &ByteReport, entry: &Entry) -> Vec<Cell> {
    let sums = &entry.sums;
    let links = 0..report.links.len();
    // Payload and transfers are the same on every link.
    let (walk, changes) = (sums.walk.on(0), sums.changes.on(0));
    let first = sums.initial.first().map_or(0, |first| first.payload_bytes);
    let mut cells = vec![Cell::Text(entry.variant.label())];
    cells.extend(
        [
            first,
            sums.resident_bytes,
            walk.upload.payload_bytes,
            walk.upload.transfers,
            sums.walk.command_bytes,
            walk.fetch.payload_bytes,
            sums.walk.vertices,
        ]
        .map(Cell::Count),
    );
    let number = |value, digits| Cell::Number { value, digits };
    let milliseconds = |ticks: Ticks| microseconds(ticks) / 1000.0;
    cells.extend(
        links
            .clone()
            .map(|link| number(milliseconds(ticks(&sums.walk.on(link))), 3)),
    );
    let mean = |sum: f64| sum / sums.change_count.max(1) as f64;
    // Bytes to the nearest; there may be less than one transfer in a change.
    let whole = |sum: u64| {
        let count = sums.change_count.max(1);
        Cell::Count((sum + count / 2) / count)
    };
    cells.extend([
        whole(changes.upload.payload_bytes),
        number(mean(changes.upload.transfers as f64), 1),
        whole(sums.changes.command_bytes),
        whole(changes.fetch.payload_bytes),
    ]);
    cells.extend(links.map(|link| number(mean(microseconds(ticks(&sums.changes.on(link)))), 2)));
    let verdicts = entry.against.iter().flatten();
    cells.extend(verdicts.map(|verdicts| verdict_cell(verdicts)));
    let unbeaten = entry.unbeaten.iter();
    cells.extend(unbeaten.map(|count| match (count, entry.plants) {
        (None, _) => Cell::Missing,
        (Some(0), 1) => Cell::Text("no".to_owned()),
        (Some(_), 1) => Cell::Text("unbeaten".to_owned()),
        (Some(count), plants) => Cell::Text(format!("{count} of {plants}")),
    }));
    cells
}

/// The verdict, or how many of each there are.
fn verdict_cell(verdicts: &[Verdict]) -> Cell {
    let mut counts: Vec<(Verdict, usize)> = Vec::new();
    for verdict in verdicts {
        match counts.iter_mut().find(|(known, _)| known == verdict) {
            Some((_, count)) => *count += 1,
            None => counts.push((*verdict, 1)),
        }
    }
    match counts[..] {
        [] => Cell::Missing,
        [(verdict, _)] => Cell::Text(verdict.words().to_owned()),
        _ => {
            let words = counts.iter();
            let words = words.map(|(verdict, count)| format!("{count} {}", verdict.words()));
            Cell::Text(words.collect::<Vec<String>>().join(", "))
        }
    }
}

/// A link's name for people: `AGP 8x`, `PCIe 5`.
pub(super) fn title(link: Link) -> String {
    let name = link.name();
    match (name.strip_prefix("agp"), name.strip_prefix("pcie")) {
        (Some(speed), _) => format!("AGP {speed}"),
        (_, Some(lanes)) => format!("PCIe {}", lanes.trim_end_matches("x16")),
        _ => name.to_owned(),
    }
}

/// The groups that were walked.
pub(super) fn groups(report: &ByteReport) -> impl Iterator<Item = Group> + '_ {
    let walked = |group: &Group| !together(report, *group).is_empty();
    Group::ALL.into_iter().filter(walked)
}

/// A plant with its sizes, for headings.
pub(super) fn plant_heading(report: &ByteReport, plant: usize) -> String {
    let plant = &report.plants[plant];
    let [leaves, clusters] = [plant.leaves, plant.clusters].map(|count| grouped(count, ","));
    format!("{}: {leaves} leaves, {clusters} clusters", plant.name)
}

/// What the tables of all plants stand below.
pub(super) fn together_heading(report: &ByteReport) -> String {
    match report.plants.len() {
        1 => plant_heading(report, 0),
        plants => format!("All {plants} plants together"),
    }
}

/// What of a table stands in a terminal: all of a walk, and how models compare with the first base.
fn short(report: &ByteReport, group: Group) -> Table {
    let table = together_table(report, group);
    let links = report.links.len();
    let bases = bases(report, group).len();
    // Model to vertices, the times, then behind what a change takes the verdicts.
    let changes = 8 + links;
    let verdicts = changes + 4 + links;
    let unbeaten = verdicts + bases * links;
    let kept = (0..changes)
        .chain(verdicts..verdicts + links * bases.min(1))
        .chain(unbeaten..unbeaten + links);
    let kept: Vec<usize> = kept.collect();
    let pick = |row: &Vec<Cell>| kept.iter().map(|&index| row[index].clone()).collect();
    Table {
        columns: kept
            .iter()
            .map(|&index| table.columns[index].clone())
            .collect(),
        rows: table.rows.iter().map(pick).collect(),
    }
}

/// The tables of all plants together for a terminal of so many columns, and what they say.
#[must_use]
pub fn bytes_text(report: &ByteReport, width: usize) -> String {
    let mut texts = vec![format!(
        "{}, {} changes from full detail to the coarsest\n",
        together_heading(report),
        report.steps
    )];
    for group in groups(report) {
        let parts = short(report, group).to_parts(width);
        texts.push(format!("{}\n{}", heading(group), parts.join("\n")));
    }
    texts.extend(notes(report).iter().map(|note| format!("{note}\n")));
    texts.join("\n")
}

/// All tables in Markdown.
#[must_use]
pub fn bytes_markdown(report: &ByteReport) -> String {
    let mut text = format!("## {}\n", together_heading(report));
    let section =
        |group: Group, table: &Table| format!("\n{}\n\n{}", heading(group), table.to_markdown());
    for group in groups(report) {
        text += &section(group, &together_table(report, group));
    }
    for note in notes(report) {
        text += &format!("\n{note}\n");
    }
    if report.plants.len() > 1 {
        for plant in 0..report.plants.len() {
            text += &format!("\n## {}\n", plant_heading(report, plant));
            for group in groups(report) {
                text += &section(group, &plant_table(report, plant, group));
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::Traffic;
    use crate::report::{bytes_csv, bytes_page};
    use crate::run::{ModelBytes, PlantBytes, StepBytes, StepTraffic, Variant};

    /// A tick is 1/4096 ns.
    const MICROSECOND: Ticks = 4_096_000;

    /// Two steps; of the second so many bytes are uploaded, in so many microseconds on both links.
    fn model(label: &str, bytes: u64, times: [Ticks; 2]) -> ModelBytes {
        let step = |bytes: u64, ticks: [Ticks; 2]| StepBytes {
            leaves: 9,
            traffic: ticks
                .map(|ticks| StepTraffic {
                    upload: Traffic {
                        transfers: u64::from(bytes > 0),
                        payload_bytes: bytes,
                        wire_bytes: bytes,
                        ticks,
                    },
                    fetch: Traffic::default(),
                })
                .to_vec(),
            command_bytes: 50,
            vertices: 36,
        };
        ModelBytes {
            variant: Variant::labelled(label).expect("a label"),
            resident_bytes: 1000,
            initial: vec![Traffic::default(); 2],
            steps: vec![
                step(0, [0; 2]),
                step(bytes, times.map(|time| MICROSECOND * time)),
            ],
        }
    }

    fn plant(name: &str, stamps: [Ticks; 2]) -> PlantBytes {
        PlantBytes {
            name: name.to_owned(),
            leaves: 12,
            clusters: 3,
            models: vec![
                model("full", 0, [0, 0]),
                model("lodf-cluster", 160, [2, 2]),
                model("lodf-stamps", 4, stamps),
                model("full+mom-device", 7, [1, 1]),
            ],
        }
    }

    fn report() -> ByteReport {
        ByteReport {
            scene: "two".to_owned(),
            steps: 1,
            links: ["agp8x", "pcie3x16"]
                .map(|name| Link::named(name).expect("a link"))
                .to_vec(),
            plants: vec![plant("fir", [1, 2]), plant("elm", [1, 1])],
            resolved: String::new(),
        }
    }

    fn row(table: &Table, label: &str) -> String {
        let text = table.to_markdown();
        let line = text
            .lines()
            .find(|line| line.starts_with(&format!("| {label} |")));
        line.expect("a row").to_owned()
    }

    #[test]
    fn tables_say_what_is_better_on_which_link() {
        let report = report();
        let fir = plant_table(&report, 0, Group::Foliage);
        let headings: Vec<&str> = fir
            .columns
            .iter()
            .map(|column| &column.heading[..])
            .collect();
        assert_eq!(headings[8..10], ["AGP 8x, ms", "PCIe 3, ms"]);
        assert_eq!(
            headings[16..18],
            ["AGP 8x: than lodf-cluster", "PCIe 3: than lodf-cluster"]
        );
        assert_eq!(
            row(&fir, "lodf-stamps"),
            "| lodf-stamps | 0 | 1,000 | 4 | 1 | 100 | 0 | 72 | 0.001 | 0.002 | 4 | 1.0 | 50 | 0 | 1.00 | 2.00 \
             | better | only fewer bytes | unbeaten | unbeaten |"
        );
        let beaten = row(&fir, "lodf-cluster");
        assert!(beaten.ends_with("| – | – | no | no |"), "{beaten}");
        // What has no levels is no rival.
        let full = row(&fir, "full");
        assert!(full.ends_with("| – | – | – | – |"), "{full}");
        let both = together_table(&report, Group::Foliage);
        let stamps = row(&both, "lodf-stamps");
        let wanted = "| better | 1 only fewer bytes, 1 better | 2 of 2 | 2 of 2 |";
        assert!(stamps.ends_with(wanted), "{stamps}");
        // Trunks stand apart.
        let trunks = together_table(&report, Group::Trunks);
        assert_eq!(trunks.rows.len(), 1);
    }

    #[test]
    fn terminals_get_the_walk_and_the_first_verdict() {
        let text = bytes_text(&report(), 400);
        let line = text.lines().find(|line| line.starts_with("lodf-stamps"));
        let words: Vec<&str> = line.expect("a row").split("  ").map(str::trim).collect();
        let words: Vec<&str> = words.into_iter().filter(|word| !word.is_empty()).collect();
        let wanted = [
            "lodf-stamps",
            "0",
            "2,000",
            "8",
            "2",
            "200",
            "0",
            "144",
            "0.002",
            "0.003",
            "better",
            "1 only fewer bytes, 1 better",
            "2 of 2",
            "2 of 2",
        ];
        assert_eq!(words, wanted);
        assert!(bytes_text(&report(), 40).lines().count() > 40);
    }

    #[test]
    fn files_name_every_plant_model_and_link() {
        let report = report();
        let csv = bytes_csv(&report);
        assert_eq!(csv.lines().count(), 1 + 2 * 4 * 2);
        let fields = |line: &str| line.split(',').count();
        let head = csv.lines().next().map(fields);
        assert!(csv.lines().all(|line| Some(fields(line)) == head), "{csv}");
        let page = bytes_page(&report).expect("it is small");
        assert_eq!(page.matches("<svg").count(), 2 + 2 * 2);
        assert!(page.contains("fir: 12 leaves, 3 clusters"));
    }
}
