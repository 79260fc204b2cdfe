//! The common product of leaf simplification: collapses in order, with replay and undo.

use crate::math::{Digest, Digester, Vec3, index_u32};

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
///
/// Vertices are numbered four a leaf:
///
/// ```text
///  0 … 4 L              4 L …
///  original leaves'     added: four of its own for each new leaf that has such
/// ```
///
/// A new leaf takes each corner from one of its operands, or brings four vertices of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct CollapseSequence {
    original_count: u32,
    corners: Vec<[u32; 4]>,
    collapses: Vec<Collapse>,
    added: Vec<Vec3>,
    owners: Vec<Owner>,
}

/// Whose four added vertices are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Owner {
    /// The new leaf that brings them.
    leaf: u32,
    /// The original leaf that is left of it.
    original: u32,
}

impl CollapseSequence {
    /// A checked sequence whose new leaves take all their corners from their operands.
    ///
    /// # Errors
    ///
    /// As [`with_vertices`](Self::with_vertices).
    pub fn new(
        original_count: u32,
        corners: Vec<[u32; 4]>,
        collapses: Vec<Collapse>,
    ) -> Result<Self, SequenceError> {
        Self::with_vertices(original_count, corners, collapses, Vec::new())
    }

    /// A checked sequence.
    ///
    /// `corners` holds four vertex indices a leaf, in the order of corner roles: the originals', then
    /// one new leaf a collapse. `added` holds the vertices that collapses add, numbered from
    /// `4 L` on, in the originals' space; a leaf that brings some is a changed `old[0]`.
    ///
    /// # Errors
    ///
    /// When counts disagree, a collapse names a leaf that does not exist yet or is gone already, an
    /// original leaf uses a vertex that is none of the originals', or a new leaf uses one that neither
    /// of its operands has in that role and that is not one of four of its own; when added vertices
    /// are not finite, or are no leaf's.
    pub fn with_vertices(
        original_count: u32,
        corners: Vec<[u32; 4]>,
        collapses: Vec<Collapse>,
        added: Vec<Vec3>,
    ) -> Result<Self, SequenceError> {
        let wanted = original_count as usize + collapses.len();
        if corners.len() != wanted {
            return Err(SequenceError::Count {
                found: corners.len(),
                wanted,
            });
        }
        let first_added = 4 * u64::from(original_count);
        for (leaf, own) in (0..original_count).zip(&corners) {
            if let Some(&vertex) = own.iter().find(|&&vertex| u64::from(vertex) >= first_added) {
                return Err(SequenceError::Original { leaf, vertex });
            }
        }
        if let Some(vertex) = added.iter().position(|vertex| !vertex.is_finite()) {
            return Err(SequenceError::NotFinite { vertex });
        }
        let mut owners = vec![None; added.len().div_ceil(4)];
        // By leaf: the original that is left of it.
        let mut left: Vec<u32> = (0..original_count).collect();
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
            left.push(left[collapse.old[0] as usize]);
            let own = own_block(corners[exists], first_added);
            let free = own.and_then(|block| owners.get_mut(block));
            if let Some(free @ None) = free {
                *free = Some(Owner {
                    leaf: index_u32(exists),
                    original: left[exists],
                });
                continue;
            }
            let [first, second] = collapse.old.map(|old| corners[old as usize]);
            for (role, &vertex) in corners[exists].iter().enumerate() {
                if vertex != first[role] && vertex != second[role] {
                    return Err(SequenceError::Corner { op, role, vertex });
                }
            }
        }
        let owned = owners.iter().flatten().count();
        if 4 * owned != added.len() {
            return Err(SequenceError::Added {
                found: added.len(),
                wanted: 4 * owned,
            });
        }
        Ok(Self {
            original_count,
            corners,
            collapses,
            added,
            owners: owners.into_iter().flatten().collect(),
        })
    }

    /// The vertices that collapses add, numbered from `4 L` on: four for each leaf that has its own.
    #[must_use]
    pub fn added_vertices(&self) -> &[Vec3] {
        &self.added
    }

    /// The leaf, old or new, that brings a vertex.
    ///
    /// # Panics
    ///
    /// When there is no such vertex.
    #[must_use]
    pub fn leaf_of_vertex(&self, vertex: u32) -> u32 {
        let leaf = vertex / 4;
        let added = leaf.checked_sub(self.original_count);
        added.map_or(leaf, |block| self.owners[block as usize].leaf)
    }

    /// The original leaf that a vertex is of: the one that brings it, or what is left of in the new
    /// leaf that brings it, which is `old[0]` at each collapse.
    ///
    /// # Panics
    ///
    /// When there is no such vertex.
    #[must_use]
    pub fn original_of_vertex(&self, vertex: u32) -> u32 {
        let leaf = vertex / 4;
        let added = leaf.checked_sub(self.original_count);
        added.map_or(leaf, |block| self.owners[block as usize].original)
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
    /// `u32`, four `u32` a leaf record, two `u32` and the bits of the cost a collapse; where collapses
    /// add vertices, the domain is `spinney.collapses/2`, and their three `f32` each come last.
    #[must_use]
    pub fn digest(&self) -> Digest {
        let mut digester = Digester::new(if self.added.is_empty() {
            "spinney.collapses/1"
        } else {
            "spinney.collapses/2"
        });
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
        for vertex in &self.added {
            digester.vec3(*vertex);
        }
        digester.finish()
    }
}

/// Which four added vertices, in order, a leaf's corners are; `None` if not such.
fn own_block(corners: [u32; 4], first_added: u64) -> Option<usize> {
    let first = u64::from(corners[0]).checked_sub(first_added)?;
    let in_order = (0..4)
        .zip(corners)
        .all(|(role, vertex)| u64::from(vertex) == first_added + first + role);
    usize::try_from(first / 4)
        .ok()
        .filter(|_| in_order && first % 4 == 0)
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
    /// An original leaf has a corner that is none of the originals' vertices.
    #[error("original leaf {leaf} has vertex {vertex}, which is no original leaf's")]
    Original {
        /// Which leaf.
        leaf: u32,
        /// The vertex found.
        vertex: u32,
    },
    /// A vertex that collapses add is not finite.
    #[error("added vertex {vertex} is not finite")]
    NotFinite {
        /// Which one, from 0.
        vertex: usize,
    },
    /// There are other added vertices than those of new leaves.
    #[error("{found} added vertices, wanted {wanted}: four for each new leaf that has its own")]
    Added {
        /// Vertices given.
        found: usize,
        /// Vertices that new leaves have.
        wanted: usize,
    },
    /// A new leaf takes a vertex from elsewhere.
    #[error(
        "collapse {op} gives role {role} vertex {vertex}, which neither old leaf has there, nor the new \
         one alone"
    )]
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

    #[test]
    fn new_leaves_may_bring_vertices() {
        let collapse = |a, b| Collapse {
            old: [a, b],
            cost: 0.0,
        };
        let block = |block: u32| [0, 1, 2, 3].map(|role| 4 * block + role);
        // Leaf 3 is a changed leaf 1 with block 4, leaf 4 a changed leaf 3 with block 3.
        let corners = || (0..3).chain([4, 3]).map(block).collect::<Vec<_>>();
        let collapses = || vec![collapse(1, 0), collapse(3, 2)];
        let added = |count: u8| {
            (0..count)
                .map(|at| Vec3::splat(at.into()))
                .collect::<Vec<_>>()
        };
        let with = |corners, added| CollapseSequence::with_vertices(3, corners, collapses(), added);
        let sequence = with(corners(), added(8)).expect("sound");
        assert_eq!(sequence.added_vertices()[5], Vec3::splat(5.0));
        let vertices = [0, 7, 11, 12, 15, 16, 19];
        let leaves = vertices.map(|vertex| sequence.leaf_of_vertex(vertex));
        assert_eq!(leaves, [0, 1, 2, 4, 4, 3, 3]);
        let originals = vertices.map(|vertex| sequence.original_of_vertex(vertex));
        assert_eq!(originals, [0, 1, 2, 1, 1, 1, 1]);
        let mut moved = added(8);
        moved[7].x = 9.0;
        let moved_digest = with(corners(), moved).expect("sound").digest();
        assert_ne!(moved_digest, sequence.digest());

        let mut endless = added(8);
        endless[2].y = f32::INFINITY;
        let found = with(corners(), endless);
        assert!(matches!(found, Err(SequenceError::NotFinite { vertex: 2 })));
        for count in [7, 9, 12] {
            let found = with(corners(), added(count));
            let wanted = matches!(found, Err(SequenceError::Added { wanted: 8, .. }));
            assert!(wanted, "{count}: {found:?}");
        }
        let changed = |leaf: usize, wanted: [u32; 4]| {
            let mut corners = corners();
            corners[leaf] = wanted;
            with(corners, added(8))
        };
        for wanted in [
            block(3),
            [17, 18, 19, 16],
            [16, 1, 2, 3],
            block(5),
            [u32::MAX; 4],
        ] {
            let found = changed(3, wanted);
            assert!(found.is_err(), "{wanted:?}: {found:?}");
        }
        let found = changed(2, block(3));
        assert!(matches!(
            found,
            Err(SequenceError::Original {
                leaf: 2,
                vertex: 12
            })
        ));
    }
}
