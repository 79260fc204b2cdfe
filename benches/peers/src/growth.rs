//! How frames grow with the number of triangles, and what a second thread does for them.
//!
//! Yews of 48,160 leaves stand in a square, 7 m apart, as many as it takes; all are instances of one, drawn
//! whole, opaque. They are seen at 1920 × 1080 pixels from two places:
//!
//! - *above*: 35° down, from where the whole square fills the picture;
//! - *within*: from the height of a walker's eyes before the middle of its rim, along its middle.
//!
//! Depth complexity is what is covered by triangles, in samples, by what shows any, counted in a frame
//! of its own in which nothing is left out.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use spinney::gpu::{Blend, Usage};
use spinney::math::{Mat4, Quat, Stream, Vec2, Vec3, Vec4};
use spinney::plant::{Prototype, Species, grow};
use spinney::raster::Counters;
use spinney::report::{Axis, Cell, Column, Plot, Scale, Series, Table};
use spinney::scene::{Camera, CameraKey, ImageSize, Projection};

use crate::clock::{Frames, Schedule, time};
use crate::leaves::{LeafQuads, Surface, Texturing};
use crate::stage::{Drawn, Stage, bytes};
use crate::{Fault, USAGE};

const SIZE: [u32; 2] = [1920, 1080];

/// From one tree to the next, in metres.
const SPACING: f32 = 7.0;

/// How many trees there are: 10⁵, 10⁵·⁵ … 10⁸ triangles.
const TREES: [u32; 7] = [1, 3, 10, 33, 104, 328, 1039];

/// The matrix from the world to clip space, of a square of that side.
type See = fn(f32) -> Result<Mat4, Fault>;

/// What is asked for.
pub(crate) struct GrowthOptions {
    species: PathBuf,
    out: PathBuf,
    /// No more triangles than these.
    most: u64,
    schedule: Schedule,
}

impl GrowthOptions {
    pub(crate) fn read(mut arguments: impl Iterator<Item = String>) -> Result<Self, Fault> {
        let mut place = || arguments.next().ok_or(USAGE).map(PathBuf::from);
        let mut options = Self {
            species: place()?,
            out: place()?,
            most: 101_000_000,
            schedule: Schedule {
                warmup: 1,
                frames: 7,
                most_seconds: 20.0,
            },
        };
        while let Some(name) = arguments.next() {
            let value = arguments.next().ok_or(USAGE)?;
            match name.as_str() {
                "--most" => options.most = value.parse()?,
                "--frames" => options.schedule.frames = value.parse()?,
                "--max-seconds" => options.schedule.most_seconds = value.parse()?,
                _ => return Err(USAGE.into()),
            }
        }
        Ok(options)
    }
}

/// One number of trees from one place.
struct Row {
    place: &'static str,
    trees: u32,
    triangles: u64,
    covered_pixels: u32,
    complexity: f64,
    /// With one thread and with two.
    frames: [Frames; 2],
}

/// Measures, prints a table, and writes it with a plot.
pub(crate) fn growth(options: &GrowthOptions) -> Result<(), Fault> {
    let crown = Crown::of(&options.species)?;
    std::fs::create_dir_all(&options.out)?;
    let mut rows = Vec::new();
    for (place, see) in [("above", above as See), ("within", within)] {
        for trees in TREES {
            if u64::from(trees) * crown.triangles() <= options.most {
                let row = measure(&crown, place, see, trees, options)?;
                println!(
                    "{place}: {} triangles, depth complexity {:.1}: {:.1} ms, with one thread {:.1} ms",
                    row.triangles,
                    row.complexity,
                    row.frames[1].median(),
                    row.frames[0].median(),
                );
                rows.push(row);
            }
        }
    }
    let table = table(&rows);
    println!("\n{}", table.to_text(160));
    std::fs::write(options.out.join("growth.csv"), table.to_csv())?;
    std::fs::write(options.out.join("growth.svg"), plot(&rows).to_svg())?;
    Ok(())
}

/// The quads of a tree's leaves.
struct Crown {
    vertices: Vec<u8>,
    indices: Vec<u32>,
}

impl Crown {
    fn of(species: &Path) -> Result<Self, Fault> {
        let plant = grow(&Species::read(species)?, 1)?;
        let groups = plant.foliage().groups.iter();
        let quads = groups.filter(|group| matches!(group.prototype, Prototype::Quad { .. }));
        let positions: Vec<Vec3> = quads
            .flat_map(|group| group.positions.iter().copied())
            .collect();
        let floats: Vec<f32> = positions
            .iter()
            .flat_map(|position| position.to_array())
            .collect();
        Ok(Self {
            indices: (0..u32::try_from(positions.len())?).collect(),
            vertices: bytes(&floats),
        })
    }

    fn triangles(&self) -> u64 {
        self.indices.len() as u64 / 2
    }

    fn stage(&self, clip_from_world: Mat4, trees: u32, counters: Counters) -> Result<Stage, Fault> {
        let mut stage = Stage::new(SIZE, [0.62, 0.74, 0.88, 1.0], counters)?;
        let view = bytes(&clip_from_world.to_cols_array());
        let view = stage.buffer("view", Usage::STORAGE, &view)?;
        let surface = Surface {
            color: Vec4::new(0.27, 0.49, 0.18, 1.0),
            cutoff: 0.0,
            tiles: Vec2::ONE,
            tile_side: 1.0,
            corners: [Vec2::ZERO; 4],
        };
        stage.draw(
            view,
            &Drawn {
                program: Arc::new(LeafQuads {
                    texturing: Texturing::None,
                    blend: Blend::Opaque,
                }),
                vertices: &self.vertices,
                indices: Some(&self.indices),
                corners: u32::try_from(self.indices.len())?,
                storage: vec![surface.words().into_iter().map(f32::to_bits).collect()],
                texture: None,
                instances: &placements(trees),
            },
        )?;
        Ok(stage)
    }
}

fn measure(
    crown: &Crown,
    place: &'static str,
    see: See,
    trees: u32,
    options: &GrowthOptions,
) -> Result<Row, Fault> {
    let clip_from_world = see(side(trees))?;
    let (covered, covered_pixels) = {
        let mut stage = crown.stage(clip_from_world, trees, Counters::Exact)?;
        stage.frame()?;
        let covered = stage.ledger().work.map_or(0, |work| work.covered);
        let file = options.out.join(format!("{place}-{trees}.png"));
        std::fs::write(file, stage.picture()?.to_png()?)?;
        (covered, stage.covered_pixels()?)
    };
    let frames = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        pool.install(|| {
            let mut stage = crown.stage(clip_from_world, trees, Counters::Visible)?;
            let between = |stage: &mut Stage| drop(stage.ledger());
            Ok::<Frames, Fault>(time(options.schedule, &mut stage, Stage::frame, between)?)
        })
    };
    Ok(Row {
        place,
        trees,
        triangles: u64::from(trees) * crown.triangles(),
        covered_pixels,
        complexity: covered as f64 / f64::from(covered_pixels.max(1)),
        frames: [frames(1)?, frames(2)?],
    })
}

/// Trees along a side of the square.
fn along(trees: u32) -> u32 {
    (1..).find(|side| side * side >= trees).unwrap_or(1)
}

/// The side of the square in metres.
fn side(trees: u32) -> f32 {
    SPACING * along(trees) as f32
}

/// The matrices of trees that fill a square row by row, each turned and scaled a little.
fn placements(trees: u32) -> Vec<f32> {
    let along = along(trees);
    let mut draws = Stream::new(5, 0).draws();
    let place = |tree: u32| {
        let at = |place: u32| (place as f32 - 0.5 * (along - 1) as f32) * SPACING;
        let position = Vec3::new(at(tree % along), 0.0, at(tree / along));
        let turn = Quat::from_rotation_y(std::f32::consts::TAU * draws.unit());
        let scale = Vec3::splat(0.85 + 0.3 * draws.unit());
        Mat4::from_scale_rotation_translation(scale, turn, position).to_cols_array()
    };
    (0..trees).flat_map(place).collect()
}

fn above(side: f32) -> Result<Mat4, Fault> {
    let far = 0.75 * side + 14.0;
    let eye = Vec3::new(0.0, 4.0 + 0.574 * far * 1.5, 0.819 * far * 1.5);
    seen_from(eye, Vec3::new(0.0, 4.0, 0.0), 4.0 * far)
}

fn within(side: f32) -> Result<Mat4, Fault> {
    let eye = Vec3::new(0.5 * SPACING, 1.7, 0.5 * side + 8.0);
    seen_from(eye, eye + Vec3::new(0.0, 0.15, -1.0), side + 30.0)
}

fn seen_from(eye: Vec3, target: Vec3, far: f32) -> Result<Mat4, Fault> {
    let projection = Projection::Perspective {
        vertical_field_of_view: 40.0,
    };
    let key = CameraKey {
        frame: 0,
        eye,
        target,
    };
    let camera = Camera::new(projection, 0.1, far, vec![key])?;
    let size = ImageSize::new(SIZE[0], SIZE[1]).ok_or("a size that is none")?;
    Ok(camera.at(0, size).clip_from_world)
}

fn table(rows: &[Row]) -> Table {
    let numbers = [
        "trees",
        "triangles",
        "pixels covered",
        "depth complexity",
        "ms",
        "ms, one thread",
        "times faster",
        "ns a triangle",
        "others' cores",
    ];
    let mut columns = vec![Column::words("seen from")];
    columns.extend(numbers.map(Column::numbers));
    let number = |value: f64, digits: usize| Cell::Number { value, digits };
    let row = |row: &Row| {
        let [one, two] = [0, 1].map(|threads: usize| row.frames[threads].median());
        vec![
            Cell::Text(row.place.to_owned()),
            Cell::Count(row.trees.into()),
            Cell::Count(row.triangles),
            Cell::Count(row.covered_pixels.into()),
            number(row.complexity, 1),
            number(two, 1),
            number(one, 1),
            number(one / two.max(1e-9), 2),
            number(1e6 * two / row.triangles as f64, 1),
            number(row.frames[1].others, 2),
        ]
    };
    Table {
        columns,
        rows: rows.iter().map(row).collect(),
    }
}

fn plot(rows: &[Row]) -> Plot {
    let axis = |label: &str| Axis {
        label: label.to_owned(),
        scale: Scale::Log,
    };
    let mut series = Vec::new();
    for place in ["above", "within"] {
        for (index, threads) in [(1, "two threads"), (0, "one thread")] {
            let points = rows.iter().filter(|row| row.place == place);
            let points = points.map(|row| [row.triangles as f64, row.frames[index].median()]);
            series.push(Series {
                name: format!("{place}, {threads}"),
                points: points.collect(),
            });
        }
    }
    // What no growth slower than linear would be: from the first point on.
    if let Some(first) = rows.first() {
        let [from, to] = [first.triangles as f64, 1e8];
        let start = first.frames[1].median();
        series.push(Series {
            name: "in proportion".to_owned(),
            points: vec![[from, start], [to, start * to / from]],
        });
    }
    Plot {
        title: "A frame against the triangles of its scene".to_owned(),
        x: axis("triangles"),
        y: axis("a frame, ms"),
        series,
    }
}
