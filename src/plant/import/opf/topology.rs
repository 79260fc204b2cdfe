//! The topology: which organ bears which.
//!
//! ```text
//!  <decomp Axis>            A component of a larger entity begins where that entity is borne.
//!    <decomp Internode 1>
//!      <branch Leaf/>       What branches off is borne by its parent,
//!      <follow Internode 2/>   what follows goes on from it: as its child,
//!    <follow Internode 3/>  or as its sibling.
//! ```

use super::Place;
use super::tables::Tables;
use super::xml::{Xml, child};
use crate::math::{DMat3, DVec3, index_u32};
use crate::plant::import::{ImportError, ImportReport, ReportKind};
use roxmltree::Node;

/// An entity with a shape.
#[derive(Debug, Clone)]
pub(super) struct Organ {
    pub(super) class: String,
    /// Its shape's row.
    pub(super) shape: i64,
    pub(super) place: Place,
    /// The diameters that its mesh is widened by, at its first and last x.
    pub(super) diameters: [f64; 2],
    /// The wooden organ that bears it, by its number among all organs; always an earlier one.
    pub(super) bearer: Option<u32>,
    /// Whether it goes on along its bearer's axis.
    pub(super) follows: bool,
    pub(super) line: usize,
}

/// An entity whose children are being looked at.
struct Entity<'a, 'i> {
    next: Option<Node<'a, 'i>>,
    is_branch: bool,
    scale: i64,
    /// The wood that it is borne by.
    bearer: Option<u32>,
    /// Whether its first component goes on along the bearer's axis.
    follows: bool,
    /// Its own wood.
    own: Option<u32>,
    /// The wood at the end of its axis, so far.
    last: Option<u32>,
    /// The scale of the last child that is a component or follows, and the wood at its end.
    before: Option<(i64, Option<u32>)>,
}

/// The organs of a document, bearers first.
pub(super) fn organs(
    xml: &Xml<'_>,
    tables: &Tables,
    report: &mut ImportReport,
) -> Result<Vec<Organ>, ImportError> {
    let root = xml.document.root_element();
    let mut walk = Walk {
        xml,
        tables,
        organs: Vec::new(),
        entities: 0,
        attributes: (0, 0),
    };
    for topology in root.children().filter(|node| node.has_tag_name("topology")) {
        walk.topology(topology)?;
    }
    let Walk {
        organs,
        entities,
        attributes,
        ..
    } = walk;
    report.find("entities", entities);
    report.find("organs", organs.len() as u64);
    report.find("attributes", attributes.0);
    let message = "attributes of organs: their shape is told by mesh and matrix";
    let place = format!("line {}", attributes.1);
    report.add(ReportKind::Ignored, attributes.0, place, message);
    Ok(organs)
}

struct Walk<'x, 'a> {
    xml: &'x Xml<'a>,
    tables: &'x Tables,
    organs: Vec<Organ>,
    entities: u64,
    /// How many, and the line of the first.
    attributes: (u64, usize),
}

impl Walk<'_, '_> {
    /// Walks without recursion: a shoot of a thousand internodes may be nested as deeply.
    fn topology(&mut self, topology: Node<'_, '_>) -> Result<(), ImportError> {
        let mut stack = vec![self.entity(topology, None)?];
        while let Some(parent) = stack.last_mut() {
            let Some(node) = parent.next else {
                let done = stack.pop().expect("the loop looks at it");
                if let Some(parent) = stack.last_mut()
                    && !done.is_branch
                {
                    parent.last = done.last;
                    parent.before = Some((done.scale, done.last));
                }
                continue;
            };
            parent.next = node.next_sibling_element();
            match node.tag_name().name() {
                "decomp" | "follow" | "branch" => {
                    let entity = self.entity(node, stack.last())?;
                    stack.push(entity);
                }
                "geometry" => {}
                _ => {
                    if self.attributes.0 == 0 {
                        self.attributes.1 = self.xml.line(node);
                    }
                    self.attributes.0 += 1;
                }
            }
        }
        Ok(())
    }

    fn entity<'a, 'i>(
        &mut self,
        node: Node<'a, 'i>,
        parent: Option<&Entity<'a, 'i>>,
    ) -> Result<Entity<'a, 'i>, ImportError> {
        self.entities += 1;
        let kind = node.tag_name().name();
        let scale = node.attribute("scale").unwrap_or("0").trim();
        let scale: i64 = scale.parse().map_err(|_error| {
            self.xml
                .error(node, format!("scale is {scale:?}, wanted a whole number"))
        })?;
        let (bearer, follows) = match parent {
            None => (None, false),
            Some(parent) => match (kind, parent.before) {
                ("follow", Some((before, last))) if before == scale => (last, true),
                ("follow", _) => (parent.last, true),
                ("branch", _) if parent.scale == scale => (parent.own.or(parent.last), false),
                ("branch", Some((_, last))) => (last, false),
                _ => (parent.bearer, parent.follows),
            },
        };
        let own = match self.organ(node, bearer, follows)? {
            Some((organ, true)) => Some(organ),
            _ => None,
        };
        Ok(Entity {
            next: node.first_element_child(),
            is_branch: kind == "branch",
            scale,
            bearer,
            follows,
            own,
            last: own.or(bearer),
            before: None,
        })
    }

    /// Adds an entity's organ, if it has a shape; returns its number and whether it is wood.
    fn organ(
        &mut self,
        node: Node<'_, '_>,
        bearer: Option<u32>,
        follows: bool,
    ) -> Result<Option<(u32, bool)>, ImportError> {
        let Some(geometry) = child(node, "geometry") else {
            return Ok(None);
        };
        let Some(index) = child(geometry, "shapeIndex") else {
            return Ok(None);
        };
        let xml = self.xml;
        let shape = xml.id(index)?;
        let Some(known) = self.tables.shapes.get(&shape) else {
            let count = self.tables.shapes.len();
            let message = format!("names shape {shape}, which is none of the {count} of shapeBDD");
            return Err(xml.error(index, message));
        };
        let place = match child(geometry, "mat") {
            None => Place::IDENTITY,
            Some(mat) => {
                let numbers = xml.numbers(mat)?;
                let Some(m) = numbers.first_chunk::<12>().filter(|_| numbers.len() == 12) else {
                    let found = numbers.len();
                    let message = format!("mat holds {found} numbers, wanted 3 rows of 4");
                    return Err(xml.error(mat, message));
                };
                let column = |c: usize| DVec3::new(m[c], m[4 + c], m[8 + c]);
                Place {
                    linear: DMat3::from_cols(column(0), column(1), column(2)),
                    origin: column(3),
                }
            }
        };
        let diameter = |name: &str| {
            child(geometry, name)
                .map(|node| xml.number(node))
                .transpose()
        };
        let (below, above) = (diameter("dDwn")?, diameter("dUp")?);
        let below = below.or(above).unwrap_or(1.0);
        let number = index_u32(self.organs.len());
        self.organs.push(Organ {
            class: node.attribute("class").unwrap_or_default().to_owned(),
            shape,
            place,
            diameters: [below, above.unwrap_or(below)],
            bearer,
            follows,
            line: xml.line(node),
        });
        let is_wood = self.tables.meshes[known.mesh].cylinder.is_some();
        Ok(Some((number, is_wood)))
    }
}
