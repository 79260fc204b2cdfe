//! What is kept of every frame when its picture is written: numbers for tables and curves.

use std::collections::BTreeMap;

use super::ledger::microseconds;
use crate::gpu::{Ledger, Link, Stream, Ticks, Traffic};
use crate::report::table::{Cell, Column, Table};
use crate::report::{decimal, grouped};
use crate::run::{Frame, Popping};

/// The cause of uploads that follow the camera and are no change of detail.
pub(in super::super) const VIEW: &str = "view";

/// Bytes of a leaf's four vertex indices: what the papers' "not hardware-oriented" models send of
/// every visible leaf where the vertices are resident ([RRCGR](crate::references)).
pub const INDEX_BYTES_PER_LEAF: u64 = 16;

/// Bytes of a leaf's indices and vertices: what draws fetch of every visible leaf where nothing is
/// resident.
pub const FETCH_BYTES_PER_LEAF: u64 = 64;

/// One frame in numbers.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FrameRow {
    /// Its number.
    pub frame: u32,
    /// Leaves drawn.
    pub leaves: u64,
    /// Triangles drawn.
    pub triangles: u64,
    /// Uploads, but for the view's: what the change of detail cost.
    pub changes: Traffic,
    /// Uploads of the view.
    pub view: Traffic,
    /// What draws pulled from host memory.
    pub fetch: Traffic,
    /// Payload of uploads by kind of cause.
    pub upload_by_cause: BTreeMap<String, u64>,
    /// Payload of fetches by kind of cause.
    pub fetch_by_cause: BTreeMap<String, u64>,
    /// Modelled time on the card, under exact counters.
    pub gpu_ticks: Option<Ticks>,
    /// With a budget of bytes: clusters, or trees that change as a whole, that it held back.
    pub deferred: Option<u64>,
    /// What a switch of detail alone shows, where somebody watched.
    pub popping: Option<Popping>,
}

impl FrameRow {
    /// The numbers of a frame.
    #[must_use]
    pub fn of(frame: &Frame) -> Self {
        let mut row = Self {
            frame: frame.frame,
            leaves: frame.leaves,
            triangles: frame.triangles,
            fetch: frame.ledger.fetch,
            upload_by_cause: upload_by_cause(&frame.ledger),
            fetch_by_cause: fetch_by_cause(&frame.ledger),
            gpu_ticks: frame.ledger.gpu_ticks,
            deferred: frame.deferred,
            popping: frame.popping,
            ..Self::default()
        };
        for transfer in &frame.ledger.transfers {
            let kind = transfer.cause.kind;
            if transfer.stream != Stream::Upload {
                continue;
            }
            let sum = match kind {
                VIEW => &mut row.view,
                _ => &mut row.changes,
            };
            sum.add(&Traffic {
                transfers: 1,
                payload_bytes: transfer.payload_bytes,
                wire_bytes: transfer.wire_bytes,
                ticks: transfer.ticks,
            });
        }
        row
    }

    /// Modelled time on the bus: uploads, then fetches.
    #[must_use]
    pub fn bus_ticks(&self) -> Ticks {
        self.changes.ticks + self.view.ticks + self.fetch.ticks
    }

    /// The sums of several frames; of the frame's number nothing.
    #[must_use]
    pub fn sum(rows: &[Self]) -> Self {
        let mut sum = Self::default();
        for row in rows {
            sum.leaves += row.leaves;
            sum.triangles += row.triangles;
            sum.changes.add(&row.changes);
            sum.view.add(&row.view);
            sum.fetch.add(&row.fetch);
            for (sum, row) in [
                (&mut sum.upload_by_cause, &row.upload_by_cause),
                (&mut sum.fetch_by_cause, &row.fetch_by_cause),
            ] {
                for (cause, bytes) in row {
                    *sum.entry(cause.clone()).or_default() += bytes;
                }
            }
            if let Some(ticks) = row.gpu_ticks {
                *sum.gpu_ticks.get_or_insert_default() += ticks;
            }
            if let Some(deferred) = row.deferred {
                *sum.deferred.get_or_insert_default() += deferred;
            }
            if let Some(popping) = &row.popping {
                sum.popping.get_or_insert_default().add(popping);
            }
        }
        sum
    }
}

/// Payload of uploads by kind of cause: what all streams have of it, which is exact also where one
/// transfer has several causes, but for what is no upload.
pub(in super::super) fn upload_by_cause(ledger: &Ledger) -> BTreeMap<String, u64> {
    let shares = ledger.by_cause.iter();
    let shares = shares.map(|(kind, share)| ((*kind).to_owned(), share.payload_bytes));
    let mut bytes: BTreeMap<String, u64> = shares.collect();
    let transfers = ledger.transfers.iter();
    for transfer in transfers.filter(|transfer| transfer.stream != Stream::Upload) {
        if let Some(bytes) = bytes.get_mut(transfer.cause.kind) {
            *bytes = bytes.saturating_sub(transfer.payload_bytes);
        }
    }
    bytes.retain(|_, bytes| *bytes > 0);
    bytes
}

/// Payload of fetches by kind of cause.
pub(in super::super) fn fetch_by_cause(ledger: &Ledger) -> BTreeMap<String, u64> {
    let mut bytes: BTreeMap<String, u64> = BTreeMap::new();
    let transfers = ledger.transfers.iter();
    for transfer in transfers.filter(|transfer| transfer.stream == Stream::Fetch) {
        *bytes.entry(transfer.cause.kind.to_owned()).or_default() += transfer.payload_bytes;
    }
    bytes.retain(|_, bytes| *bytes > 0);
    bytes
}

/// What frames cost, a row a frame and one of sums; of more than `most` frames only some, evenly
/// chosen, with the first and the last.
///
/// "Sent" are the uploads of changes of detail, transfers are theirs, and so is the bus time, with
/// that of fetches where there are any; the view's are in [`run_notes`]. Beside them stands what
/// sending the indices of all visible leaves anew in every frame would have sent (16 bytes a leaf),
/// and what fetching all from host memory would have moved (64 bytes a leaf); where draws do fetch,
/// the bytes that they fetched.
#[must_use]
pub fn run_table(rows: &[FrameRow], most: usize) -> Table {
    let sum = FrameRow::sum(rows);
    let fetches = sum.fetch.transfers > 0;
    let headings = match fetches {
        true => ["sent, B", "fetched, B", "fetches", "bus, µs", "16 B/leaf"],
        false => ["sent, B", "transfers", "bus, µs", "16 B/leaf", "64 B/leaf"],
    };
    let numbers = ["frame", "leaves"].into_iter().chain(headings);
    let mut table = Table {
        columns: numbers.map(Column::numbers).collect(),
        rows: Vec::new(),
    };
    let cells = |name: Cell, row: &FrameRow| {
        let bus = Cell::Number {
            value: microseconds(row.changes.ticks + row.fetch.ticks),
            digits: 1,
        };
        let mut cells = vec![
            name,
            Cell::Count(row.leaves),
            Cell::Count(row.changes.payload_bytes),
        ];
        let indices = Cell::Count(INDEX_BYTES_PER_LEAF * row.leaves);
        match fetches {
            true => cells.extend([
                Cell::Count(row.fetch.payload_bytes),
                Cell::Count(row.fetch.transfers),
                bus,
                indices,
            ]),
            false => cells.extend([
                Cell::Count(row.changes.transfers),
                bus,
                indices,
                Cell::Count(FETCH_BYTES_PER_LEAF * row.leaves),
            ]),
        }
        cells
    };
    for index in evenly(rows.len(), most) {
        let row = &rows[index];
        table
            .rows
            .push(cells(Cell::Count(u64::from(row.frame)), row));
    }
    if rows.len() > 1 {
        table.rows.push(cells(Cell::Text("all".to_owned()), &sum));
    }
    table
}

/// What the sums say, as sentences: bytes, transfers and modelled times together, since many small
/// transfers can lose to a large one. What others would move is taken as one transfer a frame.
#[must_use]
pub fn run_notes(rows: &[FrameRow], link: Link) -> Vec<String> {
    let sum = FrameRow::sum(rows);
    let mut notes = vec![
        note("Changes of detail", &sum.changes),
        note("The view, apart", &sum.view),
    ];
    if let Some(deferred) = sum.deferred {
        let frames = rows.iter().filter(|row| row.deferred > Some(0)).count();
        notes.push(format!(
            "The budget of bytes held back {} changes of clusters or trees, in {frames} of {} frames.",
            grouped(deferred, ","),
            rows.len(),
        ));
    }
    if sum.fetch.transfers > 0 {
        notes.push(note("Fetched by draws", &sum.fetch));
    }
    for (what, bytes_per_leaf) in [
        (
            "Sending the indices of all visible leaves in every frame would be",
            INDEX_BYTES_PER_LEAF,
        ),
        (
            "Fetching all leaves from host memory would be",
            FETCH_BYTES_PER_LEAF,
        ),
    ] {
        let mut others = Traffic::default();
        for row in rows {
            let payload_bytes = bytes_per_leaf * row.leaves;
            others.add(&Traffic {
                transfers: 1,
                payload_bytes,
                wire_bytes: link.wire_bytes(payload_bytes),
                ticks: link.ticks_down(payload_bytes),
            });
        }
        notes.push(note(what, &others) + &times(&others, &sum.changes));
    }
    notes.extend(sum.popping.map(|popping| popping_note(rows, &popping)));
    notes
}

/// What switches of detail show, over all frames.
fn popping_note(rows: &[FrameRow], sum: &Popping) -> String {
    let popped = |row: &FrameRow| row.popping.map_or(0, |popping| popping.popped);
    let worst = rows.iter().map(|row| (popped(row), row.frame));
    // Of several the first.
    let worst = worst.max_by_key(|(popped, frame)| (*popped, std::cmp::Reverse(*frame)));
    let (most, frame) = worst.unwrap_or_default();
    let count = |pixels| grouped(pixels, ",");
    format!(
        "Popping: switches of detail alone change {} pixels, at most {} in a frame (frame {frame}). \
         {} pixels toggle between leaf and none; {} at full detail; {} beyond what toggles there.",
        count(sum.popped),
        count(most),
        count(sum.toggled),
        count(sum.toggled_at_full_detail),
        count(sum.toggled_beyond),
    )
}

/// What was moved, as a sentence.
pub(in super::super) fn note(what: &str, traffic: &Traffic) -> String {
    format!(
        "{what}: {} B in {} transfers, {} B on the wire, {} µs (modelled).",
        grouped(traffic.payload_bytes, ","),
        grouped(traffic.transfers, ","),
        grouped(traffic.wire_bytes, ","),
        decimal(microseconds(traffic.ticks), 1),
    )
}

/// How others compare with changes; nothing where changes sent nothing.
fn times(others: &Traffic, changes: &Traffic) -> String {
    if changes.payload_bytes == 0 || changes.ticks == 0 {
        return String::new();
    }
    let ratio = |one: u64, other: u64| decimal(one as f64 / other as f64, 2);
    format!(
        " That is {} times the bytes and {} times the bus time of the changes.",
        ratio(others.payload_bytes, changes.payload_bytes),
        ratio(others.ticks, changes.ticks)
    )
}

/// At most `most` of the indices below `count`, evenly spread, with the first and the last.
pub(in super::super) fn evenly(count: usize, most: usize) -> Vec<usize> {
    let kept = count.min(most.max(2));
    let index = |place: usize| place * (count - 1) / (kept - 1).max(1);
    (0..kept).map(index).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_are_spread_evenly_with_both_ends() {
        assert_eq!(evenly(0, 5), Vec::<usize>::new());
        assert_eq!(evenly(1, 5), [0]);
        assert_eq!(evenly(5, 5), [0, 1, 2, 3, 4]);
        assert_eq!(evenly(9, 5), [0, 2, 4, 6, 8]);
        assert_eq!(evenly(100, 0), [0, 99]);
    }

    /// Two frames: one sends 32 bytes of slots, one nothing.
    fn rows() -> Vec<FrameRow> {
        let traffic = |payload_bytes| Traffic {
            transfers: 1,
            payload_bytes,
            wire_bytes: payload_bytes + 24,
            ticks: 4096 * 1008,
        };
        let row = |frame, leaves, changes| FrameRow {
            frame,
            leaves,
            triangles: 2 * leaves,
            changes,
            view: traffic(100),
            ..FrameRow::default()
        };
        vec![row(0, 40, traffic(32)), row(1, 38, Traffic::default())]
    }

    #[test]
    fn rows_tell_what_was_sent_and_what_others_would_have() {
        let wanted = "\
frame  leaves  sent, B  transfers  bus, µs  16 B/leaf  64 B/leaf
─────  ──────  ───────  ─────────  ───────  ─────────  ─────────
    0      40       32          1      1.0        640      2,560
    1      38        0          0      0.0        608      2,432
  all      78       32          1      1.0      1,248      4,992
";
        assert_eq!(run_table(&rows(), 20).to_text(80), wanted);
        let link = Link::named("agp8x").unwrap();
        assert_eq!(
            run_notes(&rows(), link)[2],
            "Sending the indices of all visible leaves in every frame would be: 1,248 B in 2 \
             transfers, 1,248 B on the wire, 2.6 µs (modelled). That is 39 times the bytes and \
             2.56 times the bus time of the changes."
        );
    }
}
