//! Checking a trace, one line in memory at a time.

use std::collections::BTreeMap;
use std::io::BufRead;

use super::super::operation::Shown;
use super::super::structure::sorted;
use super::super::{History, Law, Residency, Resource, Tally, Violation, laws};
use super::format::{Header, Hex, Lines, PARTS, SCHEMA, Step, StepCounts, TracePart, Transfer};
use crate::document::DocumentError;
use crate::limits;
use crate::math::{Digest, Digester, index_usize};
use crate::models::State;

/// What a check of a trace found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TraceReport {
    /// Leaves at full detail.
    pub leaves: u32,
    /// Collapses.
    pub collapses: u32,
    /// Steps.
    pub steps: u64,
    /// Every law, in the order of [`Law::ALL`].
    pub laws: Vec<LawReport>,
    /// States that were not remembered because there were too many: if they came again, nobody
    /// noticed.
    pub forgotten: u64,
}

impl TraceReport {
    /// Whether no law was found broken.
    #[must_use]
    pub fn is_kept(&self) -> bool {
        self.laws.iter().all(|law| law.broken == 0)
    }
}

/// What a check found of one law.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LawReport {
    /// The law.
    pub law: Law,
    /// How many times it was checked; 0 when the trace records nothing to check it by.
    pub checked: u64,
    /// How many times it was broken.
    pub broken: u64,
    /// The first line where it was, and how.
    pub first: Option<(usize, Violation)>,
}

/// Checks a trace against every law that it has data for. `file` is its name, for errors.
///
/// Lines are read one at a time; memory is bounded by [`limits`].
///
/// # Errors
///
/// The first line that cannot be read, is no step of the schema, or goes past a limit. Broken laws
/// are no errors: they are in the report.
pub fn check_trace(file: &str, input: impl BufRead) -> Result<TraceReport, DocumentError> {
    let mut lines = Lines::new(file, input);
    let header: Option<Header> = lines.next()?;
    let header = header.ok_or_else(|| lines.error(1, "no header: the file is empty"))?;
    let mut checker = Checker::new(header).map_err(|message| lines.error(1, message))?;
    while let Some(step) = lines.next::<Step>()? {
        let line = lines.number;
        checker
            .step(line, step)
            .map_err(|message| lines.error(1, message))?;
    }
    if checker.steps == 0 {
        return Err(lines.error(1, "no step follows the header"));
    }
    Ok(checker.report())
}

struct Checker {
    history: History,
    header: Header,
    steps: u64,
    /// Where the trace stands, with what shows there if that is told.
    now: Option<(State, Option<Vec<u32>>)>,
    /// What showed before the last step, and its size, if that was a collapse.
    collapsed: Option<(u32, Vec<u32>)>,
    /// What the log of writes leaves in each resource.
    memory: Vec<Vec<u8>>,
    seen: BTreeMap<Digest, Seen>,
    forgotten: u64,
    tally: Tally,
    broken: BTreeMap<Law, (u64, usize, Violation)>,
}

/// What was told when a state came first.
struct Seen {
    line: usize,
    visible: Option<Digest>,
    /// Of a level, and of clusters: the same cut may be held in two ways.
    held: [Option<Digest>; 2],
    image: Option<Digest>,
}

impl Checker {
    fn new(header: Header) -> Result<Self, String> {
        if header.schema != SCHEMA {
            return Err(format!("schema {:?}, wanted {SCHEMA:?}", header.schema));
        }
        if header.leaves > limits::TRACE_LEAVES {
            let most = limits::TRACE_LEAVES;
            return Err(format!("{} leaves, at most {most} can be", header.leaves));
        }
        let has = |part| header.parts.contains(&part);
        for (number, part) in header.parts.iter().enumerate() {
            if header.parts[..number].contains(part) {
                return Err(format!("part {:?} is named twice", part.key()));
            }
        }
        if header.parts.is_empty() {
            return Err("no parts: every step would tell nothing".to_owned());
        }
        if has(TracePart::Fresh) && !(has(TracePart::Resident) && has(TracePart::Reads)) {
            return Err("part \"fresh\" needs \"resident\" and \"reads\" beside it".to_owned());
        }
        let speaks = header.parts.iter().find(|part| part.needs_resources());
        if let Some(part) = speaks.filter(|_| header.resources.is_empty()) {
            return Err(format!("part {:?} needs \"resources\"", part.key()));
        }
        let total = header
            .resources
            .iter()
            .try_fold(0_u64, |sum, resource| sum.checked_add(resource.bytes));
        if total.is_none_or(|total| total > limits::TRACE_RESOURCE_BYTES) {
            let most = limits::TRACE_RESOURCE_BYTES;
            return Err(format!("resources of more than {most} bytes together"));
        }
        let history = History::new(header.leaves, &header.collapses)
            .map_err(|error| format!("collapses: {error}"))?;
        let sizes = header.resources.iter().map(|resource| resource.bytes);
        Ok(Self {
            history,
            memory: sizes.map(|size| vec![0; index_usize(size)]).collect(),
            header,
            steps: 0,
            now: None,
            collapsed: None,
            seen: BTreeMap::new(),
            forgotten: 0,
            tally: Tally::default(),
            broken: BTreeMap::new(),
        })
    }

    /// Takes one step; an error is a message of what is wrong with the line.
    fn step(&mut self, line: usize, mut step: Step) -> Result<(), String> {
        self.steps += 1;
        let records = u64::from(self.history.sequence().record_count());
        if self.steps.saturating_mul(records.max(1)) > limits::TRACE_WORK {
            let most = limits::TRACE_WORK / records.max(1);
            return Err(format!("more than {most} steps of so many leaves"));
        }
        for part in PARTS {
            let wanted = self.header.parts.contains(&part);
            if wanted != step.tells(part) {
                let (key, not) = (part.key(), if wanted { "" } else { "not " });
                return Err(format!("the header says that steps do {not}tell {key:?}"));
            }
        }
        let to = self.target(&step)?;
        self.check_sizes(&step)?;
        let visible = step.visible.take().map(sorted);
        if let Some(visible) = &visible {
            self.check_visible(line, &step, &to, visible);
        }
        self.check_memory(line, &step);
        self.compare_with_earlier(line, &step, &to, visible.as_deref());
        let before = self.now.replace((to, visible));
        self.collapsed = step.collapse.zip(before.and_then(|(_, visible)| visible));
        Ok(())
    }

    /// The state that a step leads to.
    fn target(&self, step: &Step) -> Result<State, String> {
        let level = || match &self.now {
            Some((State::Uniform { collapses }, _)) => Ok(*collapses),
            Some((State::Variable { .. } | State::Cards(_) | State::Strokes(_), _)) => {
                Err("stands at clusters, not at a level")
            }
            None => Err("the first step says by \"level\" or \"clusters\" where it stands"),
        };
        let to = match (step.level, &step.clusters, step.collapse, step.split) {
            (Some(collapses), None, None, None) => State::Uniform { collapses },
            (None, Some(counts), None, None) => State::Variable {
                counts: counts.clone(),
            },
            (None, None, Some(by), None) => State::Uniform {
                collapses: level()?.saturating_add(by),
            },
            (None, None, None, Some(by)) => {
                let level = level()?;
                let collapses = level
                    .checked_sub(by)
                    .ok_or_else(|| format!("{by} splits, but only {level} collapses are done"))?;
                State::Uniform { collapses }
            }
            _ => {
                let keys = "\"level\", \"clusters\", \"collapse\" and \"split\"";
                return Err(format!("wanted exactly one of {keys}"));
            }
        };
        if self.history.fits(&to) {
            return Ok(to);
        }
        Err(match &to {
            State::Cards(_) | State::Strokes(_) => "traces are of leaves, not of cards".to_owned(),
            State::Uniform { collapses } => {
                let most = self.history.collapse_count();
                format!("level {collapses}, but there are {most} collapses")
            }
            State::Variable { counts } => {
                let most = self.history.most_counts();
                let past = counts
                    .iter()
                    .zip(&most)
                    .position(|(count, most)| count > most);
                match past {
                    Some(cluster) if counts.len() == most.len() => format!(
                        "{} collapses in cluster {cluster}, which has {}",
                        counts[cluster], most[cluster]
                    ),
                    _ => format!("{} numbers for {} clusters", counts.len(), most.len()),
                }
            }
        })
    }

    /// Whether bytes fit the resources that the header names.
    fn check_sizes(&self, step: &Step) -> Result<(), String> {
        let sizes: Vec<u64> = self.header.resources.iter().map(|r| r.bytes).collect();
        for (key, list) in [("resident", &step.resident), ("fresh", &step.fresh)] {
            let Some(list) = list else { continue };
            let found: Vec<u64> = list.iter().map(|hex| hex.0.len() as u64).collect();
            if found.len() != sizes.len() {
                let (found, wanted) = (found.len(), sizes.len());
                return Err(format!("{key:?} tells {found} resources of {wanted}"));
            }
            if let Some(number) = found.iter().zip(&sizes).position(|(a, b)| a != b) {
                let (found, wanted) = (found[number], sizes[number]);
                return Err(format!(
                    "{key:?} tells {found} bytes of resource {number}, which has {wanted}"
                ));
            }
        }
        let transfers = step.computed.iter().chain(step.writes.iter().flatten());
        let ranges = transfers.flat_map(|transfer| &transfer.0);
        let written = ranges.map(|range| {
            let end = range.at.checked_add(range.hex.0.len() as u64);
            (range.to, range.at, end)
        });
        let read = step.reads.iter().flatten();
        let read = read.map(|&(resource, from, to)| (resource, from, Some(to)));
        for (resource, from, to) in written.chain(read) {
            let Some(&size) = sizes.get(resource) else {
                return Err(format!(
                    "resource {resource}, but there are {}",
                    sizes.len()
                ));
            };
            if !to.is_some_and(|to| from <= to && to <= size) {
                let to = to.map_or("beyond 2^64".to_owned(), |to| to.to_string());
                return Err(format!(
                    "bytes {from}..{to} of resource {resource}, which has {size}"
                ));
            }
        }
        Ok(())
    }

    fn check_visible(&mut self, line: usize, step: &Step, to: &State, visible: &[u32]) {
        let split = step.split.zip(self.collapsed.take());
        if let Some((_, (_, before))) = split.filter(|(by, (collapsed, _))| by == collapsed) {
            let law = laws::split_undoes_collapse(to, &before, visible);
            let law = self.tally.count(Law::SplitUndoesCollapse, law);
            self.note(line, law);
        }
        // Each law by itself, so that one that is broken does not hide another.
        let law = laws::birth_before_death(&self.history, to, visible);
        let law = self.tally.count(Law::BirthBeforeDeath, law);
        self.note(line, law);
        let law = laws::partition(&self.history, to, visible);
        let law = self.tally.count(Law::Partition, law);
        self.note(line, law);
        if let Some((from, Some(before))) = &self.now {
            let law = laws::monotone_detail(&self.history, (from, before), (to, visible));
            let law = self.tally.count(Law::MonotoneDetail, law);
            self.note(line, law);
        }
    }

    fn check_memory(&mut self, line: usize, step: &Step) {
        if let Some(writes) = &step.writes {
            let transfers = step.computed.iter().chain(writes);
            for range in transfers.flat_map(|transfer| &transfer.0) {
                let to = index_usize(range.at)..index_usize(range.at) + range.hex.0.len();
                self.memory[range.to][to].copy_from_slice(&range.hex.0);
            }
            if step.resident.is_some() || step.counted.is_some() {
                let law = self.conservation(step, writes);
                let law = self.tally.count(Law::Conservation, law);
                self.note(line, law);
            }
        }
        if let (Some(resident), Some(reads), Some(fresh)) =
            (&step.resident, &step.reads, &step.fresh)
        {
            let [wanted, found] = [fresh, resident].map(|held| self.resources(held));
            let ranges: Vec<_> = reads
                .iter()
                .map(|&(resource, from, to)| (resource, index_usize(from)..index_usize(to)))
                .collect();
            let law = laws::residency_of(&ranges, &wanted, &found);
            let law = self.tally.count(Law::Residency, law);
            self.note(line, law);
        }
    }

    /// Whether the log of writes gives what is held and adds up to what was counted.
    fn conservation(&self, step: &Step, writes: &[Transfer]) -> Result<(), Violation> {
        if let Some(resident) = &step.resident {
            for (held, replayed) in self.resources(resident).iter().zip(&self.memory) {
                if held.residency == Residency::Device {
                    laws::same_bytes(
                        Law::Conservation,
                        held.name,
                        "replayed and held",
                        0,
                        replayed,
                        held.bytes,
                    )?;
                }
            }
        }
        let Some(counted) = &step.counted else {
            return Ok(());
        };
        let sum = writes.iter().flat_map(|transfer| &transfer.0);
        let sent = StepCounts {
            transfers: writes.len() as u64,
            bytes: sum.map(|range| range.hex.0.len() as u64).sum(),
        };
        let pairs = [
            (
                "transfers sent, and counted",
                sent.transfers,
                counted.transfers,
            ),
            ("bytes sent, and counted", sent.bytes, counted.bytes),
        ];
        for (what, sent, counted) in pairs {
            if sent != counted {
                let law = Law::Conservation;
                return Err(Violation::new(law, "in the counters", what, sent, counted));
            }
        }
        Ok(())
    }

    /// What was told of a state is told again when it comes again, however it is reached.
    fn compare_with_earlier(
        &mut self,
        line: usize,
        step: &Step,
        to: &State,
        visible: Option<&[u32]>,
    ) {
        let told = Seen {
            line,
            visible: visible.map(|leaves| {
                let mut digester = Digester::plain();
                leaves.iter().for_each(|&leaf| _ = digester.u32(leaf));
                digester.finish()
            }),
            held: [None; 2],
            image: step
                .image
                .as_ref()
                .map(|image| Digester::plain().text(image).finish()),
        };
        let mut key = Digester::plain();
        for count in to.counts(self.history.clusters()) {
            key.u32(count);
        }
        let key = key.finish();
        let held = self.read_bytes(step);
        let way = usize::from(matches!(to, State::Variable { .. }));
        let Some(first) = self.seen.get_mut(&key) else {
            if self.seen.len() < limits::TRACE_STATES {
                let mut told = told;
                told.held[way] = held;
                self.seen.insert(key, told);
            } else {
                self.forgotten += 1;
            }
            return;
        };
        let held_then = first.held[way];
        first.held[way] = held_then.or(held);
        let place = format!("in {} (first in line {})", Shown(to), first.line);
        let pairs = [
            (
                Law::HistoryIndependence,
                "visible leaves",
                first.visible,
                told.visible,
            ),
            (
                Law::HistoryIndependence,
                "bytes that a draw may read",
                held_then,
                held,
            ),
            (Law::ImageEquality, "picture", first.image, told.image),
        ];
        for (law, what, first, now) in pairs {
            let Some((first, now)) = first.zip(now) else {
                continue;
            };
            let kept = if first == now {
                Ok(())
            } else {
                Err(Violation::new(
                    law,
                    place.clone(),
                    what,
                    "as then",
                    "others",
                ))
            };
            let kept = self.tally.count(law, kept);
            self.note(line, kept);
        }
    }

    /// The digest of what a draw may read, with where it lies.
    fn read_bytes(&self, step: &Step) -> Option<Digest> {
        let (resident, mut reads) = step.resident.as_ref().zip(step.reads.clone())?;
        reads.sort_unstable();
        let mut digester = Digester::plain();
        for (resource, from, to) in reads {
            let bytes = &resident[resource].0[index_usize(from)..index_usize(to)];
            digester.u64(resource as u64).u64(from).bytes(bytes);
        }
        Some(digester.finish())
    }

    fn resources<'a>(&'a self, held: &'a [Hex]) -> Vec<Resource<'a>> {
        let named = self.header.resources.iter().zip(held);
        let resources = named.map(|(resource, hex)| Resource {
            name: &resource.name,
            residency: if resource.host {
                Residency::Host
            } else {
                Residency::Device
            },
            bytes: &hex.0,
        });
        resources.collect()
    }

    fn note(&mut self, line: usize, law: Result<(), Violation>) {
        if let Err(violation) = law {
            let broken = self.broken.entry(violation.law);
            let (count, ..) = broken.or_insert((0, line, violation));
            *count += 1;
        }
    }

    fn report(mut self) -> TraceReport {
        let laws = Law::ALL.into_iter().map(|law| {
            let (broken, first) = match self.broken.remove(&law) {
                Some((count, line, violation)) => (count, Some((line, violation))),
                None => (0, None),
            };
            LawReport {
                law,
                checked: self.tally.checked(law),
                broken,
                first,
            }
        });
        TraceReport {
            laws: laws.collect(),
            leaves: self.history.leaf_count(),
            collapses: self.history.collapse_count(),
            steps: self.steps,
            forgotten: self.forgotten,
        }
    }
}
