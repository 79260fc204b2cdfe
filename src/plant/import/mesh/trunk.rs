//! All that is not foliage: one mesh of trunk and branches.

use super::{Materials, Part};
use crate::math::{DVec3, Vec3, index_u32};
use crate::plant::Mesh;
use crate::plant::import::{ImportReport, ReportKind};
use std::collections::BTreeMap;

/// Joins parts to one mesh, with the material that most of its triangles have.
///
/// # Errors
///
/// As [`Materials::read`].
pub(super) fn join<M: Materials>(
    parts: Vec<Part>,
    materials: &mut M,
    report: &mut ImportReport,
) -> Result<Option<Mesh>, M::Fault> {
    let mut counts: BTreeMap<Option<usize>, (u64, String)> = BTreeMap::new();
    for part in &parts {
        let count = part.triangles.len() as u64;
        let entry = counts.entry(part.material);
        entry.or_insert_with(|| (0, part.place.clone())).0 += count;
    }
    let total: u64 = counts.values().map(|(count, _)| count).sum();
    report.trunk_triangles += total;
    if total == 0 {
        return Ok(None);
    }
    let mut main = (0, None);
    for (&material, &(count, _)) in &counts {
        if count > main.0 {
            main = (count, material);
        }
    }
    let material = materials.read(main.1, report)?;
    for (index, (count, place)) in counts.into_iter().filter(|(index, _)| *index != main.1) {
        let message = format!(
            "triangles of wood with material {}: they take {:?}, which most wood has",
            index.map_or("default".to_owned(), |index| materials.title(index)),
            material.name
        );
        report.add(ReportKind::Merged, count, place, message);
    }
    let mut mesh = Mesh {
        positions: Vec::new(),
        normals: Vec::new(),
        texture_coordinates: Vec::new(),
        indices: Vec::new(),
        material,
    };
    let place = parts
        .first()
        .map_or(String::new(), |part| part.place.clone());
    // By value, so that a part's memory is free again once it is joined.
    for part in parts {
        let offset = index_u32(mesh.positions.len());
        mesh.positions.extend(part.positions);
        mesh.normals.extend(part.normals);
        mesh.texture_coordinates.extend(part.coordinates);
        let indices = part.triangles.iter().flatten().map(|index| index + offset);
        mesh.indices.extend(indices);
    }
    fill_normals(&mut mesh, &place, report);
    Ok(Some(mesh))
}

/// Gives vertices without a normal the mean of their triangles' normals, weighted by area.
fn fill_normals(mesh: &mut Mesh, place: &str, report: &mut ImportReport) {
    let is_missing: Vec<bool> = mesh
        .normals
        .iter()
        .map(|&normal| normal == Vec3::ZERO)
        .collect();
    let missing = is_missing.iter().filter(|&&missing| missing).count();
    if missing == 0 {
        return;
    }
    // In double precision, so that neither tiny nor vast triangles lose their direction.
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    for triangle in mesh.indices.chunks_exact(3) {
        let corners = [0, 1, 2].map(|corner| triangle[corner] as usize);
        let [a, b, c] = corners.map(|vertex| mesh.positions[vertex].as_dvec3());
        let normal = (b - a).cross(c - a);
        for vertex in corners {
            sums[vertex] += normal;
        }
    }
    for (vertex, sum) in sums.iter().enumerate() {
        if is_missing[vertex] {
            mesh.normals[vertex] = sum.normalize_or(DVec3::Y).as_vec3();
        }
    }
    let message = "vertices of wood without a normal: computed from the triangles around them";
    report.add(ReportKind::Guessed, missing as u64, place, message);
}
