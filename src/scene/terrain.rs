//! Terrain: the ground that forests stand on.
//!
//! A square of cells, two triangles each. Its corners lie on a sum of waves of gradient noise
//! ([P02](crate::references)), each half as long and half as high as the one before.
//!
//! **Invariant.** [`Terrain::height`] is that of the triangles that are drawn, so what stands there
//! neither floats nor sinks.

use crate::math::{Stream, Vec2, Vec3};
use crate::plant::{Material, Mesh, Texture};

use super::forest::Area;

/// The ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terrain {
    /// The side of the square, whose middle is the world's: metres, above 0.
    pub size: f32,
    /// Cells a side, at least 1.
    pub cells: u32,
    /// The height of the longest waves: metres; together all stay within twice as much.
    pub amplitude: f32,
    /// The length of the longest waves: metres, above 0.
    pub wavelength: f32,
    /// How many waves are added, each half as long and half as high as the one before.
    pub octaves: u32,
    /// Where the waves come from.
    pub seed: u64,
    /// The colour of level ground: sRGB, 8 bits a channel.
    pub color: [u8; 3],
    /// The colour of ground that rises one to one, or steeper; between, both mix.
    pub steep_color: [u8; 3],
}

/// The stream of a terrain's waves.
const WAVES: u64 = 0x7465_7272_6169;

impl Terrain {
    /// The ground that it covers.
    #[must_use]
    pub fn area(&self) -> Area {
        Area::around_origin(self.size)
    }

    /// The height of the ground that is drawn at a place; beyond the rim, of the rim.
    #[must_use]
    pub fn height(&self, x: f32, z: f32) -> f32 {
        let cells = f64::from(self.cells);
        let [(column, across), (row, along)] = [x, z].map(|at| {
            let cell = (f64::from(at) / f64::from(self.size) + 0.5) * cells;
            let cell = cell.clamp(0.0, cells);
            let first = cell.floor().min(cells - 1.0);
            (whole(first), cell - first)
        });
        let at = |column, row| f64::from(self.corner(column, row).y);
        let first = at(column, row);
        let last = at(column + 1, row + 1);
        // The two triangles share the line from the first corner to the last.
        let height = if across >= along {
            let middle = at(column + 1, row);
            first + across * (middle - first) + along * (last - middle)
        } else {
            let middle = at(column, row + 1);
            first + along * (middle - first) + across * (last - middle)
        };
        rounded(height)
    }

    /// A corner of the cells: column and row from 0 to [`cells`](Self::cells).
    #[must_use]
    pub fn corner(&self, column: i64, row: i64) -> Vec3 {
        let [x, z] = self.place(column, row);
        Vec3::new(rounded(x), rounded(self.wave(x, z)), rounded(z))
    }

    /// The ground as a mesh: corners row by row, then two triangles a cell.
    #[must_use]
    pub fn mesh(&self) -> Mesh {
        let cells = i64::from(self.cells);
        let corners = || (0..=cells).flat_map(move |row| (0..=cells).map(move |c| (c, row)));
        let slopes: Vec<Vec2> = corners().map(|(c, row)| self.slope(c, row)).collect();
        let normal = |slope: &Vec2| Vec3::new(-slope.x, 1.0, -slope.y).normalize();
        // Between the middles of the texture's two texels, where colours mix linearly.
        let shade = |slope: &Vec2| Vec2::new(0.25 + 0.5 * slope.length().min(1.0), 0.5);
        let width = self.cells + 1;
        let cell = |(column, row): (u32, u32)| {
            let first = row * width + column;
            let [right, below, last] = [first + 1, first + width, first + width + 1];
            [first, below, last, first, last, right]
        };
        let places = (0..self.cells).flat_map(|row| (0..self.cells).map(move |c| (c, row)));
        Mesh {
            positions: corners().map(|(c, row)| self.corner(c, row)).collect(),
            normals: slopes.iter().map(normal).collect(),
            texture_coordinates: slopes.iter().map(shade).collect(),
            indices: places.flat_map(cell).collect(),
            material: Material {
                texture: Some(self.colors()),
                ..Material::plain("ground", [1.0; 3])
            },
        }
    }

    /// Two texels: level ground, steep ground.
    fn colors(&self) -> Texture {
        let rgba = [self.color, self.steep_color].map(|[r, g, b]| [r, g, b, 255]);
        Texture::new(2, 1, rgba.concat()).expect("two texels of four bytes")
    }

    fn place(&self, column: i64, row: i64) -> [f64; 2] {
        [column, row].map(|step| (step as f64 / f64::from(self.cells) - 0.5) * f64::from(self.size))
    }

    /// How the ground rises along x and along z, from the corners beside.
    fn slope(&self, column: i64, row: i64) -> Vec2 {
        let rise = |one: [i64; 2], other: [i64; 2]| {
            let [low, high] = [one, other].map(|[column, row]| {
                let [x, z] = self.place(column, row);
                self.wave(x, z)
            });
            rounded((high - low) * f64::from(self.cells) / (2.0 * f64::from(self.size)))
        };
        Vec2::new(
            rise([column - 1, row], [column + 1, row]),
            rise([column, row - 1], [column, row + 1]),
        )
    }

    /// The sum of all waves at a place.
    fn wave(&self, x: f64, z: f64) -> f64 {
        let stream = Stream::new(self.seed, WAVES);
        let mut height = 0.0;
        let (mut amplitude, mut scale) =
            (f64::from(self.amplitude), 1.0 / f64::from(self.wavelength));
        for octave in 0..u64::from(self.octaves) {
            height += amplitude * gradient_noise(stream.child(octave), x * scale, z * scale);
            amplitude *= 0.5;
            scale *= 2.0;
        }
        height
    }
}

/// Gradient noise over the integer lattice: 0 at each lattice point, within [−1, 1] between, its
/// first two derivatives continuous.
fn gradient_noise(stream: Stream, x: f64, z: f64) -> f64 {
    let (first, offset) = ([x.floor(), z.floor()], [x - x.floor(), z - z.floor()]);
    let [fade_x, fade_z] = offset.map(|t| t * t * t * (t * (t * 6.0 - 15.0) + 10.0));
    let corner = |right: f64, down: f64| {
        let point = [first[0] + right, first[1] + down].map(|at| whole(at).cast_unsigned());
        let slopes = stream.child(point[0]).child(point[1]);
        let [along, across] = [0, 1].map(|axis| f64::from(slopes.signed(axis)));
        along * (offset[0] - right) + across * (offset[1] - down)
    };
    let mix = |a: f64, b: f64, t: f64| a + t * (b - a);
    mix(
        mix(corner(0.0, 0.0), corner(1.0, 0.0), fade_x),
        mix(corner(0.0, 1.0), corner(1.0, 1.0), fade_x),
        fade_z,
    )
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "a whole number becomes an integer by the language's saturating cast"
)]
fn whole(number: f64) -> i64 {
    number as i64
}

#[expect(clippy::cast_possible_truncation, reason = "rounded once, at the end")]
fn rounded(number: f64) -> f32 {
    number as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn terrain() -> Terrain {
        Terrain {
            size: 40.0,
            cells: 8,
            amplitude: 3.0,
            wavelength: 17.0,
            octaves: 3,
            seed: 9,
            color: [90, 100, 60],
            steep_color: [120, 110, 90],
        }
    }

    #[test]
    fn heights_are_those_of_the_mesh() {
        let ground = terrain();
        let mesh = ground.mesh();
        assert_eq!(mesh.positions.len(), 81);
        assert_eq!(mesh.triangle_count(), 128);
        for triangle in mesh.indices.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|k| mesh.positions[triangle[k] as usize]);
            assert!((b - a).cross(c - a).y > 0.0, "seen from above");
            for weights in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.25, 0.25]] {
                let [wa, wb, wc] = weights;
                let point = a * wa + b * wb + c * wc;
                let height = ground.height(point.x, point.z);
                assert!((height - point.y).abs() < 1e-4, "{point} {height}");
            }
        }
        assert!(mesh.positions.iter().any(|corner| corner.y.abs() > 0.2));
        assert!(mesh.positions.iter().all(|corner| corner.y.abs() <= 6.0));
        assert!(mesh.normals.iter().all(|n| n.y > 0.0 && n.is_normalized()));
        assert_eq!(ground.height(1e5, 1e5), mesh.positions[80].y, "of the rim");
    }

    #[test]
    fn noise_is_nothing_at_the_lattice_and_smooth_across_it() {
        let stream = Stream::new(1, 2);
        for (x, z) in [(0.0, 0.0), (-3.0, 7.0), (1e6, -1e6)] {
            assert_eq!(gradient_noise(stream, x, z), 0.0);
        }
        let [before, after] = [-1e-6, 1e-6].map(|off| gradient_noise(stream, 4.0 + off, 0.5));
        assert!((before - after).abs() < 1e-5, "{before} {after}");
        let flat = Terrain {
            amplitude: 0.0,
            ..terrain()
        };
        assert_eq!(flat.height(3.3, -7.0), 0.0);
    }
}
