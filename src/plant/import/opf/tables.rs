//! The tables at a document's head: reference meshes, materials, shapes.

use super::xml::{Xml, child};
use crate::limits::PLACED_CORNERS;
use crate::math::{DVec3, Vec2, index_u32};
use crate::plant::Material;
use crate::plant::import::{ImportError, ImportReport, ReportKind};
use crate::plant::texture::linear_of_srgb;
use roxmltree::Node;
use std::collections::BTreeMap;

/// The tables by their rows' numbers.
#[derive(Debug)]
pub(super) struct Tables {
    pub(super) shapes: BTreeMap<i64, Shape>,
    pub(super) meshes: Vec<RefMesh>,
    pub(super) materials: Vec<Material>,
}

/// A mesh and what it looks like.
#[derive(Debug)]
pub(super) struct Shape {
    pub(super) name: String,
    /// Among the tables' meshes.
    pub(super) mesh: usize,
    /// Among the tables' materials, if it has one.
    pub(super) material: Option<usize>,
}

/// A mesh that organs share.
#[derive(Debug)]
pub(super) struct RefMesh {
    pub(super) points: Vec<DVec3>,
    pub(super) coordinates: Vec<Vec2>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Whether organs widen it by their diameters.
    pub(super) is_scaled: bool,
    /// The least and greatest x.
    pub(super) ends: [f64; 2],
    /// Its radius, if it is a cylinder along x.
    pub(super) cylinder: Option<f64>,
}

impl Tables {
    pub(super) fn read(xml: &Xml<'_>, report: &mut ImportReport) -> Result<Self, ImportError> {
        let root = xml.document.root_element();
        if !root.has_tag_name("opf") {
            let name = root.tag_name().name();
            return Err(xml.error(root, format!("the document is <{name}>, wanted <opf>")));
        }
        let mut tables = Self {
            shapes: BTreeMap::new(),
            meshes: Vec::new(),
            materials: Vec::new(),
        };
        let mut mesh_rows = BTreeMap::new();
        let mut corners = 0;
        for row in rows(root, "meshBDD", "mesh") {
            let mesh = mesh(xml, row, &mut corners, report)?;
            mesh_rows.insert(xml.own_id(row)?, tables.meshes.len());
            tables.meshes.push(mesh);
        }
        let mut material_rows = BTreeMap::new();
        for row in rows(root, "materialBDD", "material") {
            let id = xml.own_id(row)?;
            material_rows.insert(id, tables.materials.len());
            let material = material(xml, row, id, report)?;
            tables.materials.push(material);
        }
        for row in rows(root, "shapeBDD", "shape") {
            let Some(index) = child(row, "meshIndex") else {
                return Err(xml.error(row, "a shape without meshIndex"));
            };
            let number = xml.id(index)?;
            let Some(&mesh) = mesh_rows.get(&number) else {
                let count = tables.meshes.len();
                let message =
                    format!("names mesh {number}, which is none of the {count} of meshBDD");
                return Err(xml.error(index, message));
            };
            let material = match child(row, "materialIndex") {
                None => None,
                Some(index) => {
                    let number = xml.id(index)?;
                    let known = material_rows.get(&number).copied();
                    if known.is_none() {
                        let message = "materials that shapes name, but materialBDD lacks: white";
                        let place = format!("line {}", xml.line(index));
                        report.add(ReportKind::Missing, 1, place, message);
                    }
                    known
                }
            };
            let name = child(row, "name").and_then(|name| name.text());
            let shape = Shape {
                name: name.unwrap_or_default().trim().to_owned(),
                mesh,
                material,
            };
            tables.shapes.insert(xml.own_id(row)?, shape);
        }
        Ok(tables)
    }
}

/// The rows of a table.
fn rows<'a, 'i>(
    root: Node<'a, 'i>,
    table: &'static str,
    row: &'static str,
) -> impl Iterator<Item = Node<'a, 'i>> {
    let tables = root.children().filter(move |node| node.has_tag_name(table));
    tables.flat_map(move |table| table.children().filter(move |node| node.has_tag_name(row)))
}

fn mesh(
    xml: &Xml<'_>,
    row: Node<'_, '_>,
    corners: &mut u64,
    report: &mut ImportReport,
) -> Result<RefMesh, ImportError> {
    let (Some(points), Some(faces)) = (child(row, "points"), child(row, "faces")) else {
        return Err(xml.error(row, "a mesh without points or faces"));
    };
    let numbers = xml.numbers(points)?;
    if numbers.len() % 3 != 0 {
        let message = format!(
            "points hold {} numbers, wanted three a point",
            numbers.len()
        );
        return Err(xml.error(points, message));
    }
    let points: Vec<DVec3> = numbers.chunks_exact(3).map(DVec3::from_slice).collect();
    let mut coordinates = vec![Vec2::ZERO; points.len()];
    if let Some(node) = child(row, "textureCoords") {
        let numbers = xml.numbers(node)?;
        let is_whole = numbers.len() == 2 * points.len();
        if !is_whole && !numbers.is_empty() {
            let message = "texture coordinates that are not two a point: left out";
            let place = format!("line {}", xml.line(node));
            report.add(ReportKind::Dropped, 1, place, message);
        }
        if is_whole {
            for (own, found) in coordinates.iter_mut().zip(numbers.chunks_exact(2)) {
                #[expect(
                    clippy::cast_possible_truncation,
                    reason = "infinities are refused below"
                )]
                let corner = Vec2::new(found[0] as f32, (1.0 - found[1]) as f32);
                if !corner.is_finite() {
                    let message = format!("textureCoords hold {}, wanted smaller ones", found[0]);
                    return Err(xml.error(node, message));
                }
                *own = corner;
            }
        }
    }
    let mut triangles = Vec::new();
    for face in faces.children().filter(|node| node.has_tag_name("face")) {
        let mut indices = Vec::new();
        for word in face.text().unwrap_or_default().split_ascii_whitespace() {
            let index = word
                .parse::<usize>()
                .ok()
                .filter(|&index| index < points.len());
            let Some(index) = index else {
                let count = points.len();
                let message = format!("names point {word}, but there are {count}");
                return Err(xml.error(face, message));
            };
            indices.push(index_u32(index));
        }
        let [first, rest @ ..] = indices.as_slice() else {
            continue;
        };
        *corners += 3 * rest.len().saturating_sub(1) as u64;
        if *corners > PLACED_CORNERS {
            let message = format!(
                "{corners} triangle corners exceed the limit of {PLACED_CORNERS}; simplify the meshes"
            );
            return Err(xml.error(face, message));
        }
        for pair in rest.windows(2) {
            let [a, b, c] = [*first, pair[0], pair[1]];
            if a != b && b != c && c != a {
                triangles.push([a, b, c]);
            }
        }
    }
    let xs = points.iter().map(|point| point.x);
    let ends = xs.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], x| {
        [least.min(x), most.max(x)]
    });
    let is_scaled = row
        .attribute("enableScale")
        .is_some_and(|told| told.trim().eq_ignore_ascii_case("true"));
    Ok(RefMesh {
        cylinder: cylinder(&points, ends),
        points,
        coordinates,
        triangles,
        is_scaled,
        ends,
    })
}

/// The radius of a cylinder along x: all points lie on two circles of one size around it, three or more on
/// each, or are their centres.
fn cylinder(points: &[DVec3], [first, last]: [f64; 2]) -> Option<f64> {
    let length = last - first;
    let from_axis = |point: &DVec3| DVec3::new(0.0, point.y, point.z).length();
    let radius = points.iter().map(from_axis).fold(0.0, f64::max);
    if !length.is_finite() || length <= 0.0 || radius <= 0.0 {
        return None;
    }
    let mut counts = [0_u32; 2];
    for point in points {
        let end = match point.x {
            x if x - first <= 0.001 * length => 0,
            x if last - x <= 0.001 * length => 1,
            _ => return None,
        };
        let distance = from_axis(point);
        if distance >= 0.98 * radius {
            counts[end] += 1;
        } else if distance > 0.001 * radius {
            return None;
        }
    }
    // Two points a circle are a card.
    counts.iter().all(|&count| count >= 3).then_some(radius)
}

fn material(
    xml: &Xml<'_>,
    row: Node<'_, '_>,
    id: i64,
    report: &mut ImportReport,
) -> Result<Material, ImportError> {
    let mut color = [1.0; 3];
    if let Some(diffuse) = child(row, "diffuse") {
        let numbers = xml.numbers(diffuse)?;
        let Some(first) = numbers.first_chunk::<3>() else {
            let message = format!("diffuse holds {} numbers, wanted 3 or 4", numbers.len());
            return Err(xml.error(diffuse, message));
        };
        color = first.map(|channel| {
            let byte = (255.0 * channel.clamp(0.0, 1.0)).round();
            let byte = u8::try_from(crate::math::whole_u32(byte)).unwrap_or(u8::MAX);
            linear_of_srgb(byte)
        });
    }
    let others = row
        .children()
        .filter(|node| node.is_element())
        .filter(|node| {
            let known = ["emission", "ambient", "diffuse", "specular", "shininess"];
            !known.contains(&node.tag_name().name())
        });
    let place = format!("line {}", xml.line(row));
    let message = "parts of materials other than colours and shininess";
    report.add(
        ReportKind::NotUnderstood,
        others.count() as u64,
        place,
        message,
    );
    Ok(Material::plain(format!("material {id}"), color))
}
