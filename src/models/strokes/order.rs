//! In which order strokes are drawn.

use std::ops::Range;
use std::sync::Arc;

use super::painting::Painting;
use crate::math::{Vec3, index_u32};

/// The strokes that show, and in which order: a permutation of their places.
///
/// A *place* counts the strokes of all runs in the order of the list. From far to near by the distance
/// of centres to the eye, of equals the lowest place first. Until an eye is known, and for those that
/// have come since it was, the order of the list.
#[derive(Debug)]
pub(super) struct Order {
    painting: Arc<Painting>,
    pub(super) runs: Vec<Range<u32>>,
    /// One entry for every stroke that may show, of which as many count as do.
    pub(super) places: Vec<u32>,
    pub(super) count: u32,
}

impl Order {
    pub(super) fn of(painting: Arc<Painting>, runs: Vec<Range<u32>>) -> Self {
        let places = (0..painting.most_strokes()).collect();
        let count = count(&runs);
        Self {
            painting,
            runs,
            places,
            count,
        }
    }

    /// Shows other runs.
    pub(super) fn show(&mut self, runs: Vec<Range<u32>>) {
        self.count = count(&runs);
        self.runs = runs;
    }

    /// Sorts for an eye in the plant's space; answers which entries changed, as a range around them.
    pub(super) fn look_from(&mut self, eye: Vec3) -> Range<usize> {
        let records = self.painting.records();
        let numbers = self.runs.iter().cloned().flatten();
        let mut far: Vec<(f32, u32)> = (0..)
            .zip(numbers)
            .map(|(place, number): (u32, u32)| {
                let center = records[number as usize].stroke.center;
                (center.distance_squared(eye), place)
            })
            .collect();
        far.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let changed = |pair: (&u32, &(f32, u32))| *pair.0 != pair.1.1;
        let first = self.places.iter().zip(&far).position(changed);
        let Some(first) = first else {
            return 0..0;
        };
        let last = self.places[..far.len()].iter().zip(&far).rposition(changed);
        for (place, (_, found)) in self.places.iter_mut().zip(far) {
            *place = found;
        }
        first..last.unwrap_or(first) + 1
    }

    /// The numbers of all strokes that show, in order.
    pub(super) fn strokes(&self) -> Vec<u32> {
        let listed: Vec<u32> = self.runs.iter().cloned().flatten().collect();
        let places = self.places[..self.count as usize].iter();
        places
            .filter_map(|place| listed.get(*place as usize).copied())
            .collect()
    }
}

fn count(runs: &[Range<u32>]) -> u32 {
    runs.iter().fold(0, |sum, run| sum + (run.end - run.start))
}

/// The runs as the vertex stage reads them: how many there are, then of each the place after its last
/// stroke, and what added to a place gives the number of the stroke, modulo 2³².
pub(super) fn run_words(runs: &[Range<u32>]) -> Vec<u32> {
    let mut words = vec![index_u32(runs.len())];
    let mut end = 0;
    for run in runs {
        let first = end;
        end += run.end - run.start;
        words.extend([end, run.start.wrapping_sub(first)]);
    }
    words
}
