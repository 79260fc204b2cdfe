//! Treefiles of raycloudtools: a tree a line.
//!
//! ```text
//! # comments
//! height, x,y,z,radius,parent_id,…      the fields: those before x once a tree, the others for each node
//! 7.5, 0,0,0,0.2,-1,…, 0,0,1,0.1,0,…    a tree: node 0 is its base, the others are tips of cylinders
//! ```

use super::plant_of;
use crate::limits::WOOD_SEGMENTS;
use crate::math::{DVec3, index_u32, whole_u32};
use crate::plant::Plant;
use crate::plant::import::number::{FARTHEST, bounded};
use crate::plant::import::wood::{Segment, Wood, place_of};
use crate::plant::import::{ImportError, ImportOptions, ImportReport, ReportKind, Source};

/// Where the fields of nodes begin.
const NODE_FIELDS: &str = "x,y,z,radius";

/// Reads a treefile; several trees become one plant of several stems.
///
/// # Errors
///
/// When the text is not UTF-8, there is no line of fields with the parents, a tree's line does not hold whole
/// nodes, a number is not one or out of range, or there are too many nodes.
pub(in crate::plant::import) fn read(
    source: &Source<'_>,
    options: &ImportOptions,
    report: &mut ImportReport,
) -> Result<Plant, ImportError> {
    let mut fields: Option<Fields> = None;
    let mut wood = Wood::new("nodes");
    for (number, text) in (1..).zip(source.text()?.lines()) {
        let is_comment = text.trim_start().starts_with('#');
        let may_name = text.contains("radius") && !text.trim_start().starts_with(is_numeric);
        let names = if may_name {
            text.trim().trim_start_matches('#').replace(' ', "")
        } else {
            String::new()
        };
        if names.contains(NODE_FIELDS) {
            // Early versions name the fields in the comment, behind a colon.
            let names = names.rsplit(':').next().unwrap_or_default();
            match Fields::of(names, number, source) {
                Err(_) if is_comment => {}
                found => fields = Some(found?),
            }
        } else if !is_comment && !text.trim().is_empty() {
            let Some(fields) = &fields else {
                let message = format!(
                    "a tree before the line of fields, wanted \"{NODE_FIELDS},parent_id,…\""
                );
                return Err(source.error(number, 1, message));
            };
            fields.tree(number, text, source, &mut wood, report)?;
            report.find("trees", 1);
        }
    }
    if wood.segments().is_empty() {
        let message = "no trees, wanted a line of fields and at least one of nodes";
        return Err(source.error(1, 1, message));
    }
    plant_of(&wood, source, options, report)
}

fn is_numeric(c: char) -> bool {
    c.is_ascii_digit() || matches!(c, '-' | '+' | '.')
}

/// What a line of a tree consists of.
#[derive(Debug)]
struct Fields {
    /// Fields once a tree.
    tree: usize,
    /// Fields of each node.
    node: usize,
    /// Which of a node's fields is its parent.
    parent: usize,
}

/// A cell of a line, and its column.
#[derive(Debug, Clone, Copy)]
struct Cell<'t> {
    text: &'t str,
    column: usize,
}

impl Fields {
    fn of(names: &str, line: usize, source: &Source<'_>) -> Result<Self, ImportError> {
        let names: Vec<&str> = names.split(',').filter(|name| !name.is_empty()).collect();
        let first = names.iter().position(|name| *name == "x");
        let parent = names.iter().position(|name| *name == "parent_id");
        match (first, parent) {
            (Some(first), Some(parent)) if parent > first => Ok(Self {
                tree: first,
                node: names.len() - first,
                parent: parent - first,
            }),
            _ => {
                let message = format!(
                    "{} fields without parent_id behind {NODE_FIELDS}: trunks have no wood to read; extract \
                     trees",
                    names.len()
                );
                Err(source.error(line, 1, message))
            }
        }
    }

    /// Reads a line into the wood.
    fn tree(
        &self,
        line: usize,
        text: &str,
        source: &Source<'_>,
        wood: &mut Wood,
        report: &mut ImportReport,
    ) -> Result<(), ImportError> {
        let cells = || cells(text);
        let count = cells().count();
        let of_nodes = count.saturating_sub(self.tree);
        let nodes = of_nodes / self.node;
        if nodes == 0 || nodes * self.node + self.tree != count {
            let end = cells().last().map_or(1, |cell| cell.column);
            let message = format!(
                "{count} values, wanted {} of the tree and {} of each node",
                self.tree, self.node
            );
            return Err(source.error(line, end, message));
        }
        let base = wood.segments().len();
        let mut tree: Vec<Segment> = Vec::new();
        let mut cells = cells().skip(self.tree);
        let mut node = Vec::with_capacity(self.node);
        for _ in 0..nodes.min(WOOD_SEGMENTS + 1) {
            node.clear();
            node.extend(cells.by_ref().take(self.node));
            let value = |field: usize, name: &str, least: f64| {
                let Cell { text, column } = node[field];
                bounded(text, name, &(least..=FARTHEST))
                    .map_err(|message| source.error(line, column, message))
            };
            let tip = [
                value(0, "x", -FARTHEST)?,
                value(1, "y", -FARTHEST)?,
                value(2, "z", -FARTHEST)?,
            ];
            let radius = value(3, "radius", 0.0)?;
            let told = value(self.parent, "parent_id", -FARTHEST)?;
            // Saturates; numbers beyond 32 bits name no node.
            let parent = Some(whole_u32(told) as usize)
                .filter(|&parent| told >= 0.0 && parent < nodes && told.trunc() == told);
            if parent.is_none() && told >= 0.0 {
                let message = "parents that are not there: their children become roots";
                report.add(ReportKind::Repaired, 1, place_of(line), message);
            }
            tree.push(Segment {
                parent: parent.map(|parent| index_u32(base + parent)),
                follows: None,
                start: None,
                end: DVec3::from_array(tip),
                start_radius: None,
                end_radius: Some(radius),
                line,
            });
        }
        thicken_bases(&mut tree, base);
        for segment in tree {
            wood.push(segment, source)?;
        }
        Ok(())
    }
}

/// Gives bases without a radius that of their first cylinder; `first` is the number of the first node.
fn thicken_bases(tree: &mut [Segment], first: usize) {
    for node in 0..tree.len() {
        let Some(parent) = tree[node].parent else {
            continue;
        };
        let parent = parent as usize - first;
        let is_bare = tree[parent].end_radius == Some(0.0);
        if tree[parent].parent.is_none() && is_bare {
            tree[parent].end_radius = tree[node].end_radius;
        }
    }
}

/// The cells of a line; a comma at its end adds none.
fn cells(text: &str) -> impl Iterator<Item = Cell<'_>> {
    let text = text.trim_end();
    let text = text.strip_suffix(',').unwrap_or(text);
    let mut next = 1;
    text.split(',').map(move |cell| {
        let blanks = cell.chars().take_while(|c| c.is_whitespace()).count();
        let column = next + blanks;
        next += cell.chars().count() + 1;
        Cell {
            text: cell.trim(),
            column,
        }
    })
}
