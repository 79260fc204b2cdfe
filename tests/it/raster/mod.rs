//! The rasterizer against closed forms, drawn pictures and properties.

mod blending;
mod by_sample;
mod determinism;
mod lines;
mod pictures;
mod properties;
mod rules;

use spinney::math::{Vec2, Vec4};
use spinney::raster::{
    Batch, Blend, Counters, Fragment, Geometry, Kernel, Options, Pixel, Samples, Target, TileSize,
    Topology, Work,
};

/// Draws, and adds up the work of all batches.
#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "the face of the function it stands for"
)]
pub(crate) fn render(target: &mut Target, batches: &[Batch<'_>], options: &Options) -> Work {
    Work::total(&spinney::raster::render(target, batches, options))
}

pub(crate) const EXACT: Options = Options {
    tile: TileSize::Side64,
    counters: Counters::Exact,
};
pub(crate) const QUICK: Options = Options {
    tile: TileSize::Side32,
    counters: Counters::Visible,
};

/// One colour a primitive.
#[derive(Debug)]
pub(crate) struct Plain;

impl Fragment for Plain {
    const VARYINGS: usize = 0;
    const FLATS: usize = 4;
    const TESTS_ALPHA: bool = false;

    fn keeps(&self, _: &Pixel<'_>) -> bool {
        true
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        Vec4::from_slice(pixel.flats)
    }
}

/// Shows its two varyings as red and green and the depth as blue; white seen from behind.
#[derive(Debug)]
pub(crate) struct Coordinates;

impl Fragment for Coordinates {
    const VARYINGS: usize = 2;
    const FLATS: usize = 0;
    const TESTS_ALPHA: bool = false;

    fn keeps(&self, _: &Pixel<'_>) -> bool {
        true
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        if pixel.front {
            Vec4::new(pixel.varyings[0], pixel.varyings[1], pixel.depth, 1.0)
        } else {
            Vec4::ONE
        }
    }
}

/// A leaf of the kind `u² + v² < 1` in the unit square; three texels a test, five a colour.
#[derive(Debug)]
pub(crate) struct Quarter;

impl Fragment for Quarter {
    const VARYINGS: usize = 2;
    const FLATS: usize = 0;
    const TESTS_ALPHA: bool = true;
    const SHADES_LANES: bool = true;

    fn keeps(&self, pixel: &Pixel<'_>) -> bool {
        let [u, v] = [pixel.varyings[0], pixel.varyings[1]];
        u * u + v * v < 1.0
    }

    fn texels_tested(&self) -> u64 {
        3
    }

    fn texels_shaded(&self) -> u64 {
        5
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let steepness = (pixel.derivative_x + pixel.derivative_y * 2.0).dot(Vec2::ONE);
        Vec4::new(pixel.varyings[0], pixel.varyings[1], steepness, 0.5)
    }
}

/// A geometry in the making, its vertices in pixels of a target of some size.
#[derive(Debug, Clone)]
pub(crate) struct Drawing {
    pub(crate) size: [u32; 2],
    pub(crate) geometry: Geometry,
}

impl Drawing {
    pub(crate) fn new(width: u32, height: u32) -> Self {
        Self {
            size: [width, height],
            geometry: Geometry::default(),
        }
    }

    /// Adds a vertex at a pixel position and depth, with its number as id.
    pub(crate) fn vertex(&mut self, x: f32, y: f32, depth: f32, varyings: &[f32]) -> u32 {
        let [width, height] = self.size.map(|side| side as f32);
        let clip = Vec4::new(2.0 * x / width - 1.0, 1.0 - 2.0 * y / height, depth, 1.0);
        self.clip_vertex(clip, varyings)
    }

    pub(crate) fn clip_vertex(&mut self, clip: Vec4, varyings: &[f32]) -> u32 {
        let id = u32::try_from(self.geometry.clip.len()).expect("tests are small");
        self.geometry.clip.push(clip);
        self.geometry.varyings.extend_from_slice(varyings);
        self.geometry.vertex_ids.push(id);
        id
    }

    /// Adds a primitive with new vertices at a depth, without varyings, in a colour.
    pub(crate) fn shape(&mut self, corners: &[[f32; 2]], depth: f32, colour: [f32; 4]) {
        for &[x, y] in corners {
            let id = self.vertex(x, y, depth, &[]);
            self.geometry.corners.push(id);
        }
        self.geometry.flats.extend_from_slice(&colour);
    }

    /// Adds a quad from corner to corner with texture coordinates over the unit square.
    pub(crate) fn leaf(&mut self, from: [f32; 2], to: [f32; 2], depth: f32) {
        let corners = [
            ([from[0], from[1]], [0.0, 0.0]),
            ([from[0], to[1]], [0.0, 1.0]),
            ([to[0], to[1]], [1.0, 1.0]),
            ([to[0], from[1]], [1.0, 0.0]),
        ];
        for ([x, y], uv) in corners {
            let id = self.vertex(x, y, depth, &uv);
            self.geometry.corners.push(id);
        }
    }

    pub(crate) fn batch<'a>(&'a self, topology: Topology, kernel: &'a dyn Kernel) -> Batch<'a> {
        batch(&self.geometry, topology, kernel)
    }

    pub(crate) fn render(&self, topology: Topology, kernel: &dyn Kernel) -> (Target, Work) {
        self.render_with(topology, kernel, Samples::One, EXACT)
    }

    pub(crate) fn render_with(
        &self,
        topology: Topology,
        kernel: &dyn Kernel,
        samples: Samples,
        options: Options,
    ) -> (Target, Work) {
        let mut target = Target::new(self.size[0], self.size[1], samples);
        let work = render(&mut target, &[self.batch(topology, kernel)], &options);
        (target, work)
    }
}

pub(crate) fn batch<'a>(
    geometry: &'a Geometry,
    topology: Topology,
    kernel: &'a dyn Kernel,
) -> Batch<'a> {
    Batch {
        geometry,
        topology,
        kernel,
        blend: Blend::Opaque,
        group: 0,
        instance: 0,
    }
}

/// What shows, a letter a primitive of `corners` vertices each, `.` for nothing.
pub(crate) fn letters(target: &Target, corners: u32) -> String {
    let mut text = String::new();
    for y in 0..target.height() {
        for x in 0..target.width() {
            text.push(target.key(x, y).map_or('.', |key| {
                char::from_u32(u32::from(b'a') + key.vertex / corners).unwrap_or('?')
            }));
        }
        text.push('\n');
    }
    text
}

/// Colour, depth and key of all pixels, and the picture: all that can differ.
pub(crate) fn contents(target: &Target) -> Vec<u32> {
    let mut words = Vec::new();
    for (colour, index) in target.linear().iter().zip(0..) {
        let (x, y) = (index % target.width(), index / target.width());
        words.extend(colour.to_array().map(f32::to_bits));
        words.push(target.depth(x, y).to_bits());
        match target.key(x, y) {
            Some(key) => words.extend([key.group, key.instance, key.vertex, key.triangle]),
            None => words.push(u32::MAX),
        }
    }
    words
}
