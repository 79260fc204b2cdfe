//! Lines as they wait for their tiles: records of words, one after the other.
//!
//! There are millions of them, written once and read once, so what they take is what they cost. Where all
//! lines of a chunk are short and the same from end to end, records are half as long.

use std::ops::Range;

use super::MAX_VARYINGS;
use super::view::{PixelBox, View};

/// A line on the target, its ends in the order of their vertex ids.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    /// The corners of its rectangle, of which p-q-r and p-r-s are counter-clockwise to the eye: the first
    /// and the last lie at the first end.
    pub(super) x: [i32; 4],
    pub(super) y: [i32; 4],
    /// Depth at the ends.
    pub(super) depth: [f32; 2],
    /// One over `w` at the ends.
    pub(super) inverse_w: [f32; 2],
    /// The primitive within the part's geometry; 0 where no flats are told by it.
    pub(super) primitive: u32,
}

impl Line {
    /// The pixels with a sample within the rectangle's box.
    #[inline(always)]
    pub(super) fn pixels(&self, view: &View) -> Option<PixelBox> {
        view.pixels(range(self.x), range(self.y))
    }

    /// From the first corner to another one, as one word, if it is short.
    #[inline(always)]
    fn way(&self, corner: usize) -> Option<u32> {
        let x = i16::try_from(self.x[corner] - self.x[0]).ok()?;
        let y = i16::try_from(self.y[corner] - self.y[0]).ok()?;
        Some(u32::from(y.cast_unsigned()) << 16 | u32::from(x.cast_unsigned()))
    }
}

/// The least and the greatest.
#[inline(always)]
pub(super) fn range([a, b, c, d]: [i32; 4]) -> [i32; 2] {
    [a.min(b).min(c.min(d)), a.max(b).max(c.max(d))]
}

/// The bits of the varyings of both ends of a line; those beyond the kernel's are 0.
pub(super) type Ends = [[u32; MAX_VARYINGS]; 2];

/// The lines of some parts.
///
/// A line takes 13 words, those of [`Line`] in their order, and the varyings of its ends, those of the first
/// before those of the second. An [even](Self::are_even) one takes 7: the first corner, the ways from there
/// to the others, depth and one over `w`, and the varyings of one end. After the last line there are
/// [`MAX_VARYINGS`] words more, so that lanes may read on.
#[derive(Debug, Default)]
pub(super) struct Lines {
    words: Vec<u32>,
    count: usize,
    varyings: usize,
    even: bool,
}

/// Words of a [`Line`].
const WORDS: usize = 13;

/// Words of an even line.
const EVEN_WORDS: usize = 7;

impl Lines {
    /// None yet, with so many varyings each end, and room for some; whether they have flats is told.
    pub(super) fn new(varyings: usize, flats: usize, room: usize) -> Self {
        let mut lines = Self {
            words: Vec::new(),
            count: 0,
            varyings,
            even: flats == 0,
        };
        lines.words.reserve(room * lines.stride() + MAX_VARYINGS);
        lines
    }

    /// Lanes may read on after the last one.
    pub(super) fn end(&mut self) {
        self.words.extend([0; MAX_VARYINGS]);
    }

    /// How many there are.
    #[inline(always)]
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// How many floats each end has.
    #[inline(always)]
    pub(super) fn varyings_each(&self) -> usize {
        self.varyings
    }

    /// Whether each is the same from end to end, in depth, `w` and varyings, none of these less than 0: so
    /// what is interpolated is what is at the ends, to the same bits, wherever a pixel is covered.
    #[inline(always)]
    pub(super) fn are_even(&self) -> bool {
        self.even
    }

    /// About how many bytes they take.
    pub(super) fn bytes(&self) -> u64 {
        (self.words.len() * size_of::<u32>()) as u64
    }

    /// Words a line.
    #[inline(always)]
    fn stride(&self) -> usize {
        stride(self.even, self.varyings)
    }

    /// One of them; `varyings` says how many floats each end has, as the kernel does.
    #[inline(always)]
    pub(super) fn line(&self, place: usize, varyings: usize) -> Line {
        let first = place * stride(self.even, varyings);
        if self.even {
            even_line(&self.words[first..])
        } else {
            line(&self.words[first..])
        }
    }

    /// The bits of the varyings of both ends of a line, as many as there can be; those beyond the line's mean
    /// nothing.
    #[inline(always)]
    pub(super) fn varyings(&self, place: usize, varyings: usize) -> [&[u32]; 2] {
        let first = place * stride(self.even, varyings);
        let places = if self.even {
            [first + EVEN_WORDS; 2]
        } else {
            [first + WORDS, first + WORDS + varyings]
        };
        places.map(|place| &self.words[place..][..MAX_VARYINGS])
    }

    /// Reads some of them, so that they are at hand soon.
    #[inline(always)]
    pub(super) fn fetch(&self, places: Range<usize>) -> u32 {
        /// Words that come together.
        const AT_ONCE: usize = 16;
        let stride = self.stride();
        let words = self.words.get(places.start * stride..places.end * stride);
        let words = words.unwrap_or(&[]).iter().step_by(AT_ONCE);
        words.fold(0, |read, word| read ^ word)
    }

    /// One more.
    #[inline(always)]
    pub(super) fn push(&mut self, line: &Line, ends: &Ends) {
        if self.even {
            if self.push_even(line, ends) {
                return;
            }
            self.lengthen();
        }
        let [x, y] = [line.x, line.y].map(|c| c.map(i32::cast_unsigned));
        self.words.extend_from_slice(&[
            x[0],
            x[1],
            x[2],
            x[3],
            y[0],
            y[1],
            y[2],
            y[3],
            line.depth[0].to_bits(),
            line.depth[1].to_bits(),
            line.inverse_w[0].to_bits(),
            line.inverse_w[1].to_bits(),
            line.primitive,
        ]);
        for end in ends {
            self.words.extend_from_slice(&end[..self.varyings]);
        }
        self.count += 1;
    }

    /// One more, if it is short and even.
    #[inline(always)]
    fn push_even(&mut self, line: &Line, [one, other]: &Ends) -> bool {
        /// Greater varyings may be infinite once they are divided by `w`.
        const GREATEST: u32 = 1e25_f32.to_bits();
        let same = [line.depth, line.inverse_w].map(|[a, b]| a.to_bits() == b.to_bits());
        let greatest = one.iter().fold(0, |most, &bits| most.max(bits));
        // Bits of numbers that are less than 0 or none at all are greater.
        if same != [true; 2] || one != other || greatest > GREATEST {
            return false;
        }
        let (Some(q), Some(r), Some(s)) = (line.way(1), line.way(2), line.way(3)) else {
            return false;
        };
        self.words.extend_from_slice(&[
            line.x[0].cast_unsigned(),
            line.y[0].cast_unsigned(),
            q,
            r,
            s,
            line.depth[0].to_bits(),
            line.inverse_w[0].to_bits(),
        ]);
        self.words.extend_from_slice(&one[..self.varyings]);
        self.count += 1;
        true
    }

    /// Writes all once more, each as long as it may be.
    #[cold]
    #[inline(never)]
    fn lengthen(&mut self) {
        let mut long = Self {
            words: Vec::new(),
            count: 0,
            varyings: self.varyings,
            even: false,
        };
        let room = self.words.capacity() / self.stride();
        long.words.reserve(room * long.stride() + MAX_VARYINGS);
        for words in self.words.chunks_exact(self.stride()) {
            let mut end = [0; MAX_VARYINGS];
            end[..self.varyings].copy_from_slice(&words[EVEN_WORDS..]);
            long.push(&even_line(words), &[end; 2]);
        }
        *self = long;
    }
}

#[inline(always)]
fn stride(even: bool, varyings: usize) -> usize {
    if even {
        EVEN_WORDS + varyings
    } else {
        WORDS + 2 * varyings
    }
}

#[inline(always)]
fn line(words: &[u32]) -> Line {
    let words = &words[..WORDS];
    let corner = |first: usize| {
        [
            words[first].cast_signed(),
            words[first + 1].cast_signed(),
            words[first + 2].cast_signed(),
            words[first + 3].cast_signed(),
        ]
    };
    let float = |word: usize| f32::from_bits(words[word]);
    Line {
        x: corner(0),
        y: corner(4),
        depth: [float(8), float(9)],
        inverse_w: [float(10), float(11)],
        primitive: words[12],
    }
}

#[inline(always)]
fn even_line(words: &[u32]) -> Line {
    let words = &words[..EVEN_WORDS];
    let [x, y] = [words[0].cast_signed(), words[1].cast_signed()];
    // The lower half with its sign, and the upper one.
    let across = |way: u32| x + ((way << 16).cast_signed() >> 16);
    let down = |way: u32| y + (way.cast_signed() >> 16);
    let [q, r, s] = [words[2], words[3], words[4]];
    Line {
        x: [x, across(q), across(r), across(s)],
        y: [y, down(q), down(r), down(s)],
        depth: [f32::from_bits(words[5]); 2],
        inverse_w: [f32::from_bits(words[6]); 2],
        primitive: 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn even(at: i32) -> (Line, Ends) {
        let line = Line {
            x: [at, at + 300, at + 290, at - 10],
            y: [-at, -at - 700, 20 - at, 720 - at],
            depth: [0.25; 2],
            inverse_w: [0.5; 2],
            primitive: 0,
        };
        let mut end = [0; MAX_VARYINGS];
        end[..3].copy_from_slice(&[0.0, 0.75, 1e20_f32].map(f32::to_bits));
        (line, [end; 2])
    }

    fn check(lines: &Lines, pushed: &[(Line, Ends)]) {
        assert_eq!(lines.count(), pushed.len());
        for (place, (line, ends)) in pushed.iter().enumerate() {
            assert_eq!(lines.line(place, 3), *line);
            let found = lines.varyings(place, 3).map(|end| &end[..3]);
            assert_eq!(found, [&ends[0][..3], &ends[1][..3]]);
        }
    }

    #[test]
    fn short_records_become_long_ones_when_one_must_be() {
        let uneven = [
            |line: &mut Line, _: &mut Ends| line.depth[1] = 0.5,
            |line: &mut Line, _: &mut Ends| line.inverse_w[0] = 0.25,
            |line: &mut Line, _: &mut Ends| line.x[2] = line.x[0] + 40_000,
            |_: &mut Line, ends: &mut Ends| ends[1][1] = 0,
            |_: &mut Line, ends: &mut Ends| *ends = [[(-0.0_f32).to_bits(); MAX_VARYINGS]; 2],
            |_: &mut Line, ends: &mut Ends| *ends = [[f32::NAN.to_bits(); MAX_VARYINGS]; 2],
        ];
        for change in uneven {
            let mut lines = Lines::new(3, 0, 4);
            let mut pushed = vec![even(70_000), even(-3)];
            for (line, ends) in &pushed {
                lines.push(line, ends);
            }
            assert!(lines.are_even() && lines.words.len() == 2 * (EVEN_WORDS + 3));
            let (mut line, mut ends) = even(9);
            change(&mut line, &mut ends);
            lines.push(&line, &ends);
            pushed.push((line, ends));
            let (line, ends) = even(12);
            lines.push(&line, &ends);
            pushed.push((line, ends));
            lines.end();
            assert!(!lines.are_even());
            check(&lines, &pushed);
        }
        let mut lines = Lines::new(3, 0, 0);
        lines.push(&even(5).0, &even(5).1);
        lines.end();
        check(&lines, &[even(5)]);
        assert!(
            !Lines::new(3, 1, 0).are_even(),
            "a flat is told by its primitive"
        );
    }
}
