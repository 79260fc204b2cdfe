//! Foliage at a share of its leaves, by spinney's two collapse sequences and by their rivals, held against
//! full detail.
//!
//! ```text
//! scene ─▶ plants ─┬─ collapse sequences ─▶ a level ──────┐
//!                  └─ Rival ─▶ leaves ─▶ a plant of them ─┴─ Views ─▶ ViewQuality ─▶ tables
//! ```
//!
//! All are drawn by one program from the same 26 directions, with the same textures, alpha test, light
//! and sphere: a rival's triangles become leaves whose third and fourth corner are one. `README.md`
//! tells how to run it and what the columns mean.

mod rival;
mod tables;
mod triangles;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use spinney::math::Sphere;
use spinney::models::{Crown, State};
use spinney::plant::{Foliage, Plant};
use spinney::report::{Picture, PictureView, QualitySummary, ViewQuality};
use spinney::run::{Silent, Views, World};
use spinney::scene::Scene;
use spinney::simplify::{CollapseSequence, PruningOptions, measure_leaves, prune_leaves};

use rival::Rival;
use tables::Row;

/// Percentages of the leaves that are kept.
const SHARES: [u32; 4] = [50, 25, 10, 5];

/// The view of which pictures are kept: from the front, a little aside.
const PICTURED_VIEW: usize = 13;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(scene), Some(out)) = (arguments.next(), arguments.next()) else {
        return Err("usage: spinney-rivals SCENE.toml OUT [PART OF A PLANT'S NAME]".into());
    };
    let (path, out) = (Path::new(&scene), PathBuf::from(out));
    let wanted = arguments.next().unwrap_or_default();
    let scene = Scene::read(path)?;
    let world = World::build(&scene, path.parent().unwrap_or(Path::new("")), &Silent)?;
    let names: Vec<&str> = world
        .crowns
        .iter()
        .map(|crown| crown.plant().name())
        .collect();
    if !names.iter().any(|name| name.contains(&wanted)) {
        return Err(format!(
            "no plant's name has {wanted:?} in it; there are {}",
            names.join(", ")
        )
        .into());
    }
    std::fs::create_dir_all(out.join("pictures"))?;
    let mut rows = Vec::new();
    for crown in &world.crowns {
        if crown.plant().name().contains(&wanted) {
            let found = compare(crown, &out)?;
            print!("{}", tables::lines(&found));
            rows.extend(found);
        }
    }
    tables::write(&out, &rows)?;
    println!("\n{}", tables::wins(&rows));
    Ok(())
}

/// One plant at every share, by everyone.
fn compare(crown: &Arc<Crown>, out: &Path) -> Result<Vec<Row>, Box<dyn Error>> {
    let name = crown.plant().name();
    let foliage = crown.plant().foliage();
    let sphere = Sphere::of(crown.original_vertices());
    let all = crown.sequence().original_count();
    let mut views = Views::new(crown)?;
    let full = seen(&mut views)?;
    keep(out, name, "full", 100, &full)?;
    let full_area = area(crown, &State::FINEST);
    // As far as the leaf collapses go.
    let options = PruningOptions::to(crown.sequence().root_count());
    let sequence = prune_leaves(foliage, &options);
    let pruned = Arc::new(Crown::new(Arc::clone(crown.plant()), sequence));
    let mut pruned_views = Views::within(&pruned, sphere)?;
    let mut rows = Vec::new();
    for share in SHARES {
        let leaves = all * share / 100;
        let mut row = |method: &str, option: &str, kept: &Crown, state: &State, level: Level| {
            keep(out, name, method, share, &level.views)?;
            rows.push(Row {
                plant: name.to_owned(),
                share,
                method: method.to_owned(),
                option: option.to_owned(),
                triangles: triangles_of(kept, state),
                wanted: 2 * leaves,
                area: area(kept, state) / full_area,
                quality: level.quality,
            });
            Ok::<(), Box<dyn Error>>(())
        };
        let state = State::Uniform {
            collapses: (all - leaves).min(crown.sequence().collapse_count()),
        };
        views.show(&state)?;
        row("FSA", "", crown, &state, Level::of(&mut views, &full)?)?;
        pruned_views.show(&state)?;
        let level = Level::of(&mut pruned_views, &full)?;
        row("pruning in LoDF", "", &pruned, &state, level)?;
        for rival in Rival::ALL {
            // The best that it can do: by FLIP, among all its options.
            let mut best: Option<(&str, Arc<Crown>, Level)> = None;
            for (option, kept) in rival.simplify(foliage, leaves) {
                let kept = plant_of(kept)?;
                if triangles_of(&kept, &State::FINEST) > 2 * leaves {
                    continue;
                }
                let level = Level::of(&mut Views::within(&kept, sphere)?, &full)?;
                let flip = |level: &Level| level.quality.flip.mean;
                if best
                    .as_ref()
                    .is_none_or(|best| flip(&level) < flip(&best.2))
                {
                    best = Some((option, kept, level));
                }
            }
            match best {
                Some((option, kept, level)) => {
                    row(rival.name(), option, &kept, &State::FINEST, level)?;
                }
                None => println!("{name}, {share} %: {} does not get so far", rival.name()),
            }
        }
    }
    Ok(rows)
}

/// Leaves from all directions, and what is found of them.
struct Level {
    views: Vec<PictureView>,
    quality: QualitySummary,
}

impl Level {
    fn of(views: &mut Views, full: &[PictureView]) -> Result<Self, Box<dyn Error>> {
        let views = seen(views)?;
        let pairs = full.iter().zip(&views);
        let found = pairs.map(|(full, level)| ViewQuality::between(full, level));
        let quality = QualitySummary::of(&found.collect::<Result<Vec<_>, _>>()?);
        Ok(Self { views, quality })
    }
}

fn seen(views: &mut Views) -> Result<Vec<PictureView>, Box<dyn Error>> {
    let shots = views.shots()?.into_iter();
    Ok(shots.map(PictureView::of).collect::<Result<_, _>>()?)
}

/// A crown of these leaves and no others.
fn plant_of(foliage: Foliage) -> Result<Arc<Crown>, Box<dyn Error>> {
    let plant = Plant::new("rival", None, None, foliage)?;
    let leaves = u32::try_from(plant.foliage().quad_count())?;
    let corners = (0..leaves).map(|leaf| [0, 1, 2, 3].map(|role| 4 * leaf + role));
    let sequence = CollapseSequence::new(leaves, corners.collect(), Vec::new())?;
    Ok(Arc::new(Crown::new(Arc::new(plant), sequence)))
}

/// Triangles with an area, so that a triangle in the place of a leaf counts as one.
fn triangles_of(crown: &Crown, state: &State) -> u32 {
    let corners = crown.sequence().corners();
    let visible = state.visible(crown.clusters()).into_iter();
    let triangles = visible.map(|leaf| {
        let [.., third, fourth] =
            corners[leaf as usize].map(|vertex| crown.vertices()[vertex as usize]);
        if third == fourth { 1 } else { 2 }
    });
    triangles.sum()
}

fn area(crown: &Crown, state: &State) -> f64 {
    let visible = state.visible(crown.clusters());
    measure_leaves(crown.vertices(), crown.sequence(), visible).area
}

/// Keeps one of the pictures.
fn keep(
    out: &Path,
    plant: &str,
    method: &str,
    share: u32,
    views: &[PictureView],
) -> Result<(), Box<dyn Error>> {
    let plain = |text: &str| text.to_lowercase().replace([' ', ':', '_'], "-");
    let name = format!("{}-{share:03}-{}.png", plain(plant), plain(method));
    let picture: &Picture = &views[PICTURED_VIEW].picture;
    std::fs::write(out.join("pictures").join(name), picture.to_png()?)?;
    Ok(())
}
