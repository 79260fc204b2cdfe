//! What going over from one level of impostors to the next does to the picture.
//!
//! ```text
//! level            32 ·················· on the way ·················· 16
//! pictures    Leaving ─────────────────────▶ LastStep, LastButOne … ─┼▶ Entering
//!                                                                switch
//! ```
//!
//! On the way the finer level's impostors move into the planes of the coarser one's
//! ([GSS05](crate::references), § 2.4); at its end they are swapped. What the swap alone changes is the
//! difference between the last two pictures.

use super::RunError;
use super::progress::Progress;
use super::stand_ins::{Screen, StandInOptions, sphere_of};
use super::views::{Shot, corner_directions};
use super::world::World;
use crate::models::{CardLevel, Kind, ModelOptions, State};
use crate::scene::{CardCounts, CardOptions};

/// The pictures around a switch of levels, from one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct SwitchLook {
    /// How many impostors the finer and the coarser level have.
    pub counts: [u32; 2],
    /// Which of the scales asked for.
    pub scale: usize,
    /// The finer level as it is.
    pub leaving: Shot,
    /// One step before the last.
    pub last_but_one: Shot,
    /// The last step: the finer level's impostors, all but in the planes of the coarser.
    pub last: Shot,
    /// The coarser level.
    pub entering: Shot,
}

/// The levels of impostors between which is switched: the scene's; where these are one, it, half and
/// a quarter of it.
#[must_use]
pub fn switched_levels(cards: &CardOptions) -> CardCounts {
    let counts = cards.levels.as_slice();
    match counts {
        [only] => CardCounts::halved_from(*only).unwrap_or(cards.levels),
        _ => cards.levels,
    }
}

/// Looks at each switch of [levels](switched_levels) from the [corners](corner_directions), at all scales
/// asked for: scale by scale, switch by switch. Everything is of the world's first plant; without one, nothing is
/// found.
///
/// # Errors
///
/// What the device refuses, and what `take` answers.
pub fn level_switches<E: From<RunError>>(
    world: &World,
    options: &StandInOptions,
    progress: &dyn Progress,
    mut take: impl FnMut(SwitchLook) -> Result<(), E>,
) -> Result<(), E> {
    let Some(crown) = world.crowns.first() else {
        return Ok(());
    };
    let levels = switched_levels(&options.session.model.cards);
    let model = Kind::Impostors.model(
        crown,
        ModelOptions {
            cards: CardOptions {
                levels,
                ..options.session.model.cards
            },
            ..options.session.model
        },
    );
    let switches: Vec<(u32, [u32; 2])> = (0..)
        .zip(levels.as_slice().windows(2))
        .map(|(level, counts)| (level, [counts[0], counts[1]]))
        .collect();
    let looks = options.scales.len() * switches.len();
    progress.begin("switches", looks as u64);
    let (screen, sphere) = (Screen::new(options), sphere_of(crown));
    for (scale, view) in options.scales.iter().enumerate() {
        let mut camera = screen.camera(model.as_ref(), sphere, view.before)?;
        for &(level, counts) in &switches {
            let first = level * CardLevel::STEPS;
            let steps = [
                0,
                CardLevel::STEPS - 2,
                CardLevel::STEPS - 1,
                CardLevel::STEPS,
            ];
            for direction in corner_directions() {
                let mut shot = |step: u32| -> Result<Shot, RunError> {
                    let state = State::Cards(CardLevel(first + step));
                    camera.studio.show(&state)?;
                    Ok(camera.shot(direction)?.0)
                };
                take(SwitchLook {
                    counts,
                    scale,
                    leaving: shot(steps[0])?,
                    last_but_one: shot(steps[1])?,
                    last: shot(steps[2])?,
                    entering: shot(steps[3])?,
                })?;
            }
            progress.step();
        }
    }
    Ok(())
}
