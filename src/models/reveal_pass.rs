//! The compute program that reveals: from what was drawn first to what must be drawn beside.
//!
//! ```text
//!  select ─▶ what was seen last time ─▶ first pass ─▶ depth ─▶ pyramid ─┐
//!    │                                                                  ▼
//!    └─▶ draw arguments ─────────────────────────────────────────▶ reveal ─┬─▶ second pass
//!                                                                          └─▶ seen, for the next frame
//! ```
//!
//! Two-phase occlusion culling ([HA15](crate::references), after [GKM93](crate::references)): the clusters that were seen last time are
//! drawn at once and hide others; all are then tested against what they hide. What is farther than
//! everything drawn where it may show is left out, and cannot have shown: what is drawn later only
//! brings depth nearer. A cluster at equal depth is drawn, since keys decide there. So whatever was
//! seen before, the picture is the same; which pass draws a cluster, and whether one does that shows
//! nowhere, is all that depends on it.
//!
//! What is seen is a word a cluster: 0 where nothing of it showed.

use super::clip_box::ClipBox;
use super::environment::{INSTANCE_SLOT, Placement, VIEW_SLOT, View};
use super::pyramid_pass::hides;
use super::select_pass::{Cluster, DETAIL_SLOT, GROUP_CLUSTERS, Place, cluster_count, step};
use crate::gpu::{Access, ComputeLayout, ComputeProgram, Group};
use crate::math::Mat4;

/// The slot of the depth of what was drawn first.
pub(super) const DEPTH_SLOT: u32 = 2;
/// The slot of the arguments of the first pass.
pub(super) const EARLY_ARGUMENT_SLOT: u32 = 5;
/// The slot of the pyramid.
pub(super) const PYRAMID_SLOT: u32 = 6;
/// The slot of what is seen: written.
pub(super) const REVEALED_SLOT: u32 = 7;
/// The slot of the arguments of the second pass: written.
pub(super) const LATE_ARGUMENT_SLOT: u32 = 8;

/// The program.
#[derive(Debug, Clone, Copy)]
pub(super) struct RevealPass;

impl ComputeProgram for RevealPass {
    fn layout(&self) -> ComputeLayout {
        const SLOTS: [Access; 9] = [
            Access::Read,
            Access::Read,
            Access::Depth,
            Access::Read,
            Access::Read,
            Access::Read,
            Access::Read,
            Access::Own {
                group_bytes: 4 * GROUP_CLUSTERS,
            },
            Access::Own {
                group_bytes: 16 * GROUP_CLUSTERS,
            },
        ];
        ComputeLayout {
            name: "reveal",
            version: 1,
            slots: &SLOTS,
            // A cluster: eight corners of a box through two matrices against six planes, their
            // quotients, and as many cells as are looked at of most.
            group_operations: GROUP_CLUSTERS * 1024,
        }
    }

    fn run(&self, group: &mut Group<'_>) {
        let clip_from_world = View::read_matrix(group.f32s(VIEW_SLOT as usize, 0));
        let clusters = cluster_count(group);
        let mut standing: Option<(u32, Placement)> = None;
        for number in 0..group.len(REVEALED_SLOT as usize) {
            let place = Place::of(group, number, clusters);
            let placement = match standing {
                Some((room, placement)) if room == place.room => placement,
                _ => {
                    let instance = group.u32(DETAIL_SLOT as usize, place.detail() + 1);
                    let words = group.f32s(INSTANCE_SLOT as usize, 8 * instance as usize);
                    Placement::from_words(words)
                }
            };
            standing = Some((place.room, placement));
            let seen = may_be_seen(group, &clip_from_world, &placement, place.cluster);
            let [corners, drawn, first_corner, instance] =
                group.u32s(EARLY_ARGUMENT_SLOT as usize, 4 * place.word());
            let late = u32::from(seen && drawn == 0);
            group.set(REVEALED_SLOT as usize, number, u32::from(seen));
            let words = [corners, late, first_corner, instance];
            for (word, value) in words.into_iter().enumerate() {
                group.set(LATE_ARGUMENT_SLOT as usize, 4 * number + word, value);
            }
        }
    }
}

fn may_be_seen(
    group: &mut Group<'_>,
    clip_from_world: &Mat4,
    placement: &Placement,
    number: u32,
) -> bool {
    let bounds = Cluster::read(group, number).displaced(step(group));
    let clip = ClipBox::new(clip_from_world, placement, &bounds);
    if clip.is_out_of_sight() {
        return false;
    }
    let size = group.size(DEPTH_SLOT as usize);
    match clip.reach(size) {
        None => true,
        Some(reach) => !hides(group, [DEPTH_SLOT, PYRAMID_SLOT], &reach),
    }
}
