//! What one frame showed and cost.

use super::popping::Popping;
use super::shard::exact_place;
use crate::gpu::Ledger;
use crate::math::{Digest, Vec3};
use crate::models::{Change, TreeState};
use crate::raster::Image;

/// What one frame showed and cost.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Frame {
    /// Its number.
    pub frame: u32,
    /// Where the camera stood, in world space.
    #[serde(with = "exact_place")]
    pub eye: Vec3,
    /// The picture. Not serialized, and empty where the frame was read.
    #[serde(skip, default = "no_image")]
    pub image: Image,
    /// The picture's digest.
    pub image_digest: Digest,
    /// Leaves drawn, over all trees.
    pub leaves: u64,
    /// How many lines were drawn in place of branches and needles.
    pub lines: u64,
    /// How many strokes were drawn in place of leaves and branches.
    pub strokes: u64,
    /// Triangles drawn: two a quad leaf, the faces of others, those of cards, the trunks', and the
    /// ground's.
    pub triangles: u64,
    /// Of those, the trunks'.
    pub trunk_triangles: u64,
    /// What the change of detail took of the foliage.
    pub change: Change,
    /// What it took of the trunks.
    pub trunk_change: Change,
    /// What was moved and drawn.
    pub ledger: Ledger,
    /// The state of every tree.
    pub states: Vec<TreeState>,
    /// With a budget of bytes: how many clusters, or trees that change as a whole, it held back.
    pub deferred: Option<u64>,
    /// What it shows for a switch of detail alone, where somebody watched.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub popping: Option<Popping>,
}

impl Frame {
    /// A frame of nothing, for tests to fill in.
    #[cfg(test)]
    pub(crate) fn blank() -> Self {
        Self {
            frame: 0,
            eye: Vec3::ZERO,
            image: no_image(),
            image_digest: Digest([0; 32]),
            leaves: 0,
            lines: 0,
            strokes: 0,
            triangles: 0,
            trunk_triangles: 0,
            change: Change::default(),
            trunk_change: Change::default(),
            ledger: Ledger::default(),
            states: Vec::new(),
            deferred: None,
            popping: None,
        }
    }

    /// Gives a frame that was read its picture back: R, G, B, A of each pixel, row by row from the
    /// top. Whether it is the frame's own, its digest says.
    pub fn set_image(&mut self, [width, height]: [u32; 2], rgba: Vec<u8>) {
        self.image = Image {
            width,
            height,
            rgba,
        };
    }
}

/// The picture of a frame that was read without it.
fn no_image() -> Image {
    Image {
        width: 0,
        height: 0,
        rgba: Vec::new(),
    }
}
