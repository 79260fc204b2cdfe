//! What stands in for leaves where a model draws cards, with all its options.

use super::DetailRange;
use crate::document::choices;
use crate::limits;

choices! {
    /// Which depth a texel of an impostor has.
    CardDepth {
        /// That of the impostor's plane ([GSS05](crate::references), § 1).
        Paper = "paper",
        /// The plane's, and how far the leaf lies from it, a texel.
        Relief = "relief",
    }
}

choices! {
    /// What texels do that a leaf covers in part.
    Transparency {
        /// They show wholly or not at all.
        Test = "test",
        /// They mix with what is behind, drawn from back to front.
        Blend = "blend",
        /// They take as many of a pixel's samples as they cover.
        Coverage = "coverage",
    }
}

choices! {
    /// The outline of an impostor.
    CardOutline {
        /// The rectangle around its leaves ([GSS05](crate::references), § 2).
        Quad = "quad",
        /// At most eight corners around what is opaque.
        Trimmed = "trimmed",
    }
}

choices! {
    /// Which sides of an impostor have a texture of their own.
    CardSides {
        /// Front and back: from behind, leaves hide each other the other way round.
        Both = "both",
        /// The front, which is seen from behind too.
        Front = "front",
    }
}

choices! {
    /// How large leaves are where an impostor's texture only says where they lie.
    SpriteScale {
        /// All of one size ([GSS05](crate::references), § 2.3).
        Global = "global",
        /// Each has its own.
        Leaf = "leaf",
    }
}

choices! {
    /// What the textures of cards that stand for trees far away hold.
    CardMode {
        /// A picture each.
        Direct = "direct",
        /// A map of leaves each, and pictures of one leaf.
        Indirect = "indirect",
    }
}

/// Cards that stand for the leaves of trees far away, beside a model of leaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FarCards {
    /// What their textures hold.
    pub mode: CardMode,
    /// Trees whose crown's centre is farther away than the first show cards at the finest level, from the
    /// second on at the coarsest.
    pub range: DetailRange,
}

/// How cards are made and drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CardOptions {
    /// How many impostors stand for a crown, level by level.
    pub levels: CardCounts,
    /// The sides of an impostor's texture, in texels.
    pub texture: u32,
    /// What a leaf's turn out of its plane weighs against its distance: α of
    /// [GSS05](crate::references), eq. 1, as a share of the crown's mean square radius.
    pub orientation_weight: f32,
    /// How many first choices of planes are tried.
    pub plane_seeds: u32,
    /// Which depth texels have.
    pub depth: CardDepth,
    /// What texels do that are covered in part.
    pub transparency: Transparency,
    /// What is drawn of an impostor.
    pub outline: CardOutline,
    /// Which sides have textures.
    pub sides: CardSides,
    /// The sides of a leaf distribution map, in texels.
    pub map: u32,
    /// How many leaves a texel of it may have: each costs a read.
    pub layers: u32,
    /// How many turned pictures of a leaf there are.
    pub sprites: u32,
    /// Their sides, in texels.
    pub sprite_texture: u32,
    /// How large leaves are in it.
    pub scale: SpriteScale,
    /// From where on they stand for leaves, where the model draws leaves.
    pub far: Option<FarCards>,
}

impl CardOptions {
    /// The most that [`layers`](Self::layers) may be.
    pub const MOST_LAYERS: u32 = 256;

    /// What holds where a scene says nothing: direct textures as [GSS05](crate::references) has them.
    pub const USUAL: Self = Self {
        levels: CardCounts::USUAL,
        texture: 512,
        orientation_weight: 0.03,
        plane_seeds: 4,
        depth: CardDepth::Paper,
        transparency: Transparency::Test,
        outline: CardOutline::Quad,
        sides: CardSides::Both,
        map: 64,
        layers: 8,
        sprites: 32,
        sprite_texture: 64,
        scale: SpriteScale::Global,
        far: None,
    };
}

/// How many impostors stand for a crown, level by level: each level has fewer than the one before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CardCounts {
    /// Zeros behind the last level.
    counts: [u32; limits::CARD_LEVELS],
    levels: usize,
}

impl CardCounts {
    /// 32, 16 and 8, as in [GSS05](crate::references), § 3.
    pub const USUAL: Self = Self {
        counts: [32, 16, 8, 0, 0, 0, 0, 0],
        levels: 3,
    };

    /// One to [`CARD_LEVELS`](limits::CARD_LEVELS) numbers from [`CARDS`](limits::CARDS) down to 1, each
    /// less than the one before; else `None`.
    #[must_use]
    pub fn new(given: &[u32]) -> Option<Self> {
        let fits = given.first().is_some_and(|&most| most <= limits::CARDS)
            && given.last().is_some_and(|&least| least > 0)
            && given.is_sorted_by(|before, after| before > after);
        let mut counts = [0; limits::CARD_LEVELS];
        let room = counts.get_mut(..given.len()).filter(|_| fits)?;
        room.copy_from_slice(given);
        Some(Self {
            counts,
            levels: given.len(),
        })
    }

    /// So many, half and a quarter of them, as far as these are at least 1.
    #[must_use]
    pub fn halved_from(most: u32) -> Option<Self> {
        let halves = [most, most / 2, most / 4];
        let levels = halves.iter().take_while(|&&count| count > 0).count();
        Self::new(&halves[..levels])
    }

    /// The numbers, the finest level's first.
    #[must_use]
    pub fn as_slice(&self) -> &[u32] {
        &self.counts[..self.levels]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_descend_and_end_above_nothing() {
        assert_eq!(CardCounts::new(&[32, 16, 8]), Some(CardCounts::USUAL));
        assert_eq!(CardCounts::halved_from(32), Some(CardCounts::USUAL));
        assert_eq!(CardCounts::halved_from(1), CardCounts::new(&[1]));
        let wrong: [&[u32]; 6] = [&[], &[0], &[4, 4], &[4, 8], &[4, 0], &[limits::CARDS + 1]];
        for given in wrong {
            assert_eq!(CardCounts::new(given), None, "{given:?}");
        }
        assert_eq!(CardCounts::new(&[9, 8, 7, 6, 5, 4, 3, 2, 1]), None);
        assert_eq!(CardCounts::halved_from(0), None);
    }
}
