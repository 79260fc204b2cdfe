//! Time, of this process and of all others, as the peers' scripts tell it.

use std::time::Instant;

/// Ticks a second of the times in `/proc`: so on every Linux that people use.
const TICKS: f64 = 100.0;

/// How long frames took.
#[derive(Debug)]
pub(crate) struct Frames {
    /// Milliseconds of each, ascending.
    pub(crate) sorted: Vec<f64>,
    /// Milliseconds of processor time of this process a frame.
    pub(crate) own: f64,
    /// How many cores other processes took meanwhile.
    pub(crate) others: f64,
}

impl Frames {
    /// Milliseconds of the one in the middle; of two, their mean.
    pub(crate) fn median(&self) -> f64 {
        let count = self.sorted.len();
        let middle = |from_end: usize| self.sorted.get(count.wrapping_sub(from_end));
        let (low, high) = (middle(count / 2 + 1), middle(count.div_ceil(2)));
        low.zip(high).map_or(0.0, |(low, high)| (low + high) / 2.0)
    }

    /// Milliseconds of the shortest and the longest.
    pub(crate) fn ends(&self) -> [f64; 2] {
        [self.sorted.first(), self.sorted.last()].map(|end| end.copied().unwrap_or_default())
    }
}

/// How often and how long a frame is drawn.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Schedule {
    /// Frames that do not count.
    pub(crate) warmup: u32,
    /// Frames that count, at most.
    pub(crate) frames: u32,
    /// After so many seconds no further frame begins, if there were three.
    pub(crate) most_seconds: f64,
}

/// Times `frame`, and calls `between` after each outside of its time.
pub(crate) fn time<S, E>(
    schedule: Schedule,
    subject: &mut S,
    mut frame: impl FnMut(&mut S) -> Result<(), E>,
    mut between: impl FnMut(&mut S),
) -> Result<Frames, E> {
    for _ in 0..schedule.warmup {
        frame(subject)?;
        between(subject);
    }
    let (all_before, own_before) = (busy_seconds(), own_seconds());
    let start = Instant::now();
    let mut sorted = Vec::new();
    for number in 0..schedule.frames {
        if number >= 3 && start.elapsed().as_secs_f64() > schedule.most_seconds {
            break;
        }
        let begin = Instant::now();
        frame(subject)?;
        sorted.push(1e3 * begin.elapsed().as_secs_f64());
        between(subject);
    }
    let wall = start.elapsed().as_secs_f64().max(1e-9);
    let (all, own) = (busy_seconds() - all_before, own_seconds() - own_before);
    sorted.sort_by(f64::total_cmp);
    Ok(Frames {
        own: 1e3 * own / (sorted.len().max(1) as f64),
        others: ((all - own) / wall).max(0.0),
        sorted,
    })
}

/// Processor seconds that everybody took so far; 0 where there is no `/proc`.
fn busy_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/stat").unwrap_or_default();
    let line = text.lines().next().unwrap_or_default();
    let ticks: Vec<f64> = line
        .split_whitespace()
        .skip(1)
        .take(8)
        .flat_map(str::parse)
        .collect();
    // Idle, and waiting for disks.
    let idle: f64 = ticks.iter().skip(3).take(2).sum();
    (ticks.iter().sum::<f64>() - idle) / TICKS
}

/// Processor seconds that this process took so far; 0 where there is no `/proc`.
fn own_seconds() -> f64 {
    let text = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The name, in parentheses, may hold anything; 12 and 13 fields behind it are the times.
    let fields = text
        .rsplit(')')
        .next()
        .unwrap_or_default()
        .split_whitespace();
    fields
        .skip(11)
        .take(2)
        .flat_map(str::parse::<f64>)
        .sum::<f64>()
        / TICKS
}
