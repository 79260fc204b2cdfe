//! What foliage models cost in memory, in closed form, beside what the papers print.
//!
//! ```text
//!                 vertices      leaves       links, clusters, Changed_groups    device blocks
//!  original        12 V        16 L
//!  VDF             12 V        28 (L + C)
//!  LoDF, words     12 V        24 (L + C)    4 L
//!  LoDF, structs   12 V        24 (L + C)    4 C + 12 G                          16 L
//!  LoDF, printed            79 L                                                 16.1 L
//! ```
//!
//! `L` originals and `C` collapses make `V = 4 L` vertices, `L + C` leaf records and `G = L − C`
//! clusters. Where collapses add `A` vertices, as [pruning](super::prune_leaves) does, `V = 4 L + A` in
//! all rows but the first: 12 bytes each, also on top of what is printed. The first two rows give the papers' tables to the printed digit; the structures that
//! the papers list give a quarter more than the sizes that they print, so reports show
//! both. All arithmetic is in integers.

use super::CollapseSequence;
use crate::math::index_u32;

/// How much foliage a model stores.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StorageCounts {
    /// Original leaves, `L`.
    pub leaves: u32,
    /// Collapses, `C`; below `L` unless both are 0.
    pub collapses: u32,
    /// Vertices that collapses add, `A`.
    pub added_vertices: u32,
}

impl StorageCounts {
    /// The counts of a sequence.
    #[must_use]
    pub fn of(sequence: &CollapseSequence) -> Self {
        Self {
            leaves: sequence.original_count(),
            collapses: sequence.collapse_count(),
            added_vertices: index_u32(sequence.added_vertices().len()),
        }
    }

    /// `V = 4 L + A`; in the papers no collapse makes a vertex ([RCRG06](crate::references), eq. 3 and
    /// 4).
    #[must_use]
    pub fn vertices(self) -> u64 {
        4 * u64::from(self.leaves) + u64::from(self.added_vertices)
    }

    /// Leaf records, old and new: `L + C`.
    #[must_use]
    pub fn records(self) -> u64 {
        u64::from(self.leaves) + u64::from(self.collapses)
    }

    /// `G = L − C`.
    #[must_use]
    pub fn clusters(self) -> u64 {
        u64::from(self.leaves.saturating_sub(self.collapses))
    }
}

/// Bytes an original leaf that the papers' tables of LoDF come to when it is not
/// hardware-oriented, as a ratio.
///
/// Empirical: it fits all ten rows of Tables III and IV of [RRCGR](crate::references) that are not
/// corrupt, and follows from no structure that the papers list.
pub const PRINTED_LODF_BYTES: [u64; 2] = [79, 1];

/// The same for the hardware-oriented LoDF of Table V: all eight rows that are not corrupt.
///
/// What it has more is, but for a tenth of a byte, the device's `16 L` bytes of leaf indices.
pub const PRINTED_LODF_HARDWARE_BYTES: [u64; 2] = [951, 10];

/// A way to count the bytes of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Accounting {
    /// The leaves as they are: 12 B a vertex, 16 B a leaf.
    Original,
    /// View-dependent foliage: 12 B a vertex, 28 B (seven words) a record.
    Vdf,
    /// LoDF, not hardware-oriented, by what the papers print: [`PRINTED_LODF_BYTES`].
    LodfPrinted,
    /// LoDF, hardware-oriented, by what the papers print: [`PRINTED_LODF_HARDWARE_BYTES`].
    LodfHardwarePrinted,
    /// LoDF by words of 4 B: three a vertex, six a record, one an original leaf
    /// ([RCRG06](crate::references), eq. 8).
    LodfWords,
    /// LoDF, not hardware-oriented, by the structures that [RRCGR](crate::references) lists: 12 B a
    /// vertex, 16 B a record for its corners and 8 B for its list entry, 4 B a collapse, 12 B a
    /// cluster.
    LodfStructures,
    /// The same with the device's blocks, 16 B an original leaf: each cluster's block must hold all
    /// of its originals.
    LodfHardwareStructures,
}

impl Accounting {
    /// All of them, in the order of tables.
    pub const ALL: [Self; 7] = [
        Self::Original,
        Self::Vdf,
        Self::LodfPrinted,
        Self::LodfHardwarePrinted,
        Self::LodfWords,
        Self::LodfStructures,
        Self::LodfHardwareStructures,
    ];

    /// A short name for tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Original => "original",
            Self::Vdf => "VDF",
            Self::LodfPrinted => "LoDF (printed)",
            Self::LodfHardwarePrinted => "LoDF on hardware (printed)",
            Self::LodfWords => "LoDF (words)",
            Self::LodfStructures => "LoDF (structures)",
            Self::LodfHardwareStructures => "LoDF on hardware (structures)",
        }
    }

    /// Bytes; ratios are rounded to the nearest byte.
    #[must_use]
    pub fn bytes(self, counts: StorageCounts) -> u64 {
        let leaves = u64::from(counts.leaves);
        let collapses = u64::from(counts.collapses);
        let vertex_bytes = 12 * counts.vertices();
        let added_bytes = 12 * u64::from(counts.added_vertices);
        let printed = |[bytes, of]: [u64; 2]| (bytes * leaves + of / 2) / of + added_bytes;
        match self {
            Self::Original => (12 * 4 + 16) * leaves,
            Self::Vdf => vertex_bytes + 28 * counts.records(),
            Self::LodfPrinted => printed(PRINTED_LODF_BYTES),
            Self::LodfHardwarePrinted => printed(PRINTED_LODF_HARDWARE_BYTES),
            Self::LodfWords => 4 * (3 * counts.vertices() + 6 * counts.records() + leaves),
            Self::LodfStructures => {
                let records = (16 + 8) * counts.records();
                vertex_bytes + records + 4 * collapses + 12 * counts.clusters()
            }
            Self::LodfHardwareStructures => Self::LodfStructures.bytes(counts) + 16 * leaves,
        }
    }
}

/// Hundredths of a MiB, the unit of the papers' tables, rounded to the nearest.
#[must_use]
pub fn mebibyte_hundredths(bytes: u64) -> u64 {
    // Whole MiB first, so that no product overflows.
    let (whole, rest) = (bytes >> 20, bytes & ((1 << 20) - 1));
    100 * whole + ((100 * rest + (1 << 19)) >> 20)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_listed_structures_cost_a_quarter_more_than_printed() {
        let taxus = StorageCounts {
            leaves: 48_160,
            collapses: 47_520,
            added_vertices: 0,
        };
        let mebibytes = |accounting: Accounting| mebibyte_hundredths(accounting.bytes(taxus));
        assert_eq!(taxus.clusters(), 640);
        assert_eq!(mebibytes(Accounting::LodfPrinted), 363);
        assert_eq!(mebibytes(Accounting::LodfStructures), 458);
        assert_eq!(mebibytes(Accounting::LodfHardwareStructures), 532);
        // 6.25 words a vertex when all but one leaf are collapsed.
        let all = StorageCounts {
            leaves: 1_000_000,
            collapses: 999_999,
            added_vertices: 0,
        };
        assert_eq!(Accounting::LodfWords.bytes(all) / all.vertices(), 24);
        assert_eq!(Accounting::LodfWords.bytes(all) + 24, 25 * all.vertices());
    }

    #[test]
    fn what_collapses_add_counts_in_all_but_the_original() {
        let without = StorageCounts {
            leaves: 10,
            collapses: 8,
            added_vertices: 0,
        };
        let with = StorageCounts {
            added_vertices: 32,
            ..without
        };
        for accounting in Accounting::ALL {
            let more = accounting.bytes(with) - accounting.bytes(without);
            let wanted = if accounting == Accounting::Original {
                0
            } else {
                12 * 32
            };
            assert_eq!(more, wanted, "{accounting:?}");
        }
    }

    #[test]
    fn the_largest_counts_do_not_overflow() {
        let counts = StorageCounts {
            leaves: u32::MAX,
            collapses: u32::MAX,
            added_vertices: u32::MAX,
        };
        for accounting in Accounting::ALL {
            assert!(
                accounting.bytes(counts) > u64::from(u32::MAX),
                "{accounting:?}"
            );
        }
        assert_eq!(mebibyte_hundredths(u64::MAX), 1_759_218_604_441_600);
    }
}
