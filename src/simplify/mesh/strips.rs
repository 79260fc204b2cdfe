//! Triangles to strips.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::math::index_u32;

/// Triangle strips: of `n` vertices the first three are a triangle, and each further one makes another
/// with the two before it; every second triangle is turned over.
///
/// ```text
///  0───2───4
///   ╲ ╱ ╲ ╱ ╲     (0, 1, 2)  (2, 1, 3)  (2, 3, 4)  (4, 3, 5)
///    1───3───5
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Strips {
    pub(super) vertices: Vec<u32>,
    /// Where each strip begins in `vertices`, and the end of the last.
    pub(super) starts: Vec<u32>,
    /// The triangles in the order of the strips, two fewer a strip than vertices.
    pub(super) triangles: Vec<u32>,
}

impl Strips {
    /// How many strips there are.
    #[must_use]
    pub fn count(&self) -> u32 {
        index_u32(self.starts.len() - 1)
    }

    /// Each strip's vertices and the numbers of its triangles.
    pub fn iter(&self) -> impl Iterator<Item = (&[u32], &[u32])> + '_ {
        (0..).zip(self.starts.windows(2)).map(|(strip, ends)| {
            let (from, to) = (ends[0] as usize, ends[1] as usize);
            let before = 2 * strip;
            let triangles = &self.triangles[from - before..to - before - 2];
            (&self.vertices[from..to], triangles)
        })
    }
}

const NONE: u32 = u32::MAX;

/// Joins the triangles with `wanted` numbers to strips, each triangle in one strip.
///
/// Greedily: a strip begins at the triangle with the fewest neighbours that are in no strip yet (the
/// lowest number of several), and goes on over the last edge while there is a triangle. Of the three
/// edges to begin with, the one is taken that leads furthest.
#[must_use]
pub fn strips_of(triangles: &[[u32; 3]], wanted: impl Fn(u32) -> bool) -> Strips {
    let mut builder = Builder::new(triangles, wanted);
    let mut strips = Strips {
        starts: vec![0],
        ..Strips::default()
    };
    while let Some(first) = builder.first() {
        let walks = [0, 1, 2].map(|corner| builder.length(first, corner));
        let longest = (0..3).max_by_key(|&corner| (walks[corner], Reverse(corner)));
        builder.walk(first, longest.unwrap_or(0), &mut strips);
        strips.starts.push(index_u32(strips.vertices.len()));
    }
    strips
}

struct Builder<'a> {
    triangles: &'a [[u32; 3]],
    /// Across the edge from each corner to the next.
    neighbours: Vec<[u32; 3]>,
    /// Neighbours that are in no strip; [`NONE`] for a triangle that is in one.
    free: Vec<u32>,
    /// `(free neighbours, triangle)`, some of them long past.
    heap: BinaryHeap<Reverse<(u32, u32)>>,
    /// Triangles that the present walk has passed.
    passed: Vec<u32>,
    walk: u32,
}

impl<'a> Builder<'a> {
    fn new(triangles: &'a [[u32; 3]], wanted: impl Fn(u32) -> bool) -> Self {
        let mut edges: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * triangles.len());
        let numbered = || {
            (0..)
                .zip(triangles)
                .filter(|(triangle, _)| wanted(*triangle))
        };
        for (triangle, &[a, b, c]) in numbered() {
            edges.extend([[a, b], [b, c], [c, a]].map(|edge| (edge, triangle)));
        }
        edges.sort_unstable();
        let across = |from: u32, to: u32| {
            let place = edges.partition_point(|&(edge, _)| edge < [to, from]);
            let found = edges.get(place).filter(|&&(edge, _)| edge == [to, from]);
            found.map_or(NONE, |&(_, triangle)| triangle)
        };
        let mut neighbours = vec![[NONE; 3]; triangles.len()];
        let mut free = vec![NONE; triangles.len()];
        let mut heap = BinaryHeap::with_capacity(triangles.len());
        for (triangle, &[a, b, c]) in numbered() {
            let beside = [across(a, b), across(b, c), across(c, a)];
            let count = beside.into_iter().filter(|&other| other != NONE).count();
            neighbours[triangle as usize] = beside;
            free[triangle as usize] = index_u32(count);
            heap.push(Reverse((index_u32(count), triangle)));
        }
        Self {
            triangles,
            neighbours,
            free,
            heap,
            passed: vec![0; triangles.len()],
            walk: 0,
        }
    }

    /// Where the next strip begins.
    fn first(&mut self) -> Option<u32> {
        loop {
            let Reverse((count, triangle)) = self.heap.pop()?;
            if self.free[triangle as usize] == count {
                return Some(triangle);
            }
        }
    }

    /// How many triangles a walk passes that begins at a corner of a triangle.
    fn length(&mut self, first: u32, corner: usize) -> u32 {
        self.walk += 1;
        let mut length = 1;
        let mut place = self.begin(first, corner);
        self.passed[first as usize] = self.walk;
        while let Some(next) = self.next(place) {
            self.passed[next.triangle as usize] = self.walk;
            place = next;
            length += 1;
        }
        length
    }

    /// Puts a walk's triangles into a strip.
    fn walk(&mut self, first: u32, corner: usize, strips: &mut Strips) {
        self.walk += 1;
        let corners = self.triangles[first as usize];
        strips
            .vertices
            .extend([0, 1, 2].map(|turn| corners[(corner + turn) % 3]));
        let mut place = Some(self.begin(first, corner));
        while let Some(at) = place {
            self.take(at.triangle, strips);
            place = self.next(at);
            if let Some(next) = place {
                strips.vertices.push(next.last[1]);
            }
        }
    }

    fn take(&mut self, triangle: u32, strips: &mut Strips) {
        strips.triangles.push(triangle);
        self.free[triangle as usize] = NONE;
        for other in self.neighbours[triangle as usize] {
            if other != NONE && self.free[other as usize] != NONE {
                // Neighbours may not agree that they are, where more than two share an edge.
                let free = &mut self.free[other as usize];
                *free = free.saturating_sub(1);
                self.heap.push(Reverse((*free, other)));
            }
        }
    }

    fn begin(&self, triangle: u32, corner: usize) -> Place {
        let corners = self.triangles[triangle as usize];
        let last = [corners[(corner + 1) % 3], corners[(corner + 2) % 3]];
        Place { triangle, last }
    }

    /// Over the last edge.
    fn next(&self, Place { triangle, last }: Place) -> Option<Place> {
        let corners = self.triangles[triangle as usize];
        let leaves = |&corner: &usize| {
            last.contains(&corners[corner]) && last.contains(&corners[(corner + 1) % 3])
        };
        let triangle = self.neighbours[triangle as usize][(0..3).find(leaves)?];
        let fits = triangle != NONE
            && self.free[triangle as usize] != NONE
            && self.passed[triangle as usize] != self.walk;
        if !fits {
            return None;
        }
        let corners = self.triangles[triangle as usize].into_iter();
        let mut others = corners.filter(|corner| !last.contains(corner));
        let new = others.next()?;
        Some(Place {
            triangle,
            last: [last[1], new],
        })
    }
}

/// A triangle on a walk, and the last two vertices of the strip.
#[derive(Debug, Clone, Copy)]
struct Place {
    triangle: u32,
    last: [u32; 2],
}

#[cfg(test)]
mod tests {
    use super::super::lowest_first;
    use super::*;

    fn check(triangles: &[[u32; 3]], strips: &Strips) {
        let mut seen = vec![0; triangles.len()];
        for (vertices, numbers) in strips.iter() {
            assert_eq!(vertices.len(), numbers.len() + 2);
            for (place, (window, &number)) in vertices.windows(3).zip(numbers).enumerate() {
                let [a, b, c] = [window[0], window[1], window[2]];
                let turned = if place % 2 == 0 { [a, b, c] } else { [b, a, c] };
                let wanted = triangles[number as usize];
                assert_eq!(lowest_first(turned), lowest_first(wanted));
                seen[number as usize] += 1;
            }
        }
        assert!(seen.iter().all(|&times| times == 1), "{seen:?}");
    }

    #[test]
    fn a_ribbon_is_one_strip_and_a_fan_some() {
        // As in the picture above.
        let ribbon = [[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5]];
        let strips = strips_of(&ribbon, |_| true);
        check(&ribbon, &strips);
        assert_eq!(strips.count(), 1);
        let fan = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 5, 1]];
        let strips = strips_of(&fan, |_| true);
        check(&fan, &strips);
        assert_eq!(strips.count(), 2);
    }

    #[test]
    fn triangles_that_are_not_wanted_are_in_no_strip() {
        let ribbon = [[0, 1, 2], [2, 1, 3], [2, 3, 4], [4, 3, 5]];
        let strips = strips_of(&ribbon, |triangle| triangle != 1);
        let numbers: Vec<&[u32]> = strips.iter().map(|(_, numbers)| numbers).collect();
        assert_eq!(numbers, [&[0][..], &[2, 3]]);
        assert_eq!(strips_of(&[], |_| true).count(), 0);
    }

    #[test]
    fn three_triangles_at_one_edge_are_all_there() {
        let book = [[0, 1, 2], [1, 0, 3], [1, 0, 4], [0, 1, 5]];
        check(&book, &strips_of(&book, |_| true));
    }
}
