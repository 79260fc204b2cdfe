//! Draws every species file of a folder, full detail, into one contact sheet.
//!
//! ```text
//! cargo run --release --example gallery -- scenes/species sheet.png
//! ```

#![expect(clippy::print_stdout, reason = "a program that says what it draws")]

use std::error::Error;
use std::path::Path;
use std::sync::Arc;

use spinney::document::Document;
use spinney::plant::{Species, grow};
use spinney::raster::{Counters, Options, TileSize};
use spinney::run::{Session, SessionOptions, StandingTree, World, crown};
use spinney::scene::SceneFile;

/// Pixels of one picture's side.
const SIDE: u32 = 240;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments
        .next()
        .unwrap_or_else(|| "scenes/species".to_owned());
    let output = arguments.next().unwrap_or_else(|| "gallery.png".to_owned());
    let mut files: Vec<_> = std::fs::read_dir(&folder)?
        .map(|entry| entry.map(|e| e.path()))
        .collect::<Result<_, _>>()?;
    files.retain(|path| path.extension().is_some_and(|ending| ending == "toml"));
    files.sort();
    let columns = 5;
    let rows = u32::try_from(files.len())?.div_ceil(columns);
    let mut sheet = image::RgbaImage::new(columns * SIDE, rows * SIDE);
    for (number, path) in (0..).zip(&files) {
        let picture = portrait(path)?;
        let (x, y) = (number % columns * SIDE, number / columns * SIDE);
        image::imageops::replace(&mut sheet, &picture, i64::from(x), i64::from(y));
    }
    sheet.save(output)?;
    Ok(())
}

/// One tree from a distance at which it fills the picture.
fn portrait(path: &Path) -> Result<image::RgbaImage, Box<dyn Error>> {
    let plant = grow(&Species::read(path)?, 1)?;
    let bounds = plant.bounds();
    let (middle, size) = (bounds.center(), bounds.size());
    let distance = 1.75 * size.y.max(size.x).max(size.z);
    let text = format!(
        "schema = \"spinney.scene/1\"\nname = \"portrait\"\nsize = [{SIDE}, {SIDE}]\nsamples = 4\n\
         background = \"#c9d9e8\"\n[[tree]]\nspecies = \"unused.toml\"\n\
         [camera]\nvertical_field_of_view = 36.0\n\
         path = [{{ frame = 0, eye = [{}, {}, {}], target = [{}, {}, {}] }}]\n\
         [light]\ndirection = [0.4, 0.8, 0.45]\n[model]\nname = \"full\"\n",
        middle.x,
        middle.y + 0.08 * distance,
        middle.z + distance,
        middle.x,
        middle.y,
        middle.z,
    );
    let document = Document {
        file: "portrait.toml".to_owned(),
        text,
    };
    let scene = SceneFile::parse(document)?.scene;
    println!(
        "{}: {} leaves, {} branch polygons, {:.1} m high, {:.1} m wide",
        plant.name(),
        plant.foliage().leaf_count(),
        plant.trunk().map_or(0, |trunk| trunk.triangle_count()),
        size.y,
        size.x.max(size.z),
    );
    let everything = u32::try_from(plant.foliage().leaf_count())?;
    let standing = StandingTree {
        crown: 0,
        placement: spinney::models::Placement::IDENTITY,
    };
    let crown = Arc::new(crown(plant, Some(everything)));
    let world = World::of(vec![crown], vec![standing]);
    let raster = Options {
        tile: TileSize::Side64,
        counters: Counters::Visible,
    };
    let frame = Session::new(&scene, &world, &SessionOptions::of(&scene, raster)?)?.frame(0)?;
    let image = frame.image;
    image::RgbaImage::from_raw(image.width, image.height, image.rgba)
        .ok_or_else(|| "a picture of other than its own size".into())
}
