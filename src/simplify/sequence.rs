//! The common product of leaf simplification: collapses in order, with replay and undo.

use crate::math::{Digest, Digester, index_u32};

/// One leaf collapse `(old1, old2) → new`; the new leaf's number follows from the position in the
/// sequence ([RRCGR](crate::references), eq. 1 and 2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Collapse {
    /// The two leaves that disappear.
    pub old: [u32; 2],
    /// What the simplifier paid, in its own unit; at least 0.
    pub cost: f32,
}

/// Leaf collapses over `L` original leaves: op `k` makes leaf `L + k`.
#[derive(Debug, Clone, PartialEq)]
pub struct CollapseSequence {
    original_count: u32,
    corners: Vec<[u32; 4]>,
    collapses: Vec<Collapse>,
}

impl CollapseSequence {
    /// A checked sequence.
    ///
    /// `corners` holds four vertex indices a leaf, in the order of corner roles: the originals', then
    /// one new leaf a collapse.
    ///
    /// # Errors
    ///
    /// When counts disagree, a collapse names a leaf that does not exist yet or is gone already, or
    /// a new leaf uses a vertex that neither of its operands has in that role.
    pub fn new(
        original_count: u32,
        corners: Vec<[u32; 4]>,
        collapses: Vec<Collapse>,
    ) -> Result<Self, SequenceError> {
        let wanted = original_count as usize + collapses.len();
        if corners.len() != wanted {
            return Err(SequenceError::Count {
                found: corners.len(),
                wanted,
            });
        }
        let mut gone = vec![false; corners.len()];
        for (op, collapse) in collapses.iter().enumerate() {
            let exists = original_count as usize + op;
            for old in collapse.old {
                if old as usize >= exists {
                    return Err(SequenceError::NotYet {
                        op,
                        leaf: old,
                        exists,
                    });
                }
                if std::mem::replace(&mut gone[old as usize], true) {
                    return Err(SequenceError::Gone { op, leaf: old });
                }
            }
            let [first, second] = collapse.old.map(|old| corners[old as usize]);
            for (role, &vertex) in corners[exists].iter().enumerate() {
                if vertex != first[role] && vertex != second[role] {
                    return Err(SequenceError::Corner { op, role, vertex });
                }
            }
        }
        Ok(Self {
            original_count,
            corners,
            collapses,
        })
    }

    /// How many leaves the full foliage has (`L`).
    #[must_use]
    pub fn original_count(&self) -> u32 {
        self.original_count
    }

    /// How many collapses there are (`C`).
    #[must_use]
    pub fn collapse_count(&self) -> u32 {
        index_u32(self.collapses.len())
    }

    /// How many leaves remain after all collapses (`G = L − C`): one a cluster.
    #[must_use]
    pub fn root_count(&self) -> u32 {
        self.original_count - self.collapse_count()
    }

    /// How many leaf records there are, old and new (`L + C`).
    #[must_use]
    pub fn record_count(&self) -> u32 {
        index_u32(self.corners.len())
    }

    /// The collapses in order.
    #[must_use]
    pub fn collapses(&self) -> &[Collapse] {
        &self.collapses
    }

    /// The corners of every leaf, old and new.
    #[must_use]
    pub fn corners(&self) -> &[[u32; 4]] {
        &self.corners
    }

    /// The leaf that op `op` makes.
    #[must_use]
    pub fn new_leaf(&self, op: u32) -> u32 {
        self.original_count + op
    }

    /// The visible leaves after the first `ops` collapses, ascending: the truth that every model's
    /// leaf set is held against.
    ///
    /// # Panics
    ///
    /// When `ops` exceeds the number of collapses.
    #[must_use]
    pub fn visible_after(&self, ops: u32) -> Vec<u32> {
        let exists = self.original_count + ops;
        let mut gone = vec![false; exists as usize];
        for collapse in &self.collapses[..ops as usize] {
            for old in collapse.old {
                gone[old as usize] = true;
            }
        }
        (0..exists).filter(|&leaf| !gone[leaf as usize]).collect()
    }

    /// The digest of the sequence: BLAKE3 over the domain `spinney.collapses/1`, `L` and `C` as
    /// `u32`, four `u32` a leaf record, two `u32` and the bits of the cost a collapse.
    #[must_use]
    pub fn digest(&self) -> Digest {
        let mut digester = Digester::new("spinney.collapses/1");
        digester.u32(self.original_count).u32(self.collapse_count());
        for &vertex in self.corners.iter().flatten() {
            digester.u32(vertex);
        }
        for collapse in &self.collapses {
            digester
                .u32(collapse.old[0])
                .u32(collapse.old[1])
                .f32(collapse.cost);
        }
        digester.finish()
    }
}

/// Why collapses do not make a sequence.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SequenceError {
    /// Not one record a leaf.
    #[error("{found} leaf records, wanted {wanted}: the originals and one a collapse")]
    Count {
        /// Records given.
        found: usize,
        /// Records that the counts ask for.
        wanted: usize,
    },
    /// A collapse consumes a leaf that is made later or never.
    #[error("collapse {op} consumes leaf {leaf}, but only {exists} leaves exist by then")]
    NotYet {
        /// Which collapse.
        op: usize,
        /// Which leaf.
        leaf: u32,
        /// How many leaves exist before this collapse.
        exists: usize,
    },
    /// A collapse consumes a leaf a second time.
    #[error("collapse {op} consumes leaf {leaf}, which is consumed already")]
    Gone {
        /// Which collapse.
        op: usize,
        /// Which leaf.
        leaf: u32,
    },
    /// A new leaf takes a vertex from elsewhere.
    #[error("collapse {op} gives role {role} vertex {vertex}, which neither old leaf has there")]
    Corner {
        /// Which collapse.
        op: usize,
        /// Which corner role.
        role: usize,
        /// The vertex found.
        vertex: u32,
    },
}

#[cfg(test)]
pub(crate) mod examples {
    //! The worked examples of both papers: 9 leaves, 6 collapses, 3 clusters.

    use super::{Collapse, CollapseSequence};

    /// Figure 6 of 001.
    pub(crate) const WSCG: [[u32; 2]; 6] = [[1, 2], [5, 6], [0, 9], [4, 10], [7, 8], [3, 12]];
    /// Figure 6 of 000.
    pub(crate) const FRAMEWORK: [[u32; 2]; 6] = [[0, 1], [2, 9], [5, 6], [7, 8], [3, 10], [4, 11]];

    /// A sequence over leaves with vertices `4 l .. 4 l + 4`; a new leaf takes its first two
    /// corners from old1, the others from old2.
    pub(crate) fn sequence(original_count: u32, ops: &[[u32; 2]]) -> CollapseSequence {
        let mut corners: Vec<[u32; 4]> = (0..original_count)
            .map(|leaf| [0, 1, 2, 3].map(|role| 4 * leaf + role))
            .collect();
        for &[first, second] in ops {
            let (a, b) = (corners[first as usize], corners[second as usize]);
            corners.push([a[0], a[1], b[2], b[3]]);
        }
        let collapses = ops.iter().map(|&old| Collapse { old, cost: 0.0 }).collect();
        CollapseSequence::new(original_count, corners, collapses).expect("examples are sound")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn worked_examples_replay() {
        let sequence = examples::sequence(9, &examples::WSCG);
        assert_eq!(sequence.visible_after(0), (0..9).collect::<Vec<_>>());
        assert_eq!(sequence.visible_after(3), [3, 4, 7, 8, 10, 11]);
        assert_eq!(sequence.visible_after(6), [11, 13, 14]);
        assert_eq!(sequence.root_count(), 3);
        let other = examples::sequence(9, &examples::FRAMEWORK);
        assert_eq!(other.visible_after(3), [3, 4, 7, 8, 10, 11]);
    }

    #[test]
    fn unsound_sequences_are_refused() {
        let leaf = |leaf: u32| [0, 1, 2, 3].map(|role| 4 * leaf + role);
        let collapse = |a, b| Collapse {
            old: [a, b],
            cost: 0.0,
        };
        let new =
            |corners: Vec<[u32; 4]>, ops: Vec<Collapse>| CollapseSequence::new(3, corners, ops);
        let three = || vec![leaf(0), leaf(1), leaf(2)];
        let with = |extra: &[[u32; 4]]| [three(), extra.to_vec()].concat();
        assert!(matches!(
            new(three(), vec![collapse(0, 1)]),
            Err(SequenceError::Count {
                found: 3,
                wanted: 4
            })
        ));
        assert!(matches!(
            new(with(&[[0, 1, 6, 7]]), vec![collapse(0, 3)]),
            Err(SequenceError::NotYet { leaf: 3, .. })
        ));
        assert!(matches!(
            new(with(&[[0, 1, 2, 3]]), vec![collapse(0, 0)]),
            Err(SequenceError::Gone { leaf: 0, .. })
        ));
        assert!(matches!(
            new(with(&[[0, 1, 2, 11]]), vec![collapse(0, 1)]),
            Err(SequenceError::Corner {
                role: 3,
                vertex: 11,
                ..
            })
        ));
    }
}
