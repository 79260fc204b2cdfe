//! Passes whose geometry is too much at once: which part of the target each call of a vertex stage
//! reaches, and in which parts the target is drawn.
//!
//! ```text
//!  calls ─vertex stage, once more─▶ footprints ─halved until they fit─▶ parts: a region, its calls
//! ```
//!
//! **Invariant.** Every call is part of each region in which it may show, so pictures and counters are
//! those of a pass that is drawn at once.

use crate::raster::{Blend, Region};

/// What the geometry of one pass may take before it is drawn part by part.
pub(super) const GEOMETRY_BYTES: u64 = 1 << 30;

/// About what a corner takes from the vertex stage to the tiles: of a leaf, a quarter of four vertices
/// with their attributes and of two triangles.
pub(super) const CORNER_BYTES: u64 = 96;

/// A call of a vertex stage as far as parts go.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    /// Where it may show; `None` for nowhere.
    pub(super) region: Option<Region>,
    pub(super) blend: Blend,
    pub(super) corners: usize,
    pub(super) emitted_vertices: usize,
}

/// A part of the target with the numbers of its calls, ascending.
#[derive(Debug, PartialEq)]
pub(super) struct Part {
    pub(super) region: Region,
    pub(super) calls: Vec<usize>,
}

/// Halves a target of this size until the calls of each part take at most so many bytes, or it is a
/// single block.
///
/// Blended calls are in every part: they decide which opaque ones are shaded together.
pub(super) fn parts(size: [u32; 2], reaches: &[Reach], most_bytes: u64) -> Vec<Part> {
    let reaching = |region: Region, calls: &[usize]| -> Vec<usize> {
        let kept = calls.iter().copied().filter(|&call| {
            let Reach {
                region: found,
                blend,
                ..
            } = reaches[call];
            blend != Blend::Opaque || found.is_some_and(|found| found.meets(region))
        });
        kept.collect()
    };
    let all: Vec<usize> = (0..reaches.len()).collect();
    let whole = Region::whole(size);
    let mut pending = vec![(whole, reaching(whole, &all))];
    let mut parts = Vec::new();
    while let Some((region, calls)) = pending.pop() {
        let corners: usize = calls.iter().map(|&call| reaches[call].corners).sum();
        match region
            .halves()
            .filter(|_| CORNER_BYTES * corners as u64 > most_bytes)
        {
            Some(halves) => {
                let halves = halves.map(|half| (half, reaching(half, &calls)));
                pending.extend(halves.into_iter().rev());
            }
            None => parts.push(Part { region, calls }),
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_hold_what_reaches_them_and_fit() {
        let whole = Region::whole([256, 64]);
        let [left, right] = whole.halves().unwrap();
        let reach = |region, blend| Reach {
            region,
            blend,
            corners: 100,
            emitted_vertices: 0,
        };
        let reaches = [
            reach(Some(left), Blend::Opaque),
            reach(Some(right), Blend::Opaque),
            reach(None, Blend::Opaque),
            reach(None, Blend::Alpha),
        ];
        let of = |most| {
            let parts = parts([256, 64], &reaches, most * CORNER_BYTES);
            let lists = parts.into_iter().map(|part| (part.region, part.calls));
            lists.collect::<Vec<_>>()
        };
        assert_eq!(of(300), [(whole, vec![0, 1, 3])]);
        assert_eq!(of(299), [(left, vec![0, 3]), (right, vec![1, 3])]);
        // Four single blocks, however little is allowed.
        assert_eq!(of(0).len(), 4);
    }
}
