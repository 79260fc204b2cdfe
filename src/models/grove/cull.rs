//! The compute program that culls patches, chooses their levels and lists them; each group a level.

use crate::gpu::{Access, ComputeLayout, ComputeProgram, Group};
use crate::math::{Aabb, Mat4, Vec3};
use crate::models::Placement;
use crate::models::clip_box::ClipBox;

/// The slot of the view.
pub(super) const VIEW_SLOT: u32 = 0;
/// The slot of the places of patches.
pub(super) const PLACE_SLOT: u32 = 1;
/// The slot of the camera: the eye (3 × `f32`, world), and how far away an error may be seen (`f32`).
pub(super) const CAMERA_SLOT: u32 = 2;
/// The slot of the table of levels: the patch's box (6 × `f32`), then the error of each level (`f32`).
pub(super) const TABLE_SLOT: u32 = 3;
/// The slot of the lists: room for all patches, `u32` each, a level.
pub(super) const LIST_SLOT: u32 = 4;
/// The slot of the draw arguments: two records a part, polygons and lines, a level.
pub(super) const RECORD_SLOT: u32 = 5;

/// Words of a record.
const RECORD_WORDS: usize = 4;

/// The program.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cull {
    pub(super) patches: u32,
    /// Draws of polygons, and as many of lines, a level.
    pub(super) parts: u32,
    /// Whether lists are sorted from far to near.
    pub(super) sorts: bool,
}

impl ComputeProgram for Cull {
    fn layout(&self) -> ComputeLayout {
        // Of each patch a box against six planes and a distance; sorted by some 16 comparisons each.
        let each = if self.sorts { 256 + 16 * 8 } else { 256 };
        ComputeLayout {
            name: if self.sorts { "grove-sorted" } else { "grove" },
            version: 1,
            slots: &[
                Access::Read,
                Access::Read,
                Access::Read,
                Access::Read,
                Access::Share,
                Access::Share,
            ],
            group_operations: each * self.patches,
        }
    }

    fn run(&self, group: &mut Group<'_>) {
        let [x, y, z, reach] = group.f32s(CAMERA_SLOT as usize, 0);
        let [ax, ay, az, bx, by, bz] = group.f32s(TABLE_SLOT as usize, 0);
        let levels = group.len(TABLE_SLOT as usize) - 6;
        let view = View {
            clip_from_world: Mat4::from_cols_array(&group.f32s(VIEW_SLOT as usize, 0)),
            eye: Vec3::new(x, y, z),
            bounds: Aabb {
                min: Vec3::new(ax, ay, az),
                max: Vec3::new(bx, by, bz),
            },
            reach,
            errors: (0..levels)
                .map(|level| group.f32s::<1>(TABLE_SLOT as usize, 6 + level)[0])
                .collect(),
        };
        let level = group.number() as usize;
        let mut shown = Vec::new();
        for patch in 0..self.patches {
            let place = Placement::from_words(group.f32s(PLACE_SLOT as usize, 8 * patch as usize));
            if view.level_of(&place) == Some(level) {
                shown.push((patch, place.position.distance(view.eye)));
            }
        }
        if self.sorts {
            shown.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        }
        for (at, (patch, _)) in shown.iter().enumerate() {
            group.set(LIST_SLOT as usize, at, *patch);
        }
        for record in 0..2 * self.parts as usize {
            let count = crate::math::index_u32(shown.len());
            group.set(RECORD_SLOT as usize, RECORD_WORDS * record + 1, count);
        }
    }
}

/// Sorts numbers, ascending before, by descending distance; equally far ones stay ascending.
pub(super) fn sort_far_to_near(numbers: &mut [u32], distance: impl Fn(u32) -> f32) {
    numbers.sort_by(|a, b| distance(*b).total_cmp(&distance(*a)));
}

/// What decides the level of a patch: the same arithmetic on host and device.
#[derive(Debug, Clone)]
pub(super) struct View {
    pub(super) clip_from_world: Mat4,
    pub(super) eye: Vec3,
    /// Of the patch, in its own space.
    pub(super) bounds: Aabb,
    /// How far away an error of a metre may be seen.
    pub(super) reach: f32,
    /// Of each level, in metres of the patch, ascending.
    pub(super) errors: Vec<f32>,
}

impl View {
    /// The level of a patch: the coarsest whose error, as near as the patch may be, is no more than may be
    /// seen; none where it is out of sight.
    pub(super) fn level_of(&self, place: &Placement) -> Option<usize> {
        let clip = ClipBox::new(&self.clip_from_world, place, &self.bounds);
        if clip.is_out_of_sight() {
            return None;
        }
        let eye = place.to_plant(self.eye);
        let nearest = eye.clamp(self.bounds.min, self.bounds.max);
        let distance = nearest.distance(eye);
        // Both in the patch's own metres: its scale cancels out.
        let fits = |error: &&f32| **error * self.reach <= distance;
        Some(
            self.errors
                .iter()
                .take_while(fits)
                .count()
                .saturating_sub(1),
        )
    }
}
