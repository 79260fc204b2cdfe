//! What a model sends over a whole walk, and which of two sends less.

use crate::gpu::{Ticks, Traffic};
use crate::run::{ModelBytes, StepBytes, StepTraffic};

/// What a model sends over a whole walk, of one plant or of several together.
#[derive(Debug, Clone, Default)]
pub(super) struct Sums {
    /// Device memory at full detail, but for what is drawn into.
    pub(super) resident_bytes: u64,
    /// Before step 0, on each link.
    pub(super) initial: Vec<Traffic>,
    /// All steps, with the frame of step 0, which changes nothing.
    pub(super) walk: Part,
    /// Steps 1 to the last.
    pub(super) changes: Part,
    /// How many of these there are.
    pub(super) change_count: u64,
    /// The longest of them, on each link.
    pub(super) longest: Vec<Ticks>,
}

/// Some steps together.
#[derive(Debug, Clone, Default)]
pub(super) struct Part {
    /// On each link.
    pub(super) traffic: Vec<StepTraffic>,
    /// Of the command stream.
    pub(super) command_bytes: u64,
    /// Submitted.
    pub(super) vertices: u64,
}

impl Sums {
    pub(super) fn of(model: &ModelBytes) -> Self {
        let changing = model.steps.get(1..).unwrap_or_default();
        let longest = |link: usize| {
            let steps = changing.iter().filter_map(|step| step.traffic.get(link));
            steps.map(ticks).max().unwrap_or(0)
        };
        Self {
            resident_bytes: model.resident_bytes,
            initial: model.initial.clone(),
            walk: Part::of(&model.steps),
            changes: Part::of(changing),
            change_count: changing.len() as u64,
            longest: (0..model.initial.len()).map(longest).collect(),
        }
    }

    /// Adds the same model of another plant.
    pub(super) fn add(&mut self, other: &Self) {
        self.resident_bytes += other.resident_bytes;
        self.initial.resize(other.initial.len(), Traffic::default());
        for (sum, traffic) in self.initial.iter_mut().zip(&other.initial) {
            sum.add(traffic);
        }
        self.walk.add(&other.walk);
        self.changes.add(&other.changes);
        self.change_count += other.change_count;
        self.longest.resize(other.longest.len(), 0);
        for (longest, ticks) in self.longest.iter_mut().zip(&other.longest) {
            *longest = (*longest).max(*ticks);
        }
    }

    /// What a walk costs on a link.
    pub(super) fn cost(&self, link: usize) -> Cost {
        let traffic = self.walk.on(link);
        Cost {
            bytes: traffic.upload.payload_bytes
                + traffic.fetch.payload_bytes
                + self.walk.command_bytes,
            ticks: ticks(&traffic),
            vertices: self.walk.vertices,
            resident_bytes: self.resident_bytes,
        }
    }
}

impl Part {
    fn of(steps: &[StepBytes]) -> Self {
        let mut part = Self::default();
        for step in steps {
            part.add(&Self {
                traffic: step.traffic.clone(),
                command_bytes: step.command_bytes,
                vertices: step.vertices,
            });
        }
        part
    }

    fn add(&mut self, other: &Self) {
        let links = self.traffic.len().max(other.traffic.len());
        self.traffic.resize(links, StepTraffic::default());
        for (sum, traffic) in self.traffic.iter_mut().zip(&other.traffic) {
            sum.add(traffic);
        }
        self.command_bytes += other.command_bytes;
        self.vertices += other.vertices;
    }

    /// On one of the links.
    pub(super) fn on(&self, link: usize) -> StepTraffic {
        self.traffic.get(link).copied().unwrap_or_default()
    }
}

/// Modelled time on the bus: uploads, then fetches.
pub(super) fn ticks(traffic: &StepTraffic) -> Ticks {
    traffic.upload.ticks + traffic.fetch.ticks
}

/// What a walk costs, in the four measures by which models are compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Cost {
    /// All that goes down the bus after the first upload: uploaded and fetched payload and commands. The
    /// only place where streams are taken together: a mode that moves bytes from one to another saves
    /// none.
    pub(super) bytes: u64,
    /// Modelled time on the bus.
    pub(super) ticks: Ticks,
    /// Vertices submitted.
    pub(super) vertices: u64,
    /// Device memory.
    pub(super) resident_bytes: u64,
}

/// Whether measures, of each of which less is better, are nowhere more than others and somewhere less.
pub(in crate::report) fn dominates<T: PartialOrd>(ours: &[T], theirs: &[T]) -> bool {
    let pairs = || ours.iter().zip(theirs);
    pairs().all(|(ours, theirs)| ours <= theirs) && pairs().any(|(ours, theirs)| ours < theirs)
}

impl Cost {
    /// Whether it is nowhere more and somewhere less.
    pub(super) fn dominates(&self, other: &Self) -> bool {
        let values = |cost: &Self| [cost.bytes, cost.ticks, cost.vertices, cost.resident_bytes];
        dominates(&values(self), &values(other))
    }

    /// How a model compares with another on the bus.
    pub(super) fn against(&self, base: &Self) -> Verdict {
        let (fewer, faster) = (self.bytes < base.bytes, self.ticks < base.ticks);
        match (fewer, faster) {
            (true, true) => Verdict::Better,
            (true, false) => Verdict::OnlyFewerBytes,
            (false, true) => Verdict::OnlyLessTime,
            (false, false) if (self.bytes, self.ticks) == (base.bytes, base.ticks) => Verdict::Same,
            (false, false) => Verdict::Worse,
        }
    }
}

/// How a model compares with another on the bus. Only what sends fewer bytes *and* takes less time is
/// better: many small transfers can lose to a large one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Verdict {
    Better,
    OnlyFewerBytes,
    OnlyLessTime,
    Same,
    Worse,
}

impl Verdict {
    pub(super) fn words(self) -> &'static str {
        match self {
            Self::Better => "better",
            Self::OnlyFewerBytes => "only fewer bytes",
            Self::OnlyLessTime => "only less time",
            Self::Same => "the same",
            Self::Worse => "worse",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cost([bytes, ticks, vertices, resident_bytes]: [u64; 4]) -> Cost {
        Cost {
            bytes,
            ticks,
            vertices,
            resident_bytes,
        }
    }

    #[test]
    fn better_takes_fewer_bytes_and_less_time() {
        let base = cost([10, 10, 1, 1]);
        for (bytes, ticks, wanted) in [
            (9, 9, Verdict::Better),
            (9, 10, Verdict::OnlyFewerBytes),
            (9, 11, Verdict::OnlyFewerBytes),
            (10, 9, Verdict::OnlyLessTime),
            (10, 10, Verdict::Same),
            (10, 11, Verdict::Worse),
            (11, 11, Verdict::Worse),
        ] {
            // What lies on the device, and what it draws, says nothing of the bus.
            let own = cost([bytes, ticks, 99, 0]);
            assert_eq!(own.against(&base), wanted, "{bytes} B, {ticks} ticks");
        }
    }

    #[test]
    fn what_is_nowhere_more_and_somewhere_less_dominates() {
        let base = cost([4, 4, 4, 4]);
        assert!(!base.dominates(&base));
        for place in 0..4 {
            let mut values = [4; 4];
            values[place] = 3;
            assert!(cost(values).dominates(&base) && !base.dominates(&cost(values)));
            values[(place + 1) % 4] = 5;
            assert!(!cost(values).dominates(&base) && !base.dominates(&cost(values)));
        }
    }

    #[test]
    fn step_0_changes_nothing_and_is_no_change() {
        let step = |bytes: u64, ticks| StepBytes {
            leaves: 1,
            traffic: vec![StepTraffic {
                upload: Traffic::default(),
                fetch: Traffic {
                    transfers: 1,
                    payload_bytes: bytes,
                    wire_bytes: bytes,
                    ticks,
                },
            }],
            command_bytes: 100,
            vertices: 7,
        };
        let model = ModelBytes {
            variant: crate::run::Variant::ALL[0],
            resident_bytes: 5,
            initial: vec![Traffic::default()],
            steps: vec![step(30, 9), step(20, 4), step(10, 6)],
        };
        let mut sums = Sums::of(&model);
        assert_eq!(sums.cost(0), cost([360, 19, 21, 5]));
        assert_eq!(sums.changes.on(0).fetch.payload_bytes, 30);
        assert_eq!((sums.change_count, &sums.longest[..]), (2, &[6][..]));
        sums.add(&Sums::of(&model));
        assert_eq!(sums.cost(0), cost([720, 38, 42, 10]));
        assert_eq!((sums.change_count, &sums.longest[..]), (4, &[6][..]));
    }
}
