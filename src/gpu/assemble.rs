//! The input assembler: which vertices a draw names, and what they cost when they lie on the host.

use std::collections::VecDeque;

use super::pass::{Corners, RESTART};
use super::reads::Fetched;
use super::resource::Buffer;
use super::{GpuError, Residency};

/// How many transformed vertices the post-transform cache holds, first in, first out; a vertex
/// found there is not fetched again.
pub(super) const VERTEX_CACHE: usize = 16;

/// A draw with all its arguments.
#[derive(Debug, Clone, Copy)]
pub(super) struct Arguments {
    pub(super) source: Corners,
    pub(super) first_corner: u32,
    pub(super) corner_count: u32,
    /// What is added to short indices.
    pub(super) first_vertex: u32,
    pub(super) instance: u32,
    pub(super) group: u32,
}

/// The vertex index of every corner of a draw, of strips with their restarts.
///
/// # Errors
///
/// [`GpuError::Bounds`] when the index buffer is too short or an index names no whole vertex.
pub(super) fn corners(
    arguments: &Arguments,
    indices: Option<&Buffer>,
    vertices: Option<(&Buffer, u32)>,
) -> Result<Vec<u32>, GpuError> {
    let (first, count) = (arguments.first_corner, arguments.corner_count);
    let corners: Vec<u32> = match (arguments.source, indices) {
        (Corners::Indexed | Corners::Strips, Some(buffer)) => {
            let range = buffer.range(4 * u64::from(first), 4 * u64::from(count), "draw")?;
            buffer.bytes[range]
                .chunks_exact(4)
                .map(|four| u32::from_le_bytes(four.try_into().expect("chunks of four bytes")))
                .collect()
        }
        (Corners::Short, Some(buffer)) => {
            let range = buffer.range(2 * u64::from(first), 2 * u64::from(count), "draw")?;
            let indices = buffer.bytes[range].as_chunks::<2>().0.iter();
            indices
                .map(|two| {
                    let index = u32::from(u16::from_le_bytes(*two));
                    // What is past the last number lies in no buffer either.
                    index.saturating_add(arguments.first_vertex)
                })
                .collect()
        }
        (Corners::Indexed | Corners::Short | Corners::Strips, None) => Vec::new(),
        (Corners::Counted, _) => {
            if let (Some((buffer, stride)), Some(last)) = (vertices, count.checked_sub(1)) {
                // Before corners are listed that may be too many to list.
                let last = u64::from(first) + u64::from(last);
                buffer.range(last * u64::from(stride), u64::from(stride), "draw")?;
            }
            (first..first.saturating_add(count)).collect()
        }
    };
    if let Some((buffer, stride)) = vertices
        && let Some(&most) = corners
            .iter()
            .filter(|&&corner| arguments.source != Corners::Strips || corner != RESTART)
            .max()
    {
        buffer.range(
            u64::from(most) * u64::from(stride),
            u64::from(stride),
            "draw",
        )?;
    }
    Ok(corners)
}

/// The triangles of strips, three corners each.
///
/// Every second triangle of a strip is turned over; then each is turned so that its lowest corner
/// comes first, so that neither strip nor place shows. Those with two equal corners are left out.
pub(super) fn triangles_of_strips(strips: &[u32]) -> Vec<u32> {
    let mut triangles = Vec::with_capacity(3 * strips.len());
    for (place, &[a, b, c]) in windows(strips) {
        if a == b || b == c || c == a {
            continue;
        }
        let [a, b, c] = if place % 2 == 0 { [a, b, c] } else { [b, a, c] };
        triangles.extend(if a < b && a < c {
            [a, b, c]
        } else if b < c {
            [b, c, a]
        } else {
            [c, a, b]
        });
    }
    triangles
}

/// Three corners in a row of one strip, with their place in it: what is assembled to a triangle.
pub(super) fn windows(strips: &[u32]) -> impl Iterator<Item = (usize, &[u32; 3])> {
    strips.split(|&corner| corner == RESTART).flat_map(|strip| {
        strip
            .windows(3)
            .filter_map(<[u32]>::first_chunk)
            .enumerate()
    })
}

/// What a draw pulls from host memory: bytes of indices, bytes of vertices.
///
/// `corners` are as submitted, `index_count` of them in the index buffer.
pub(super) fn fetched_bytes(
    source: Corners,
    corners: &[u32],
    index_count: u64,
    indices: Option<&Buffer>,
    vertices: Option<(&Buffer, u32)>,
) -> (u64, u64) {
    let on_host = |buffer: &Buffer| buffer.residency == Residency::Host;
    let index_bytes = indices
        .filter(|buffer| on_host(buffer))
        .map_or(0, |_| u64::from(source.index_bytes()) * index_count);
    let vertex_bytes = vertices
        .filter(|(buffer, _)| on_host(buffer))
        .map_or(0, |(_, stride)| u64::from(stride) * cache_misses(corners));
    (index_bytes, vertex_bytes)
}

/// How many vertices are transformed when a cache of [`VERTEX_CACHE`] holds the last ones.
fn cache_misses(corners: &[u32]) -> u64 {
    let mut cache = VecDeque::with_capacity(VERTEX_CACHE);
    let mut misses = 0;
    for &corner in corners.iter().filter(|&&corner| corner != RESTART) {
        if !cache.contains(&corner) {
            if cache.len() == VERTEX_CACHE {
                cache.pop_front();
            }
            cache.push_back(corner);
            misses += 1;
        }
    }
    misses
}

/// What each primitive of a draw pulls from host memory; short indices with what is added to them.
///
/// `key` is the draw's group and instance.
pub(super) fn fetched<'a>(
    (group, instance): (u32, u32),
    primitives: impl Iterator<Item = &'a [u32]>,
    indices: Option<&Buffer>,
    vertices: Option<(&Buffer, u32)>,
) -> Vec<Fetched> {
    let on_host = |buffer: &Buffer| buffer.residency == Residency::Host;
    let fetch = |primitive: &[u32]| {
        let mut bytes = Vec::new();
        if indices.is_some_and(on_host) {
            bytes.extend(primitive.iter().flat_map(|index| index.to_le_bytes()));
        }
        if let Some((buffer, stride)) = vertices.filter(|(buffer, _)| on_host(buffer)) {
            for &index in primitive {
                let from = index as usize * stride as usize;
                bytes.extend_from_slice(&buffer.bytes[from..from + stride as usize]);
            }
        }
        Fetched {
            group,
            instance,
            vertex: primitive[0],
            bytes,
        }
    };
    primitives
        .map(fetch)
        .filter(|fetched| !fetched.bytes.is_empty())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_are_assembled_to_triangles() {
        // 0 1 2 3, then a run that says nothing, then a second strip.
        let strips = [0, 1, 2, 3, 3, 3, 2, 4, RESTART, 7, 5, 6, RESTART, 8, 9];
        let triangles = triangles_of_strips(&strips);
        assert_eq!(triangles, [0, 1, 2, 1, 3, 2, 2, 3, 4, 5, 6, 7]);
        assert_eq!(windows(&strips).count(), 7);
        assert_eq!(cache_misses(&strips), 10);
    }

    #[test]
    fn the_cache_holds_sixteen_vertices() {
        let quads: Vec<u32> = (0..400).collect();
        assert_eq!(cache_misses(&quads), 400);
        let twice: Vec<u32> = (0..16).chain(0..16).collect();
        assert_eq!(cache_misses(&twice), 16);
        let beyond: Vec<u32> = (0..17).chain([0]).collect();
        assert_eq!(cache_misses(&beyond), 18);
    }
}
