//! Where entities stand: positions and radii, the file's and those between.

use super::entities::{Entities, NONE};
use super::steps::Relation;
use super::table::Feature;
use super::units::Units;
use crate::math::DVec3;
use crate::plant::import::frame::Frame;
use crate::plant::import::placing::Leaves;
use crate::plant::import::wood::{Grown, Place, Segment, Wood, place_of};
use crate::plant::import::{ImportError, ImportOptions, ImportReport, ReportKind, Source};

/// The radius of a tip of which nothing is known, as a share of the plant's height: 2 mm at 4 m.
const TIP_SHARE: f64 = 0.0005;

/// Classes that are leaves, in small letters.
const LEAF_CLASSES: [&str; 8] = [
    "l", "leaf", "leaflet", "leaves", "feuille", "foliole", "blade", "lamina",
];

/// A plant's wood and leaves, yet without places.
#[derive(Debug)]
pub(super) struct Shape {
    /// The wood.
    pub(super) wood: Wood,
    /// From the file's space to the plant's.
    pub(super) frame: Frame,
    /// The leaves, as the file has them.
    leaves: Vec<Told>,
}

/// Leaves as the file tells of them, in its units.
#[derive(Debug, Clone, Copy)]
struct Told {
    /// The entity that tells of them.
    entity: u32,
    /// The segment that bears them.
    segment: u32,
    /// The position of a leaf that is an entity, if it has one.
    tip: Option<DVec3>,
    /// Whether the entity is a leaf, at the end of the segment; else leaves stand along it.
    is_leaf: bool,
    /// Number and area in square metres.
    count: Option<f64>,
    area: Option<f64>,
}

/// Where an entity stands, and what hangs on it.
#[derive(Debug, Clone, Copy)]
struct Standing {
    /// The segment that bears what follows: its own, or its bearer's.
    segment: u32,
    /// Whether what follows branches off, since the entity itself did and has no segment.
    branches: bool,
    /// Where what follows starts, if not where the segment ends.
    start: Option<DVec3>,
    /// The position, if it or one before it has one.
    position: Option<DVec3>,
    /// The radius, if it or one before it on its axis has one.
    radius: Option<f64>,
}

/// What the first entity of a plant hangs on.
const NOTHING: Standing = Standing {
    segment: NONE,
    branches: false,
    start: None,
    position: None,
    radius: None,
};

/// The next entity on the axis that knows something, and how many segments further on.
type Ahead = Option<(u32, f64)>;

impl Shape {
    pub(super) fn of(
        entities: &Entities,
        source: &Source<'_>,
        options: &ImportOptions,
        report: &mut ImportReport,
    ) -> Result<Self, ImportError> {
        let units = Units::of(entities, options.reading, report);
        let is_leaf = leaf_classes(entities, source, options, report)?;
        let shaper = Shaper::new(entities, units, is_leaf);
        shaper.shape(source, report)
    }

    /// The leaves in the plant's space, along their nodes.
    pub(super) fn leaves(&self, entities: &Entities, frame: &Frame, grown: &Grown) -> Vec<Leaves> {
        let place = |told: &Told| {
            let place = grown.places[told.segment as usize];
            let first = if told.is_leaf {
                place.last
            } else {
                place.first
            };
            Place { first, ..place }
        };
        let leaves = self.leaves.iter().map(|told| {
            let of_leaf = |feature| {
                let value = entities.value(told.entity, feature);
                value.filter(|_| told.is_leaf)
            };
            let length = |feature| of_leaf(feature).map(|length| frame.length(length));
            #[expect(clippy::cast_possible_truncation, reason = "degrees, rounded once")]
            let degrees = |feature| of_leaf(feature).map(|angle| (angle % 360.0) as f32);
            Leaves {
                place: place(told),
                count: told.count,
                area: told.area,
                length: length(Feature::Length),
                width: length(Feature::Width),
                insertion: degrees(Feature::Insertion),
                azimuth: degrees(Feature::Azimuth),
                tip: told.tip.map(|tip| frame.point(tip)),
                line: entities.all[told.entity as usize].line as usize,
            }
        });
        leaves.collect()
    }
}

/// Which classes are leaves: those that the options name, or else those that are called so and have no
/// parts.
fn leaf_classes(
    entities: &Entities,
    source: &Source<'_>,
    options: &ImportOptions,
    report: &mut ImportReport,
) -> Result<Vec<bool>, ImportError> {
    let classes = &entities.classes;
    if !options.foliage.is_empty() {
        let unknown = options.foliage.iter().find(|name| !classes.contains(name));
        if let Some(name) = unknown {
            return Err(ImportError::Name {
                file: source.file().to_owned(),
                name: name.clone(),
                known: classes.join(", "),
            });
        }
        let is_named = |class| options.foliage.contains(class);
        return Ok(classes.iter().map(is_named).collect());
    }
    let is_called_so = |class: &String| LEAF_CLASSES.contains(&class.to_lowercase().as_str());
    let mut is_leaf: Vec<bool> = classes.iter().map(is_called_so).collect();
    for entity in entities.all.iter().filter(|entity| entity.has_parts) {
        is_leaf[entity.class as usize] = false;
    }
    for entity in &entities.all {
        if is_leaf[entity.class as usize] {
            let class = &classes[entity.class as usize];
            let message = format!("entities of the class {class:?}: taken as leaves");
            report.add(
                ReportKind::Guessed,
                1,
                place_of(entity.line as usize),
                message,
            );
        }
    }
    Ok(is_leaf)
}

/// What turns entities into segments.
#[derive(Debug)]
struct Shaper<'a> {
    entities: &'a Entities,
    units: Units,
    is_leaf: Vec<bool>,
    /// The entity that goes on from each: its first part, or else the next on its axis. Those that a doubled
    /// `+` skips lead to the last of them.
    next: Vec<u32>,
}

impl<'a> Shaper<'a> {
    fn new(entities: &'a Entities, units: Units, is_leaf: Vec<bool>) -> Self {
        let mut next = vec![NONE; entities.all.len()];
        for (number, entity) in (0_u32..).zip(&entities.all) {
            let goes_on = match entity.relation {
                Relation::Part => true,
                Relation::Next => !is_leaf[entity.class as usize],
                Relation::Branch => {
                    let bearer = entities.all.get(entity.parent as usize);
                    bearer.is_some_and(|bearer| bearer.is_between)
                }
            };
            let Some(before) = next.get_mut(entity.parent as usize).filter(|_| goes_on) else {
                continue;
            };
            let has_part =
                *before != NONE && entities.all[*before as usize].relation == Relation::Part;
            if *before == NONE || (entity.relation == Relation::Part && !has_part) {
                *before = number;
            }
        }
        Self {
            entities,
            units,
            is_leaf,
            next,
        }
    }

    fn position(&self, entity: u32) -> Option<DVec3> {
        let value = |feature| self.entities.value(entity, feature);
        Some(DVec3::new(
            value(Feature::X)?,
            value(Feature::Y)?,
            value(Feature::Z)?,
        ))
    }

    fn radius(&self, entity: u32) -> Option<f64> {
        let diameter = self.entities.value(entity, Feature::Diameter)?;
        Some(0.5 * diameter * self.units.diameter)
    }

    /// For each entity the next on its axis of which something is known; entities with parts are no
    /// segments, so they do not count as steps.
    fn ahead(&self, is_known: impl Fn(u32) -> bool) -> Vec<Ahead> {
        let mut ahead: Vec<Ahead> = vec![None; self.next.len()];
        for entity in (0..self.next.len()).rev() {
            let next = self.next[entity];
            if next == NONE {
                continue;
            }
            let step = if self.entities.all[next as usize].has_parts {
                0.0
            } else {
                1.0
            };
            ahead[entity] = if is_known(next) {
                Some((next, step))
            } else {
                ahead[next as usize].map(|(known, steps)| (known, steps + step))
            };
        }
        ahead
    }

    /// The radius of each entity by what it bears: the cross-section of all its tips.
    fn piped(&self) -> Vec<f64> {
        let tip = TIP_SHARE * self.units.size;
        let mut squares = vec![0.0; self.next.len()];
        for (number, entity) in self.entities.all.iter().enumerate().rev() {
            if self.is_leaf[entity.class as usize] {
                continue;
            }
            if squares[number] <= 0.0 {
                squares[number] = tip * tip;
            }
            if entity.parent != NONE {
                squares[entity.parent as usize] += squares[number];
            }
        }
        squares.into_iter().map(f64::sqrt).collect()
    }

    fn shape(self, source: &Source<'_>, report: &mut ImportReport) -> Result<Shape, ImportError> {
        let positions = self.ahead(|entity| self.position(entity).is_some());
        let radii = self.ahead(|entity| self.radius(entity).is_some());
        let piped = self.piped();
        let count = self.entities.all.len();
        let mut wood = Wood::new("segments");
        let mut standings: Vec<Standing> = Vec::with_capacity(count);
        // The segment of each entity itself, or of what goes on from it.
        let mut own = vec![NONE; count];
        let mut leaves = Vec::new();
        for (number, entity) in (0_u32..).zip(&self.entities.all) {
            let place = || place_of(entity.line as usize);
            let before = standings.get(entity.parent as usize).copied();
            let before = before.unwrap_or(NOTHING);
            let branches = entity.relation == Relation::Branch || before.branches;
            let told = self.position(number);
            let area = self.entities.value(number, Feature::LeafArea);
            let area = area.map(|area| area * self.units.area);
            if self.is_leaf[entity.class as usize] {
                leaves.push(Told {
                    entity: number,
                    segment: before.segment,
                    tip: told,
                    is_leaf: true,
                    count: area.map(|_| 1.0),
                    area,
                });
                standings.push(before);
                continue;
            }
            let leaf_count = self.entities.value(number, Feature::LeafCount);
            if leaf_count.is_some_and(|count| count > 0.0) || area.is_some_and(|area| area > 0.0) {
                leaves.push(Told {
                    entity: number,
                    segment: NONE,
                    tip: None,
                    is_leaf: false,
                    count: leaf_count.filter(|count| *count > 0.0),
                    area: area.filter(|area| *area > 0.0),
                });
            }
            // On another axis, what is before says nothing of this one's radius.
            let axis_radius = before
                .radius
                .filter(|_| !branches || before.start.is_some());
            if entity.has_parts {
                standings.push(Standing {
                    segment: before.segment,
                    branches,
                    start: told.or(before.start),
                    position: told.or(before.position),
                    radius: self.radius(number).or(axis_radius),
                });
                continue;
            }
            let from = before.start.or(before.position);
            let Some(end) = told.or_else(|| self.between(from, positions[number as usize])) else {
                let message = "entities without a position, and without one behind them on their axis: they \
                               stand where the one before does";
                report.add(ReportKind::Missing, 1, place(), message);
                standings.push(Standing { branches, ..before });
                continue;
            };
            let radius = self.radius(number).or_else(|| {
                let (known, steps) = radii[number as usize]?;
                let there = self.radius(known)?;
                let here = axis_radius.unwrap_or(there);
                Some(here + (there - here) / (steps + 1.0))
            });
            let radius = radius.unwrap_or_else(|| {
                let message = "segments without a diameter, and without one behind them on their axis: as \
                               thick as the tips that they bear together, but no thicker than the one before";
                report.add(ReportKind::Guessed, 1, place(), message);
                piped[number as usize].min(before.radius.unwrap_or(f64::INFINITY))
            });
            if told.is_none() {
                let message = "positions between two that the file tells: at equal distances";
                report.add(ReportKind::Guessed, 1, place(), message);
            }
            let segment = Segment {
                parent: (before.segment != NONE).then_some(before.segment),
                follows: Some(!branches),
                start: before.start,
                end,
                start_radius: axis_radius.filter(|_| before.start.is_some()),
                end_radius: Some(radius),
                line: entity.line as usize,
            };
            own[number as usize] = wood.push(segment, source)?;
            standings.push(Standing {
                segment: own[number as usize],
                branches: false,
                start: None,
                position: Some(end),
                radius: Some(radius),
            });
        }
        if wood.segments().is_empty() {
            let message = format!("{count} entities, and none has a position");
            return Err(source.error(1, 1, message));
        }
        // An entity with parts bears its leaves where they are; what goes on from one comes behind it.
        for entity in (0..count).rev() {
            if own[entity] == NONE && self.next[entity] != NONE {
                own[entity] = own[self.next[entity] as usize];
            }
        }
        for told in leaves.iter_mut().filter(|told| !told.is_leaf) {
            told.segment = match own[told.entity as usize] {
                NONE => standings[told.entity as usize].segment,
                own => own,
            };
        }
        let placeless = leaves.iter().filter(|told| told.segment == NONE);
        for told in placeless {
            let line = self.entities.all[told.entity as usize].line as usize;
            let message = "leaves that nothing with a position bears";
            report.add(ReportKind::Dropped, 1, place_of(line), message);
        }
        leaves.retain(|told| told.segment != NONE);
        Ok(Shape {
            wood,
            frame: self.units.frame,
            leaves,
        })
    }

    /// The position of an entity without one: a step of equal length on the way to the next that has one, or,
    /// where nothing comes before, that one's.
    fn between(&self, from: Option<DVec3>, ahead: Ahead) -> Option<DVec3> {
        let (known, steps) = ahead?;
        let there = self.position(known)?;
        let from = from.unwrap_or(there);
        Some(from + (there - from) / (steps + 1.0))
    }
}
