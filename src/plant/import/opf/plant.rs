//! From organs to a plant: cylinders are segments of wood, all else leaves that share a prototype.

use super::tables::{RefMesh, Shape, Tables};
use super::topology::Organ;
use super::{Opf, Place};
use crate::limits::PLACED_CORNERS;
use crate::math::{DVec3, Vec3};
use crate::plant::import::mesh::{Names, listed, prototype_of, says_leaves};
use crate::plant::import::wood::{self, Segment, Wood};
use crate::plant::import::{
    Frame, ImportError, ImportOptions, ImportReport, ReportKind, Source, Unit, UpAxis,
};
use crate::plant::{Foliage, LeafGroup, Material, NO_BRANCH, Plant, Prototype};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

/// A plant while organs are added.
#[derive(Debug)]
pub(super) struct Growing<'a> {
    source: &'a Source<'a>,
    options: &'a ImportOptions,
    names: Names<'a>,
    known: BTreeSet<String>,
    wood: Wood,
    /// How many segments have which material.
    barks: Vec<(Material, u64)>,
    groups: Vec<Group>,
    corners: u64,
}

/// Leaves of one shape, in the file's space.
#[derive(Debug)]
struct Group {
    name: String,
    prototype: Prototype,
    material: Material,
    positions: Vec<DVec3>,
    /// The segment that bears each leaf.
    bearers: Vec<Option<u32>>,
}

/// What an organ's shape is here.
#[derive(Debug, Clone)]
enum Role {
    Wood(usize),
    /// A group, and which vertices of the mesh its prototype has.
    Leaf(usize, Vec<u32>),
}

impl<'a> Growing<'a> {
    pub(super) fn new(source: &'a Source<'a>, options: &'a ImportOptions) -> Self {
        Self {
            source,
            options,
            names: Names::new(&options.foliage),
            known: BTreeSet::new(),
            wood: Wood::new("internodes"),
            barks: Vec::new(),
            groups: Vec::new(),
            corners: 0,
        }
    }

    /// Adds the organs of a file that stands in a place.
    pub(super) fn add(
        &mut self,
        opf: &Opf,
        place: &Place,
        report: &mut ImportReport,
    ) -> Result<(), ImportError> {
        let tables = &opf.tables;
        let mut roles: BTreeMap<(i64, bool), Role> = BTreeMap::new();
        // By organ, the segment it is, or that bears it.
        let mut segments: Vec<Option<u32>> = Vec::with_capacity(opf.organs.len());
        for organ in &opf.organs {
            let shape = &tables.shapes[&organ.shape];
            let is_leaf = self.is_leaf(organ, shape, tables, report);
            let key = (organ.shape, is_leaf);
            let role = match roles.entry(key) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(free) => free.insert(self.role(shape, tables, is_leaf)),
            };
            let mesh = &tables.meshes[shape.mesh];
            let placed = place.of(&organ.place);
            let bearer = organ.bearer.and_then(|bearer| segments[bearer as usize]);
            let segment = match role {
                Role::Wood(bark) => {
                    self.barks[*bark].1 += 1;
                    Some(self.segment(organ, mesh, &placed, bearer)?)
                }
                Role::Leaf(group, vertices) => {
                    self.leaf(*group, vertices, organ, mesh, &placed, bearer)?;
                    bearer
                }
            };
            segments.push(segment);
        }
        Ok(())
    }

    /// Whether an organ is foliage: as told, or whatever is no cylinder.
    fn is_leaf(
        &mut self,
        organ: &Organ,
        shape: &Shape,
        tables: &Tables,
        report: &mut ImportReport,
    ) -> bool {
        let is_cylinder = tables.meshes[shape.mesh].cylinder.is_some();
        let mut is_named = false;
        for name in [&organ.class, &shape.name] {
            is_named |= self.names.has(Some(name));
            if !name.is_empty() && self.known.len() < MOST_KNOWN {
                self.known.insert(name.clone());
            }
        }
        let place = || format!("line {}", organ.line);
        if self.options.foliage.is_empty() {
            let says = says_leaves(Some(&organ.class)) || says_leaves(Some(&shape.name));
            if !is_cylinder && !says {
                let message =
                    "organs that are no cylinders, but not called leaves: taken as foliage";
                report.add(ReportKind::Guessed, 1, place(), message);
            }
            return !is_cylinder;
        }
        if !is_named && !is_cylinder {
            let message =
                "organs that are no cylinders cannot be wood: taken as foliage, though not named";
            report.add(ReportKind::Merged, 1, place(), message);
        }
        is_named || !is_cylinder
    }

    fn role(&mut self, shape: &Shape, tables: &Tables, is_leaf: bool) -> Role {
        let material = shape.material.map_or_else(
            || Material::plain("default", [1.0; 3]),
            |material| tables.materials[material].clone(),
        );
        if !is_leaf {
            let known = self.barks.iter().position(|(bark, _)| *bark == material);
            return Role::Wood(known.unwrap_or_else(|| {
                self.barks.push((material, 0));
                self.barks.len() - 1
            }));
        }
        let mesh = &tables.meshes[shape.mesh];
        let positions: Vec<Vec3> = mesh.points.iter().map(|point| point.as_vec3()).collect();
        let (prototype, vertices) = prototype_of(&positions, &mesh.coordinates, &mesh.triangles);
        let name = if shape.name.is_empty() {
            material.name.clone()
        } else {
            shape.name.clone()
        };
        self.groups.push(Group {
            name,
            prototype,
            material,
            positions: Vec::new(),
            bearers: Vec::new(),
        });
        Role::Leaf(self.groups.len() - 1, vertices)
    }

    fn segment(
        &mut self,
        organ: &Organ,
        mesh: &RefMesh,
        place: &Place,
        bearer: Option<u32>,
    ) -> Result<u32, ImportError> {
        let end = |x: f64| place.point(DVec3::new(x, 0.0, 0.0));
        let [first, last] = mesh.ends;
        let across = mesh.cylinder.unwrap_or(0.0) * place.linear.y_axis.length();
        let [below, above] = if mesh.is_scaled {
            organ.diameters.map(|diameter| (diameter * across).abs())
        } else {
            [across; 2]
        };
        let segment = Segment {
            parent: bearer,
            follows: bearer.is_some().then_some(organ.follows),
            start: Some(end(first)),
            end: end(last),
            start_radius: Some(below),
            end_radius: Some(above),
            line: organ.line,
        };
        self.wood.push(segment, self.source)
    }

    fn leaf(
        &mut self,
        group: usize,
        vertices: &[u32],
        organ: &Organ,
        mesh: &RefMesh,
        place: &Place,
        bearer: Option<u32>,
    ) -> Result<(), ImportError> {
        let group = &mut self.groups[group];
        self.corners += 3 * group.prototype.triangles_per_leaf().max(1) as u64;
        self.source
            .limit("triangle corners", self.corners, PLACED_CORNERS)?;
        let [first, last] = mesh.ends;
        let [below, above] = organ.diameters;
        for &vertex in vertices {
            let mut point = mesh.points[vertex as usize];
            if mesh.is_scaled {
                let share = if last > first {
                    (point.x - first) / (last - first)
                } else {
                    0.0
                };
                let across = below + (above - below) * share;
                point.y *= across;
                point.z *= across;
            }
            group.positions.push(place.point(point));
        }
        group.bearers.push(bearer);
        Ok(())
    }

    /// The plant of all organs.
    pub(super) fn plant(self, report: &mut ImportReport) -> Result<Plant, ImportError> {
        if let Some(name) = self.names.unknown() {
            return Err(ImportError::Name {
                file: self.source.file().to_owned(),
                name: name.to_owned(),
                known: listed(&self.known),
            });
        }
        let frame = Frame::new(self.options.reading, UpAxis::Z, Unit::Cm);
        let frame = self.wood.stand(frame, report);
        let grown = self.wood.grow(&frame, report);
        let mut trunk = wood::trunk(&grown.skeleton, report);
        if let Some(trunk) = &mut trunk {
            trunk.material = bark(&self.barks, report).unwrap_or_else(|| trunk.material.clone());
        }
        let mut groups = Vec::new();
        for group in self
            .groups
            .into_iter()
            .filter(|group| !group.bearers.is_empty())
        {
            let owner = |bearer: Option<u32>| {
                bearer.map_or(NO_BRANCH, |segment| grown.places[segment as usize].branch)
            };
            match group.prototype {
                Prototype::Quad { .. } => report.quad_leaves += group.bearers.len() as u64,
                Prototype::Faces { .. } | Prototype::Needle { .. } => {
                    report.other_leaves += group.bearers.len() as u64;
                }
            }
            groups.push(LeafGroup {
                name: group.name,
                prototype: group.prototype,
                material: group.material,
                positions: group
                    .positions
                    .iter()
                    .map(|&point| frame.point(point))
                    .collect(),
                owners: group.bearers.into_iter().map(owner).collect(),
            });
        }
        let skeleton = Some(grown.skeleton).filter(|skeleton| !skeleton.branches.is_empty());
        let plant = Plant::new(self.source.stem(), skeleton, trunk, Foliage { groups });
        plant.map_err(|source| ImportError::Plant {
            file: self.source.file().to_owned(),
            source,
        })
    }
}

/// The material that most internodes have; that of all others is reported.
fn bark(barks: &[(Material, u64)], report: &mut ImportReport) -> Option<Material> {
    let mut most: Option<&(Material, u64)> = None;
    for bark in barks {
        if most.is_none_or(|most| bark.1 > most.1) {
            most = Some(bark);
        }
    }
    let most = most?;
    let others: u64 = barks.iter().map(|(_, count)| count).sum::<u64>() - most.1;
    let message = format!(
        "internodes of other materials: they take {:?}, which most have",
        most.0.name
    );
    report.add(ReportKind::Merged, others, "materialBDD", message);
    Some(most.0.clone())
}

/// Names that an error may list: each occurs in the file, whose names may be many.
const MOST_KNOWN: usize = 1024;
