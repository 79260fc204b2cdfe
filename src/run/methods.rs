//! What Table 1 of [ZBMJLDC17](crate::references) marks with plus and minus, measured for every model.
//!
//! ```text
//! scene of one plant ─┬─ along the path ──▶ detail, continuity, modelled time
//!                     ├─ storage ─────────▶ bytes a sample, a tree ─▶ how many trees
//!                     └─ light on and off ▶ pixels in shadow
//! ```

use super::RunError;
use super::frame::Frame;
use super::options::SessionOptions;
use super::progress::Progress;
use super::session::Session;
use super::world::World;
use crate::gpu::nanoseconds;
use crate::models::{Kind, Storage, TrunkKind};
use crate::raster::Image;
use crate::scene::{Scene, Shadow, TrunkMode, TrunkName};

/// A model of foliage with one of wood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Method {
    /// Of leaves, or of what stands in for them.
    pub foliage: Kind,
    /// Of wood; strokes paint theirs themselves.
    pub wood: TrunkKind,
}

impl Method {
    /// Everything at full detail: what the others are held against.
    pub const FULL: Self = Self {
        foliage: Kind::Full,
        wood: TrunkKind::FULL,
    };

    /// Every model that there is, in the mode that keeps most on the device; branches in all of theirs.
    #[must_use]
    pub fn all() -> Vec<Self> {
        const fn wood(name: TrunkName, mode: TrunkMode) -> TrunkKind {
            TrunkKind { name, mode }
        }
        let strips = wood(TrunkName::LodStrips, TrunkMode::Device);
        let meshes = wood(TrunkName::Mom, TrunkMode::Device);
        let mut methods = vec![
            (Kind::Full, TrunkKind::FULL),
            (Kind::VdfIndices, meshes),
            (Kind::LodfStamps, strips),
            (Kind::LodfDevice, strips),
            (Kind::Impostors, TrunkKind::FULL),
            (Kind::IndirectImpostors, TrunkKind::FULL),
        ];
        methods.extend(Kind::RIVALS.map(|kind| (kind, TrunkKind::FULL)));
        methods.push((Kind::StrokeRanges, TrunkKind::FULL));
        let branches = TrunkName::Branches.modes().iter();
        methods.extend(branches.map(|&mode| (Kind::LodfStamps, wood(TrunkName::Branches, mode))));
        let method = |(foliage, wood)| Self { foliage, wood };
        methods.into_iter().map(method).collect()
    }

    /// Both in one word, such as `lodf-stamps+branches-skeleton`.
    #[must_use]
    pub fn label(self) -> String {
        if self.foliage.paints() {
            self.foliage.label()
        } else {
            format!("{}+{}", self.foliage.label(), self.wood.label())
        }
    }
}

/// What was measured of a method.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodFound {
    /// Which.
    pub method: Method,
    /// How much its picture differs from full detail in the first and the last frame of the path: mean over
    /// pixels and channels, of 255.
    pub detail: [f64; 2],
    /// How much more a frame of the path differs from the one before than at full detail, at the most, and
    /// in which; nothing without a path.
    pub worst_step: Option<(u32, f64)>,
    /// What it takes to keep, of the first plant.
    pub storage: Storage,
    /// Modelled times of the first and the last frame: uploads, fetches, then the card.
    pub frame_ns: [Option<u64>; 2],
    /// How many trees as far away as in the last frame are drawn 30 times a second and fit on the device.
    pub trees: Option<u64>,
    /// How many pixels of the first and the last frame shadows change; nothing where it casts none.
    pub shadow_pixels: Option<[u64; 2]>,
}

/// Measures every method along the path of a scene; the first is full detail.
///
/// # Errors
///
/// What the device refuses.
pub fn methods(
    scene: &Scene,
    world: &World,
    options: &SessionOptions,
    progress: &dyn Progress,
) -> Result<Vec<MethodFound>, RunError> {
    let all = Method::all();
    progress.begin("methods", all.len() as u64);
    let yardstick = walk(scene, world, &session_options(Method::FULL, options))?;
    let mut found = Vec::new();
    for method in all {
        let options = session_options(method, options);
        found.push(measure(scene, world, method, &options, &yardstick)?);
        progress.step();
    }
    Ok(found)
}

fn session_options(method: Method, usual: &SessionOptions) -> SessionOptions {
    SessionOptions {
        kind: method.foliage,
        trunk: method.wood,
        ..*usual
    }
}

/// Every frame of the path.
fn walk(scene: &Scene, world: &World, options: &SessionOptions) -> Result<Vec<Frame>, RunError> {
    // Shadows are looked at by themselves.
    let scene = Scene {
        shadow: None,
        ..scene.clone()
    };
    let mut session = Session::new(&scene, world, options)?;
    (0..scene.frames)
        .map(|frame| session.frame(frame))
        .collect()
}

fn measure(
    scene: &Scene,
    world: &World,
    method: Method,
    options: &SessionOptions,
    yardstick: &[Frame],
) -> Result<MethodFound, RunError> {
    let frames = walk(scene, world, options)?;
    let pairs: Vec<(&Frame, &Frame)> = frames.iter().zip(yardstick).collect();
    let ends = [pairs.first(), pairs.last()];
    let steps = pairs.windows(2).map(|pair| {
        let [before, after] = [pair[0], pair[1]];
        let beyond = difference(&before.0.image, &after.0.image)
            - difference(&before.1.image, &after.1.image);
        (after.0.frame, beyond)
    });
    let storage = storage(world, method, options);
    let frame_ns =
        ends.map(|end| end.and_then(|(frame, _)| frame.ledger.frame_ticks().map(nanoseconds)));
    Ok(MethodFound {
        method,
        detail: ends.map(|end| end.map_or(0.0, |(one, full)| difference(&one.image, &full.image))),
        worst_step: steps.max_by(|(_, one), (_, other)| one.total_cmp(other)),
        storage,
        frame_ns,
        trees: frame_ns[1].map(|far| most_trees(far, &storage, scene.device.memory)),
        shadow_pixels: shadow_pixels(scene, world, options)?,
    })
}

/// Of the first plant's foliage and wood together.
fn storage(world: &World, method: Method, options: &SessionOptions) -> Storage {
    let mut sum = Storage::default();
    let foliage = (world.crowns.first()).map(|crown| {
        let model = method.foliage.model(crown, options.model);
        let paints_trunk = model.painting().is_some_and(|one| one.paints_trunk());
        (model.storage(), paints_trunk)
    });
    let wood = (world.trunks.first()).and_then(Option::as_ref);
    let wood = wood.filter(|_| foliage.is_none_or(|(_, paints_trunk)| !paints_trunk));
    let wood = wood.map(|trunk| method.wood.model(trunk, options.model).storage());
    for part in foliage.map(|(storage, _)| storage).into_iter().chain(wood) {
        sum.host_bytes += part.host_bytes;
        sum.shared_bytes += part.shared_bytes;
        sum.instance_bytes += part.instance_bytes;
        sum.instance_host_bytes += part.instance_host_bytes;
    }
    sum
}

/// How many trees a thirtieth of a second suffices for, and the memory for one sample and its instances.
fn most_trees(frame_ns: u64, storage: &Storage, memory: u64) -> u64 {
    const THIRTIETH_NS: u64 = 1_000_000_000 / 30;
    let in_time = THIRTIETH_NS / frame_ns.max(1);
    let left = memory.saturating_sub(storage.shared_bytes);
    in_time.min(left / storage.instance_bytes.max(1))
}

/// How many pixels of the first and the last frame change when what stands casts shadows.
fn shadow_pixels(
    scene: &Scene,
    world: &World,
    options: &SessionOptions,
) -> Result<Option<[u64; 2]>, RunError> {
    // It leaves out what the camera does not see, and so what only casts a shadow.
    if options.kind.selects() {
        return Ok(None);
    }
    let usual = Shadow {
        size: 1024,
        bias: 4.0,
        extent: None,
    };
    let scenes = [None, Some(scene.shadow.unwrap_or(usual))].map(|shadow| Scene {
        shadow,
        ..scene.clone()
    });
    let [bright, shaded] = &scenes;
    let mut sessions = [
        Session::new(bright, world, options)?,
        Session::new(shaded, world, options)?,
    ];
    let mut count = |frame| -> Result<u64, RunError> {
        let [bright, shaded] = &mut sessions;
        let images = [bright.frame(frame)?.image, shaded.frame(frame)?.image];
        let [bright, shaded] = images.each_ref().map(|image| image.rgba.chunks_exact(4));
        Ok(bright
            .zip(shaded)
            .filter(|(one, other)| one != other)
            .count() as u64)
    };
    Ok(Some([count(0)?, count(scene.frames - 1)?]))
}

/// The mean difference of two pictures of one size, over pixels and channels.
pub(super) fn difference(one: &Image, other: &Image) -> f64 {
    let bytes = one.rgba.iter().zip(&other.rgba);
    let sum: u64 = bytes.map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    // Opacity is always full.
    let channels = 3 * (one.rgba.len() as u64 / 4).max(1);
    sum as f64 / channels as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_has_a_label_of_its_own() {
        let mut labels: Vec<String> = Method::all().into_iter().map(Method::label).collect();
        assert_eq!(labels[0], Method::FULL.label());
        let count = labels.len();
        labels.sort();
        labels.dedup();
        assert_eq!(labels.len(), count);
        assert!(labels.contains(&"lodf-stamps+branches-skeleton".to_owned()));
    }

    #[test]
    fn time_or_memory_ends_a_forest() {
        let storage = Storage {
            shared_bytes: 600,
            instance_bytes: 4,
            ..Storage::default()
        };
        assert_eq!(most_trees(1_000_000, &storage, 1000), 33, "33.3 ms");
        assert_eq!(most_trees(1_000, &storage, 1000), 100, "400 bytes are left");
        assert_eq!(most_trees(0, &storage, 600), 0);
    }
}
