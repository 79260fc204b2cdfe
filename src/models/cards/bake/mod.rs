//! Baking: leaves as our own rasterizer sees them in parallel from given sides, once and for all.
//!
//! ```text
//! LeafTriangles ─┐                      ┌──▶ sheet of views ──read back──▶ samples ─┐
//!  BakeView, …  ─┴─ draws, many views ──┴──▶ the next sheet …                       └─▶ BakedView, …
//! ```
//!
//! A bake has a device of its own. Views are drawn side by side on sheets, targets of limited size, in
//! one pass each: [`bake_program`](super::bake_program) says how all that is wanted fits into one
//! colour. No light is baked in.

use std::sync::Arc;

use rayon::prelude::*;

use super::bake_program::{
    BAKE_MATERIAL_SLOT, BakeMaterial, BakeProgram, NORMAL_SLOT, SHEET_VIEW_SLOT, SheetView,
};
use super::bake_resolve::{BakedView, resolve};
use super::bake_sheet::{Place, Sheets};
use super::triangles::LeafTriangles;
use crate::gpu::{
    BufferId, Card, Cause, Command, Corners, Counters, Device, DeviceDescriptor, Draw, GpuError,
    Ledger, Link, Load, Options, RenderPass, Samples, Step, TargetDescriptor, TargetLayer,
    TextureId, TileSize, Usage,
};
use crate::math::{DVec3, Mat4, Vec2, Vec3, Vec4, index_u32};
use crate::models::surface::{filled, upload_texture};
use crate::plant::Texture;

/// One view to bake.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct BakeView {
    /// Which leaves are seen.
    pub(super) sites: BakeSites,
    /// From which side.
    pub(super) frame: ViewFrame,
    /// What of them.
    pub(super) rectangle: Rectangle,
    /// Texels a row, and rows.
    pub(super) size: [u32; 2],
}

/// Which leaf sites a view shows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum BakeSites {
    /// All.
    All,
    /// These, ascending.
    Listed(Vec<u32>),
}

/// Axes of a parallel view, in the plant's space; `right`, `up` and `toward` are perpendicular unit
/// vectors.
///
/// They may be left-handed: then leaves are seen as in a mirror, so that a view from behind with the
/// same `right` and `up` has its texels at the same places as that from in front.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ViewFrame {
    /// What lies at (0, 0), at offset 0.
    pub(super) origin: Vec3,
    /// Where columns go.
    pub(super) right: Vec3,
    /// Where rows come from: the first row is the uppermost.
    pub(super) up: Vec3,
    /// From what is seen to the viewer.
    pub(super) toward: Vec3,
}

impl ViewFrame {
    /// Where a point is seen: metres to the right and up of the origin.
    pub(super) fn seen(&self, point: Vec3) -> Vec2 {
        let point = point - self.origin;
        Vec2::new(point.dot(self.right), point.dot(self.up))
    }

    /// How far a point lies in front of the origin, towards the viewer, in metres.
    pub(super) fn offset(&self, point: Vec3) -> f32 {
        (point - self.origin).dot(self.toward)
    }

    /// The point that is seen at a place, at an offset.
    pub(super) fn point(&self, seen: Vec2, offset: f32) -> Vec3 {
        self.origin + self.right * seen.x + self.up * seen.y + self.toward * offset
    }

    /// The same place seen from behind: texels stay where they are.
    pub(super) fn behind(self) -> Self {
        Self {
            toward: -self.toward,
            ..self
        }
    }
}

/// What a view shows, in metres to the right and up of its frame's origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rectangle {
    /// The lower left corner.
    pub(super) least: Vec2,
    /// The upper right corner.
    pub(super) greatest: Vec2,
}

impl Rectangle {
    /// The least one around all points as a frame sees them, of no side below a tenth of a millimetre.
    pub(super) fn around(frame: &ViewFrame, points: impl Iterator<Item = Vec3>) -> Self {
        let (mut least, mut greatest) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for seen in points.map(|point| frame.seen(point)) {
            (least, greatest) = (least.min(seen), greatest.max(seen));
        }
        if !(least.is_finite() && greatest.is_finite()) {
            (least, greatest) = (Vec2::ZERO, Vec2::ZERO);
        }
        let missing = (Vec2::splat(LEAST_SIDE) - (greatest - least)).max(Vec2::ZERO);
        Self {
            least: least - 0.5 * missing,
            greatest: greatest + 0.5 * missing,
        }
    }

    /// Width and height.
    pub(super) fn sides(self) -> Vec2 {
        self.greatest - self.least
    }

    /// The texture coordinate of a point: (0, 0) at the upper left corner, (1, 1) at the lower right.
    #[inline(always)]
    pub(super) fn coordinate(self, seen: Vec2) -> Vec2 {
        let sides = self.sides();
        Vec2::new(
            (seen.x - self.least.x) / sides.x,
            (self.greatest.y - seen.y) / sides.y,
        )
    }

    /// The point at a texture coordinate.
    pub(super) fn at(self, coordinate: Vec2) -> Vec2 {
        let sides = self.sides();
        Vec2::new(
            self.least.x + coordinate.x * sides.x,
            self.greatest.y - coordinate.y * sides.y,
        )
    }
}

const LEAST_SIDE: f32 = 1e-4;

/// How to bake.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct BakeOptions {
    /// How many pixels along each side of a texel: 1 makes each texel wholly there or not at all, 2
    /// gives alpha in quarters. Leaves' own images are alpha-tested in each pixel.
    pub(super) supersampling: u32,
}

/// Baked views, in the order asked for.
#[derive(Debug, Clone)]
pub(super) struct Bake {
    /// What was seen.
    pub(super) views: Vec<BakedView>,
    /// What it cost on the device of the bake.
    pub(super) ledger: Ledger,
}

/// The most pixels of a sheet: 96 MiB of this machine.
const SHEET_PIXELS: u32 = 1 << 22;

/// Bakes views of leaves.
///
/// # Errors
///
/// [`GpuError::Descriptor`] for a view too large for a target.
pub(super) fn bake(
    leaves: &LeafTriangles,
    views: &[BakeView],
    options: BakeOptions,
) -> Result<Bake, GpuError> {
    bake_on_sheets(leaves, views, options, SHEET_PIXELS)
}

fn bake_on_sheets(
    leaves: &LeafTriangles,
    views: &[BakeView],
    options: BakeOptions,
    sheet_pixels: u32,
) -> Result<Bake, GpuError> {
    let factor = options.supersampling.max(1);
    let sizes: Vec<[u32; 2]> = views
        .iter()
        .map(|view| view.size.map(|side| side.saturating_mul(factor)))
        .collect();
    let sheets = Sheets::of(&sizes, sheet_pixels);
    let mut device = Device::new(offline_device());
    if views.is_empty() {
        return Ok(Bake {
            views: Vec::new(),
            ledger: device.take_ledger(),
        });
    }
    let target = device.create_target(&TargetDescriptor {
        label: "sheet",
        width: sheets.size[0],
        height: sheets.size[1],
        samples: Samples::One,
    })?;
    let depths: Vec<[f32; 2]> = views.par_iter().map(|view| depths(leaves, view)).collect();
    let stage = BakeStage::send(&mut device, leaves, views, (&sheets, &sizes, &depths))?;
    let mut baked: Vec<BakedView> = Vec::with_capacity(views.len());
    let mut seen = Vec::new();
    for numbers in sheets.places.chunk_by(|a, b| a.sheet == b.sheet) {
        let first = baked.len();
        let pass = RenderPass {
            label: "bake".to_owned(),
            target,
            load: Load::Clear {
                color: Vec4::ZERO,
                depth: 1.0,
            },
            steps: stage.steps(first..first + numbers.len()),
        };
        device.queue().submit(&[Command::Render(pass)])?;
        let (layer, cause) = (TargetLayer::Float, Cause::of("bake"));
        device
            .queue()
            .read_target_into(target, layer, cause, &mut seen)?;
        let (pixels, width) = (seen.as_chunks().0, sheets.size[0]);
        let resolved = numbers
            .par_iter()
            .zip(&views[first..])
            .zip(&depths[first..]);
        let resolved = resolved.map(|((place, view), &depths)| {
            let pixel = |x: u32, y: u32| {
                let at = (place.y + y) as usize * width as usize + (place.x + x) as usize;
                floats(pixels[at])
            };
            resolve(view.size, factor, depths, pixel)
        });
        baked.extend(resolved.collect::<Vec<_>>());
    }
    Ok(Bake {
        views: baked,
        ledger: device.take_ledger(),
    })
}

/// A pixel as it was read back: four little-endian `f32`.
fn floats(pixel: [u8; 16]) -> Vec4 {
    let [red, green, blue, alpha] = pixel.as_chunks().0 else {
        return Vec4::ZERO;
    };
    Vec4::from_array([red, green, blue, alpha].map(|four| f32::from_le_bytes(*four)))
}

/// A device that nobody's memory limits: what it does is done before anything is drawn for anyone.
fn offline_device() -> DeviceDescriptor {
    DeviceDescriptor {
        memory_bytes: 1 << 40,
        link: Link::named("pcie3x16").unwrap_or(Link::ALL[0]),
        card: Card::named("gtx770").unwrap_or(Card::ALL[0]),
        raster: Options {
            tile: TileSize::Side64,
            counters: Counters::Visible,
        },
    }
}

/// The offsets between which a view's leaves lie, the farthest first, with some room, since what
/// touches the ends of a view's depth may be cut off.
fn depths(leaves: &LeafTriangles, view: &BakeView) -> [f32; 2] {
    let (mut farthest, mut nearest) = (f32::INFINITY, f32::NEG_INFINITY);
    let mut add = |point: Vec3| {
        let offset = view.frame.offset(point);
        (farthest, nearest) = (farthest.min(offset), nearest.max(offset));
    };
    match &view.sites {
        BakeSites::All => leaves.corners(0..leaves.site_count()).for_each(&mut add),
        BakeSites::Listed(sites) => leaves.corners(sites.iter().copied()).for_each(&mut add),
    }
    if farthest > nearest {
        return [-LEAST_SIDE, LEAST_SIDE];
    }
    // A thousandth of the depth, and what `f32` rounds so far from the plant's origin.
    let size = view.frame.origin.length() + farthest.abs().max(nearest.abs());
    let room = 1e-3 * (nearest - farthest) + 1e-5 * size + 0.5 * LEAST_SIDE;
    [farthest - room, nearest + room]
}

/// From the plant to a sheet's clip space, so that a view's rectangle fills its pixels.
fn clip_from_plant(
    view: &BakeView,
    [farthest, nearest]: [f32; 2],
    (first, size): ([u32; 2], [u32; 2]),
    sheet: [u32; 2],
) -> Mat4 {
    let wide = |vector: Vec3| vector.as_dvec3();
    let (origin, rectangle) = (wide(view.frame.origin), view.rectangle);
    let row = |axis: DVec3, scale: f64, moved: f64| {
        let linear = axis * scale;
        (linear.extend(moved - linear.dot(origin))).as_vec4()
    };
    // Pixels from the left and from the top, in halves of the sheet.
    let along = |axis: usize, least: f32, greatest: f32| {
        let half = f64::from(sheet[axis]) / 2.0;
        let (first, size) = (f64::from(first[axis]) / half, f64::from(size[axis]) / half);
        let side = (f64::from(greatest) - f64::from(least)).max(f64::from(LEAST_SIDE));
        (first, size / side)
    };
    let (left, across) = along(0, rectangle.least.x, rectangle.greatest.x);
    let (top, down) = along(1, rectangle.least.y, rectangle.greatest.y);
    let (least_x, greatest_y) = (
        f64::from(rectangle.least.x),
        f64::from(rectangle.greatest.y),
    );
    let deep = 1.0 / (f64::from(nearest) - f64::from(farthest));
    Mat4::from_cols(
        row(
            wide(view.frame.right),
            across,
            left - 1.0 - across * least_x,
        ),
        row(wide(view.frame.up), down, 1.0 - top - down * greatest_y),
        row(wide(view.frame.toward), -deep, f64::from(nearest) * deep),
        Vec4::W,
    )
    .transpose()
}

/// What all passes of a bake are drawn with.
#[derive(Debug)]
struct BakeStage {
    /// Binds what all draws share.
    shared: Vec<Step>,
    groups: Vec<BakeGroup>,
}

/// Leaves of one material.
#[derive(Debug)]
struct BakeGroup {
    material: BufferId,
    texture: Option<TextureId>,
    /// Where the corners of each view come from, the first of them, and how many there are.
    runs: Vec<(Corners, u32, u32)>,
}

impl BakeStage {
    fn send(
        device: &mut Device,
        leaves: &LeafTriangles,
        views: &[BakeView],
        (sheets, sizes, depths): (&Sheets, &[[u32; 2]], &[[f32; 2]]),
    ) -> Result<Self, GpuError> {
        let program = device.create_program(Arc::new(BakeProgram));
        let (mut vertices, mut normals) = (Vec::new(), Vec::new());
        for triangle in leaves.all() {
            for (at, uv) in triangle.positions.iter().zip(&triangle.coordinates) {
                let floats = [at.x, at.y, at.z, uv.x, uv.y];
                vertices.extend(floats.into_iter().flat_map(f32::to_le_bytes));
            }
            let normal = triangle.normal.to_array().into_iter();
            normals.extend(normal.flat_map(f32::to_le_bytes));
        }
        let mut records = Vec::new();
        for (number, view) in views.iter().enumerate() {
            let (Place { x, y, .. }, size) = (sheets.places[number], sizes[number]);
            let clip = clip_from_plant(view, depths[number], ([x, y], size), sheets.size);
            let record = SheetView {
                clip_from_plant: clip,
                toward: view.frame.toward,
                pixels: [x, y, x + size[0], y + size[1]].map(|at| at as f32),
            };
            records.extend(record.to_bytes());
        }
        let (runs, indices) = runs(leaves, views);
        let mut fill = |label: &str, usage: Usage, bytes: &[u8]| {
            filled(device, label, usage, bytes, Cause::of("bake"))
        };
        let views = fill("bake views", Usage::STORAGE, &records)?;
        let normals = fill("bake normals", Usage::STORAGE, &normals)?;
        let vertices = fill("bake vertices", Usage::VERTEX, &vertices)?;
        let indices = fill("bake corners", Usage::INDEX, &indices)?;
        let storage = |(slot, buffer)| Step::Storage { slot, buffer };
        let mut shared = vec![
            Step::Program(program),
            Step::Vertices(vertices),
            Step::Indices(indices),
        ];
        shared.extend([(SHEET_VIEW_SLOT, views), (NORMAL_SLOT, normals)].map(storage));
        let mut known: Vec<((&Texture, f32), TextureId)> = Vec::new();
        let mut groups = Vec::new();
        for (group, runs) in leaves.groups().iter().zip(runs) {
            let material = &group.material;
            let bytes = BakeMaterial {
                base_color: Vec4::from_array(material.base_color),
                alpha_cutoff: material.alpha_cutoff,
            };
            let (usage, cause) = (Usage::STORAGE, Cause::of("bake"));
            let label = "bake material";
            groups.push(BakeGroup {
                material: filled(device, label, usage, &bytes.to_bytes(), cause)?,
                texture: match &material.texture {
                    None => None,
                    Some(texture) => {
                        let key = (texture, material.alpha_cutoff);
                        let found = known.iter().find(|(known, _)| *known == key);
                        Some(match found {
                            Some(&(_, id)) => id,
                            None => {
                                let cutoff = material.alpha_cutoff;
                                let id =
                                    upload_texture(device, "leaf texture", texture, cutoff, cause)?;
                                known.push((key, id));
                                id
                            }
                        })
                    }
                },
                runs,
            });
        }
        Ok(Self { shared, groups })
    }

    /// The steps that draw some views.
    fn steps(&self, views: std::ops::Range<usize>) -> Vec<Step> {
        let mut steps = self.shared.clone();
        for group in &self.groups {
            let (slot, buffer) = (BAKE_MATERIAL_SLOT, group.material);
            steps.push(Step::Storage { slot, buffer });
            steps.push(match group.texture {
                Some(texture) => Step::Texture { slot: 0, texture },
                None => Step::NoTexture { slot: 0 },
            });
            for view in views.clone() {
                let (source, first_corner, corner_count) = group.runs[view];
                if corner_count > 0 {
                    steps.push(Step::Draw(Draw {
                        source,
                        first_corner,
                        corner_count,
                        instance: index_u32(view),
                        group: 0,
                    }));
                }
            }
        }
        steps
    }
}

/// For each group the corners of each view, and the bytes of the indices of those that are listed.
#[expect(clippy::type_complexity, reason = "used in one place, just above")]
fn runs(leaves: &LeafTriangles, views: &[BakeView]) -> (Vec<Vec<(Corners, u32, u32)>>, Vec<u8>) {
    let mut indices: Vec<u8> = Vec::new();
    let mut runs = Vec::new();
    for group in leaves.groups() {
        let of_group = leaves.range(group.sites.clone());
        let run = |view: &BakeView| match &view.sites {
            BakeSites::All => {
                let count = of_group.end - of_group.start;
                (Corners::Counted, 3 * of_group.start, 3 * count)
            }
            BakeSites::Listed(sites) => {
                let first = index_u32(indices.len() / 4);
                let from = sites.partition_point(|site| *site < group.sites.start);
                let to = sites.partition_point(|site| *site < group.sites.end);
                for &site in &sites[from..to] {
                    let triangles = leaves.range(site..site + 1);
                    let corners = 3 * triangles.start..3 * triangles.end;
                    indices.extend(corners.flat_map(u32::to_le_bytes));
                }
                let count = index_u32(indices.len() / 4) - first;
                (Corners::Indexed, first, count)
            }
        };
        runs.push(views.iter().map(run).collect());
    }
    (runs, indices)
}

#[cfg(test)]
mod tests;
