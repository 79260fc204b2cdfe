//! Models side by side: what each sends, against which others, and whether one beats it everywhere.

use super::ByteReport;
use super::sums::{Sums, Verdict};
use crate::run::{PlantBytes, Variant};

/// What is compared among each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Group {
    /// Models of foliage.
    Foliage,
    /// Models of trunks.
    Trunks,
}

impl Group {
    pub(super) const ALL: [Self; 2] = [Self::Foliage, Self::Trunks];

    /// What others are held against: of foliage the papers' mode on hardware, also with records of 8
    /// bytes, which is the fair one to beat; of trunks the papers' rival.
    pub(super) fn bases(self) -> &'static [&'static str] {
        match self {
            Self::Foliage => &["lodf-cluster", "lodf-cluster-u16"],
            Self::Trunks => &["full+mom-host", "full+mom-device"],
        }
    }

    fn has(self, variant: Variant) -> bool {
        variant.trunk.is_some() == (self == Self::Trunks)
    }
}

/// A model of one plant, or of all plants together.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    pub(super) variant: Variant,
    pub(super) sums: Sums,
    /// Of how many plants.
    pub(super) plants: usize,
    /// For each base that was walked and each link: how the model compares with it, a verdict a plant;
    /// none for the base itself.
    pub(super) against: Vec<Vec<Vec<Verdict>>>,
    /// For each link: for how many plants no model beats it. Nothing for what has no levels.
    pub(super) unbeaten: Vec<Option<usize>>,
}

/// The bases of a group that were walked.
pub(super) fn bases(report: &ByteReport, group: Group) -> Vec<&'static str> {
    let walked = |label: &&str| {
        let mut models = report.plants.iter().flat_map(|plant| &plant.models);
        models.any(|model| model.variant.label() == *label)
    };
    group.bases().iter().copied().filter(walked).collect()
}

/// The models of a group for one plant.
pub(super) fn entries(report: &ByteReport, plant: &PlantBytes, group: Group) -> Vec<Entry> {
    let models = plant.models.iter();
    let models = models.filter(|model| group.has(model.variant));
    let known: Vec<(Variant, Sums)> = models
        .map(|model| (model.variant, Sums::of(model)))
        .collect();
    let links = 0..report.links.len();
    let entry = |(variant, sums): &(Variant, Sums)| {
        let against = |base: &str| {
            let base = known.iter().find(|(other, _)| other.label() == base);
            let verdict = |link| {
                let (other, theirs) = base?;
                (other != variant && variant.has_levels())
                    .then(|| sums.cost(link).against(&theirs.cost(link)))
            };
            links
                .clone()
                .map(|link| Vec::from_iter(verdict(link)))
                .collect()
        };
        let unbeaten = |link| {
            let mut rivals = known.iter().filter(|(other, _)| other.has_levels());
            let cost = sums.cost(link);
            let beaten = rivals.any(|(_, theirs)| theirs.cost(link).dominates(&cost));
            variant.has_levels().then_some(usize::from(!beaten))
        };
        Entry {
            variant: *variant,
            sums: sums.clone(),
            plants: 1,
            against: bases(report, group).into_iter().map(against).collect(),
            unbeaten: links.clone().map(unbeaten).collect(),
        }
    };
    known.iter().map(entry).collect()
}

/// The models of a group for all plants together.
pub(super) fn together(report: &ByteReport, group: Group) -> Vec<Entry> {
    let mut all: Vec<Entry> = Vec::new();
    for plant in &report.plants {
        for entry in entries(report, plant, group) {
            match all.iter_mut().find(|known| known.variant == entry.variant) {
                Some(known) => known.add(entry),
                None => all.push(entry),
            }
        }
    }
    all
}

impl Entry {
    /// Whether the model can show anything but full detail.
    pub(super) fn has_levels(&self) -> bool {
        self.variant.has_levels()
    }

    /// Adds the same model of another plant.
    fn add(&mut self, other: Self) {
        self.sums.add(&other.sums);
        self.plants += other.plants;
        for (ours, theirs) in self.against.iter_mut().zip(other.against) {
            for (ours, theirs) in ours.iter_mut().zip(theirs) {
                ours.extend(theirs);
            }
        }
        for (ours, theirs) in self.unbeaten.iter_mut().zip(other.unbeaten) {
            if let (Some(ours), Some(theirs)) = (ours, theirs) {
                *ours += theirs;
            }
        }
    }
}
