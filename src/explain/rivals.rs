//! Who covers a sample, and what decides between them.

use serde::Serialize;

use crate::gpu::{Blend, Key, ProbedFragment};

/// A sample of a pixel.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SampleStory {
    /// Its number.
    pub sample: u32,
    /// The number of what shows, among the report's fragments; `None` for background.
    pub shows: Option<u64>,
    /// The depth of what shows, or that to which the picture was cleared: 0 near, 1 far.
    pub depth: f32,
    /// What put it before the next.
    pub verdict: Verdict,
    /// How many fragments cover the sample.
    pub rival_count: u64,
    /// Who covers it, nearest first.
    pub rivals: Vec<Rival>,
}

/// Who covers a sample.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rival {
    /// Its number among the report's fragments.
    pub fragment: u64,
    /// Its depth at the sample.
    pub depth: f32,
    /// What became of it.
    pub fate: Fate,
}

/// What becomes of a fragment at a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fate {
    /// It shows.
    Shows,
    /// It lies behind what shows.
    Behind,
    /// As near as what shows, but its key is greater.
    LostByKey,
    /// As near as what shows and of the same key, but submitted later.
    LostByOrder,
    /// The alpha test killed it.
    KilledByAlpha,
    /// It lies at the depth to which the picture was cleared, or beyond.
    BeyondClearDepth,
    /// It is blended over what shows.
    Blended,
}

/// What puts what shows before the next fragment that the alpha test keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Nothing shows.
    Background,
    /// There is no other.
    Alone,
    /// It is nearer.
    Depth,
    /// Equally near: its key is less.
    Key,
    /// Equally near, of the same key: submitted first.
    Order,
}

/// By what opaque fragments are ordered: depths compare as their bits.
type Rank = (u32, Key, usize);

/// Decides a sample by the rasterizer's rule book, and answers the least rank as well.
pub(super) fn decide(
    sample: u32,
    fragments: &[ProbedFragment],
    clear_depth: f32,
) -> (SampleStory, Option<usize>) {
    let covers: Vec<(Rank, &ProbedFragment, f32)> = fragments
        .iter()
        .enumerate()
        .filter_map(|(number, fragment)| {
            let depth = fragment.depths.get(sample as usize).copied().flatten()?;
            Some(((depth.to_bits(), fragment.key, number), fragment, depth))
        })
        .collect();
    let counts = |(rank, fragment, _): &(Rank, &ProbedFragment, f32)| {
        fragment.kept && fragment.blend == Blend::Opaque && rank.0 < clear_depth.to_bits()
    };
    let mut ranks: Vec<Rank> = covers
        .iter()
        .filter(|one| counts(one))
        .map(|one| one.0)
        .collect();
    ranks.sort_unstable();
    let winner = ranks.first().copied();
    let verdict = match (winner, ranks.get(1)) {
        (None, _) => Verdict::Background,
        (Some(_), None) => Verdict::Alone,
        (Some(first), Some(second)) if first.0 < second.0 => Verdict::Depth,
        (Some(first), Some(second)) if first.1 < second.1 => Verdict::Key,
        (Some(_), Some(_)) => Verdict::Order,
    };
    let fate = |(rank, fragment, _): &(Rank, &ProbedFragment, f32)| match winner {
        _ if !fragment.kept => Fate::KilledByAlpha,
        _ if rank.0 >= clear_depth.to_bits() => Fate::BeyondClearDepth,
        Some(first) if *rank == first => Fate::Shows,
        Some(first) if first.0 < rank.0 => Fate::Behind,
        _ if fragment.blend != Blend::Opaque => Fate::Blended,
        Some(first) if first.1 < rank.1 => Fate::LostByKey,
        _ => Fate::LostByOrder,
    };
    let mut sorted: Vec<&(Rank, &ProbedFragment, f32)> = covers.iter().collect();
    sorted.sort_unstable_by_key(|one| one.0);
    let rivals = sorted.into_iter().map(|one| Rival {
        fragment: one.0.2 as u64,
        depth: one.2,
        fate: fate(one),
    });
    let (rival_count, rivals) = super::bounded(rivals.collect());
    let story = SampleStory {
        sample,
        shows: winner.map(|rank| rank.2 as u64),
        depth: winner.map_or(clear_depth, |rank| f32::from_bits(rank.0)),
        verdict,
        rival_count,
        rivals,
    };
    (story, winner.map(|rank| rank.2))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec4;

    fn fragment(depth: f32, vertex: u32, kept: bool) -> ProbedFragment {
        let key = Key {
            group: 1,
            instance: 0,
            vertex,
            triangle: 0,
        };
        ProbedFragment {
            key,
            corners: vec![vertex; 4],
            depths: vec![Some(depth)],
            kept,
            front: true,
            blend: Blend::Opaque,
            colour: Vec4::ONE,
        }
    }

    #[test]
    fn nearer_then_less_then_first() {
        let decided = |fragments: &[ProbedFragment]| {
            let (story, winner) = decide(0, fragments, 1.0);
            let fates: Vec<_> = story
                .rivals
                .iter()
                .map(|rival| (rival.fragment, rival.fate))
                .collect();
            (winner, story.verdict, fates)
        };
        let near_but_killed = fragment(0.1, 0, false);
        assert_eq!(
            decided(&[
                fragment(0.5, 3, true),
                near_but_killed.clone(),
                fragment(0.4, 8, true)
            ]),
            (
                Some(2),
                Verdict::Depth,
                vec![
                    (1, Fate::KilledByAlpha),
                    (2, Fate::Shows),
                    (0, Fate::Behind)
                ]
            )
        );
        assert_eq!(
            decided(&[fragment(0.5, 8, true), fragment(0.5, 3, true)]),
            (
                Some(1),
                Verdict::Key,
                vec![(1, Fate::Shows), (0, Fate::LostByKey)]
            )
        );
        assert_eq!(
            decided(&[fragment(0.5, 8, true), fragment(0.5, 8, true)]),
            (
                Some(0),
                Verdict::Order,
                vec![(0, Fate::Shows), (1, Fate::LostByOrder)]
            )
        );
        assert_eq!(
            decided(&[near_but_killed, fragment(1.0, 8, true)]),
            (
                None,
                Verdict::Background,
                vec![(0, Fate::KilledByAlpha), (1, Fate::BeyondClearDepth)]
            )
        );
    }
}
