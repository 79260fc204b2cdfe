//! Simplified trunks in the cache.
//!
//! | bytes of the model | content |
//! |---:|---|
//! | 0–23 | how many vertices, of them go, collapses, vertices of strips, strips, and triangles in them: `V`, `G`, `C`, `P`, `S`, `T`, `u32` |
//! | 4 V | the order of vertices, `u32` |
//! | 4 G | their targets, `u32` |
//! | 4 (C + 1) | the first vertex at each level, `u32` |
//! | 12 C | of every collapse the bits of its cost (`f64`) and error (`f32`) |
//! | 4 P, 4 (S + 1), 4 T | strips: vertices, where each begins, triangles, `u32` |

use super::cache::ModelCache;
use crate::math::{Digest, Digester, Vec2, Vec3};
use crate::models::TrunkSimplifier;
use crate::plant::Mesh;
use crate::simplify::{
    SimplifiedMesh, SimplifiedParts, VERTEX_COLLAPSE_VERSION, VertexCollapseOptions, simplify_mesh,
};

/// The kind of [`SimplifiedMesh`].
const TRUNKS: u32 = 2;

impl TrunkSimplifier for ModelCache {
    /// [`simplify_mesh`], read where that was done before.
    fn simplify(&self, mesh: &Mesh, options: VertexCollapseOptions) -> SimplifiedMesh {
        self.kept_or_built(
            (TRUNKS, key(mesh, options)),
            most_bytes(mesh),
            |model| read(model, mesh),
            || simplify_mesh(mesh, options),
            write,
        )
    }
}

/// The digest of all that decides the collapses: BLAKE3 over the domain `spinney.cache.trunk/1`, the
/// version, the number of triangles to stop at, positions, normals, texture coordinates, indices.
fn key(mesh: &Mesh, options: VertexCollapseOptions) -> Digest {
    let VertexCollapseOptions { stop_triangles } = options;
    let mut digester = Digester::new("spinney.cache.trunk/1");
    digester.u32(VERTEX_COLLAPSE_VERSION).u32(stop_triangles);
    let vectors = |vectors: &[Vec3]| -> Vec<u8> {
        let floats = vectors.iter().flat_map(Vec3::to_array);
        floats.flat_map(f32::to_le_bytes).collect()
    };
    digester.bytes(&vectors(&mesh.positions));
    digester.bytes(&vectors(&mesh.normals));
    let coordinates = mesh.texture_coordinates.iter().flat_map(Vec2::to_array);
    digester.bytes(&coordinates.flat_map(f32::to_le_bytes).collect::<Vec<u8>>());
    let indices = mesh.indices.iter().flat_map(|index| index.to_le_bytes());
    digester.bytes(&indices.collect::<Vec<u8>>()).finish()
}

/// The most that a mesh's model takes: every vertex goes by itself, every triangle is a strip.
fn most_bytes(mesh: &Mesh) -> u64 {
    let triangles = u64::from(mesh.triangle_count());
    32 + 24 * mesh.positions.len() as u64 + 20 * triangles
}

fn write(simplified: &SimplifiedMesh) -> Vec<u8> {
    let parts = simplified.parts();
    let mut bytes = Vec::new();
    let mut put = |words: &[u32]| bytes.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    put(&[
        parts.order.len(),
        parts.targets.len(),
        parts.steps.len(),
        parts.strip_vertices.len(),
        parts.strip_starts.len() - 1,
        parts.strip_triangles.len(),
    ]
    .map(crate::math::index_u32));
    put(&parts.order);
    put(&parts.targets);
    put(&parts.starts);
    for (cost, error) in parts.steps {
        let cost = cost.to_le_bytes();
        let (words, _) = cost.as_chunks::<4>();
        put(&[
            u32::from_le_bytes(words[0]),
            u32::from_le_bytes(words[1]),
            error.to_bits(),
        ]);
    }
    put(&parts.strip_vertices);
    put(&parts.strip_starts);
    put(&parts.strip_triangles);
    bytes
}

/// What is kept of a mesh, if it is sound.
fn read(bytes: &[u8], mesh: &Mesh) -> Option<SimplifiedMesh> {
    let (words, rest) = bytes.as_chunks::<4>();
    let words: Vec<u32> = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
    let (&counts, words) = words.split_first_chunk::<6>()?;
    let [order, targets, collapses, places, strips, triangles] = counts.map(|count| count as usize);
    let mut words = words;
    let mut take = |count: usize| {
        let (taken, left) = words.split_at_checked(count)?;
        words = left;
        Some(taken.to_vec())
    };
    let parts = SimplifiedParts {
        order: take(order)?,
        targets: take(targets)?,
        starts: take(collapses.checked_add(1)?)?,
        steps: {
            let words = take(collapses.checked_mul(3)?)?;
            let steps = words.as_chunks::<3>().0.iter().map(|&[low, high, error]| {
                let cost = u64::from(high) << 32 | u64::from(low);
                (f64::from_bits(cost), f32::from_bits(error))
            });
            steps.collect()
        },
        strip_vertices: take(places)?,
        strip_starts: take(strips.checked_add(1)?)?,
        strip_triangles: take(triangles)?,
    };
    let ends = rest.is_empty() && words.is_empty();
    ends.then(|| SimplifiedMesh::restored(mesh, parts))?
}

#[cfg(test)]
mod tests {
    use super::super::CacheLimit;
    use super::*;
    use crate::math::Stream;
    use crate::plant::Material;

    /// A bent sheet with a seam: its last column of vertices stands where that before it does.
    fn sheet(seed: u64) -> Mesh {
        const SIDE: u32 = 7;
        let mut draws = Stream::new(seed, 0).draws();
        let mut mesh = Mesh {
            positions: Vec::new(),
            normals: Vec::new(),
            texture_coordinates: Vec::new(),
            indices: Vec::new(),
            material: Material::plain("bark", [0.5; 3]),
        };
        for (row, column) in (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (row, column))) {
            let height = 0.3
                * if column < SIDE - 2 {
                    draws.signed()
                } else {
                    0.0
                };
            let across = column.min(SIDE - 2) as f32;
            mesh.positions.push(Vec3::new(across, row as f32, height));
            mesh.normals.push(Vec3::Z);
            mesh.texture_coordinates.push(Vec2::new(column as f32, 0.0));
        }
        for (row, column) in (1..SIDE).flat_map(|row| (1..SIDE).map(move |column| (row, column))) {
            let [a, b] = [(row - 1) * SIDE + column - 1, row * SIDE + column - 1];
            mesh.indices.extend([a, a + 1, b, a + 1, b + 1, b]);
        }
        mesh
    }

    const OPTIONS: VertexCollapseOptions = VertexCollapseOptions { stop_triangles: 4 };

    #[test]
    fn a_hit_is_what_was_built_and_anything_else_is_built_anew() {
        let folder = tempfile::tempdir().unwrap();
        let cache = ModelCache::new(folder.path().to_owned(), CacheLimit::USUAL);
        let mesh = sheet(1);
        let built = simplify_mesh(&mesh, OPTIONS);
        assert!(built.collapses.collapse_count() > 5);
        assert_eq!(cache.simplify(&mesh, OPTIONS), built);
        let model = write(&built);
        assert!(model.len() as u64 <= most_bytes(&mesh));
        assert_eq!(read(&model, &mesh).as_ref(), Some(&built));
        let mut entries = std::fs::read_dir(folder.path()).unwrap();
        let path = entries.next().unwrap().unwrap().path();
        assert!(entries.next().is_none(), "one file");
        let sound = std::fs::read(&path).unwrap();
        for at in [0, 8, 12, 60, 84, 100, sound.len() - 1] {
            let mut tampered = sound.clone();
            tampered[at] ^= 0x40;
            std::fs::write(&path, tampered).unwrap();
            assert_eq!(cache.simplify(&mesh, OPTIONS), built, "byte {at}");
            assert_eq!(std::fs::read(&path).unwrap(), sound, "byte {at}");
        }
    }

    /// Digests do not tell who wrote a file: whatever words are changed, what is read is sound or
    /// nothing, and never the cause of a panic.
    #[test]
    fn words_that_are_not_a_sound_model_are_refused() {
        let mesh = sheet(2);
        let built = simplify_mesh(&mesh, OPTIONS);
        let model = write(&built);
        let steps = built.collapses.steps().len();
        let parts = built.parts();
        let costs = 6 + parts.order.len() + parts.targets.len() + parts.starts.len();
        let words = model.len() / 4;
        for word in 0..words {
            // What collapses cost decides nothing, so other sound numbers are as good.
            let is_cost = (costs..costs + 3 * steps).contains(&word);
            for value in [0, 1, 7, u32::MAX - 3, u32::MAX] {
                let mut other = model.clone();
                other[4 * word..][..4].copy_from_slice(&u32::to_le_bytes(value));
                if other != model && !is_cost {
                    let found = read(&other, &mesh);
                    // A target may be another vertex of the same point, a seam's other side.
                    let same = found.is_none_or(|found| {
                        let [one, other] = [&found, &built].map(|one| one.parts());
                        one.order == other.order && one.starts == other.starts
                    });
                    assert!(same, "word {word} as {value}");
                }
            }
        }
        assert!(read(&model[..model.len() - 4], &mesh).is_none());
        assert!(read(&[&model[..], &[0; 4]].concat(), &mesh).is_none());
        assert!(
            read(
                &model,
                &Mesh {
                    indices: mesh.indices[3..].to_vec(),
                    ..mesh
                }
            )
            .is_none()
        );
    }

    #[test]
    fn all_of_the_mesh_and_where_it_stops_decide_the_key() {
        let mesh = sheet(3);
        let first = key(&mesh, OPTIONS);
        assert_ne!(
            key(&mesh, VertexCollapseOptions { stop_triangles: 5 }),
            first
        );
        let changed = |change: fn(&mut Mesh)| {
            let mut other = mesh.clone();
            change(&mut other);
            key(&other, OPTIONS)
        };
        for other in [
            changed(|mesh| mesh.positions[3].x += 1.0),
            changed(|mesh| mesh.normals[3].x += 1.0),
            changed(|mesh| mesh.texture_coordinates[3].x += 1.0),
            changed(|mesh| mesh.indices.swap(0, 1)),
        ] {
            assert_ne!(other, first);
        }
        // What it looks like does not.
        assert_eq!(changed(|mesh| mesh.material.alpha_cutoff = 0.5), first);
    }
}
