//! Popping: what a switch of detail alone does to the picture of a path.
//!
//! ```text
//! frame k − 1   states a ──▶ leaves A        full detail ──▶ leaves F
//! frame k       states a ──▶ picture P       full detail ──▶ leaves G
//! frame k       states b ──▶ picture Q, leaves B
//!
//! popped: P ≠ Q     toggled: A ≠ B     toggled at full detail: F ≠ G     beyond: A ≠ B where F = G
//! ```

use super::RunError;
use super::options::SessionOptions;
use super::session::Session;
use super::views::Shot;
use super::world::World;
use crate::models::TreeState;
use crate::scene::Scene;

/// What a frame shows that it would not show without a switch of detail, in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub struct Popping {
    /// Pixels of another colour than if the frame had kept the states of the frame before: what the
    /// switch alone changes, the camera being the same.
    pub popped: u64,
    /// Pixels that show a leaf in this frame or in the one before, not in both.
    pub toggled: u64,
    /// The same at full detail: what the camera's way alone toggles.
    pub toggled_at_full_detail: u64,
    /// Pixels that toggled, and did not at full detail.
    pub toggled_beyond: u64,
}

impl Popping {
    /// Adds another frame's.
    pub fn add(&mut self, other: &Self) {
        self.popped += other.popped;
        self.toggled += other.toggled;
        self.toggled_at_full_detail += other.toggled_at_full_detail;
        self.toggled_beyond += other.toggled_beyond;
    }

    /// Of a frame as it is and as it would be with the states before, with the leaves of both frames
    /// as they are and at full detail.
    fn between(shown: &Shot, kept: &Shot, before: &Leaves, full: &[bool]) -> Self {
        let pixels = |shot: &Shot| -> Vec<[u8; 4]> { shot.image.rgba.as_chunks::<4>().0.to_vec() };
        let colours = pixels(shown).into_iter().zip(pixels(kept));
        let level = before.level.iter().zip(&shown.leaves);
        let level = level.map(|(one, other)| one != other);
        let full = before
            .full
            .iter()
            .zip(full)
            .map(|(one, other)| one != other);
        let mut found = Self {
            popped: colours.filter(|(one, other)| one != other).count() as u64,
            ..Self::default()
        };
        for (level, full) in level.zip(full) {
            found.toggled += u64::from(level);
            found.toggled_at_full_detail += u64::from(full);
            found.toggled_beyond += u64::from(level && !full);
        }
        found
    }
}

/// Watches frames come one after another. It draws on a device of its own, so that nothing of it is
/// in a ledger: each frame twice more, and the frame before twice where that was only selected.
#[derive(Debug)]
pub struct PopMeter<'w> {
    session: Session<'w>,
    trees: usize,
    before: Option<Before>,
}

/// The frame before.
#[derive(Debug)]
struct Before {
    frame: u32,
    states: Vec<TreeState>,
    /// Where leaves were, if it was drawn.
    leaves: Option<Leaves>,
}

/// Whether the pixels of a frame show a leaf.
#[derive(Debug)]
struct Leaves {
    level: Vec<bool>,
    full: Vec<bool>,
}

impl<'w> PopMeter<'w> {
    /// Makes a device like the run's.
    ///
    /// # Errors
    ///
    /// What the device refuses, above all for lack of memory.
    pub fn new(
        scene: &'w Scene,
        world: &'w World,
        options: &SessionOptions,
    ) -> Result<Self, RunError> {
        Ok(Self {
            session: Session::new(scene, world, options)?,
            trees: world.trees.len(),
            before: None,
        })
    }

    /// Takes a frame that is selected and not drawn.
    pub fn skip(&mut self, frame: u32, states: &[TreeState]) {
        self.before = Some(Before {
            frame,
            states: states.to_vec(),
            leaves: None,
        });
    }

    /// Takes a frame that shows `states`, and tells how it pops; of the first there is nothing to
    /// tell.
    ///
    /// # Errors
    ///
    /// None on this device.
    pub fn frame(
        &mut self,
        frame: u32,
        states: &[TreeState],
        shown: &Shot,
    ) -> Result<Option<Popping>, RunError> {
        let full = self.full_detail(frame)?;
        let found = match self.before.take() {
            None => None,
            Some(before) => {
                let leaves = match before.leaves {
                    Some(leaves) => leaves,
                    None => {
                        let full = self.full_detail(before.frame)?;
                        self.session.commit_states(&before.states)?;
                        let level = self.session.shot(before.frame)?.leaves;
                        Leaves { level, full }
                    }
                };
                self.session.commit_states(&before.states)?;
                let kept = self.session.shot(frame)?;
                Some(Popping::between(shown, &kept, &leaves, &full))
            }
        };
        self.before = Some(Before {
            frame,
            states: states.to_vec(),
            leaves: Some(Leaves {
                level: shown.leaves.clone(),
                full,
            }),
        });
        Ok(found)
    }

    fn full_detail(&mut self, frame: u32) -> Result<Vec<bool>, RunError> {
        let finest = vec![TreeState::FINEST; self.trees];
        self.session.commit_states(&finest)?;
        Ok(self.session.shot(frame)?.leaves)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Image;

    /// A row of pixels: `#` a dark leaf, `+` a light leaf, a space the ground.
    fn shot(row: &str) -> Shot {
        let grey = |pixel: u8| match pixel {
            b'#' => 10,
            b'+' => 90,
            _ => 255,
        };
        let rgba = row.bytes().flat_map(|pixel| [grey(pixel); 4]).collect();
        Shot {
            image: Image {
                width: crate::math::index_u32(row.len()),
                height: 1,
                rgba,
            },
            leaves: row.bytes().map(|pixel| pixel != b' ').collect(),
        }
    }

    #[test]
    fn pops_and_toggles_are_counted_pixel_by_pixel() {
        let before = Leaves {
            level: shot("### ").leaves,
            full: shot("####").leaves,
        };
        // Of the frame as it is, two pixels would have another colour with the states before, one of
        // which shows a leaf both ways.
        let (shown, kept) = (shot("#+ #"), shot("##  "));
        // The third pixel goes and the fourth comes; at full detail the fourth goes.
        let full = shot("### ").leaves;
        let found = Popping::between(&shown, &kept, &before, &full);
        let wanted = Popping {
            popped: 2,
            toggled: 2,
            toggled_at_full_detail: 1,
            toggled_beyond: 1,
        };
        assert_eq!(found, wanted);
    }
}
