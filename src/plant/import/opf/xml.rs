//! XML with errors that have a place.

use crate::document::{DocumentError, parse_xml};
use crate::plant::import::{ImportError, Source};
use roxmltree::{Document, Node};

/// A parsed document and where its lines begin.
#[derive(Debug)]
pub(super) struct Xml<'a> {
    source: &'a Source<'a>,
    pub(super) document: Document<'a>,
    text: &'a str,
    /// Byte offsets of line ends.
    ends: Vec<usize>,
}

impl<'a> Xml<'a> {
    /// Parses a text.
    pub(super) fn parse(source: &'a Source<'a>, text: &'a str) -> Result<Self, ImportError> {
        let document = parse_xml(source.file(), text, "an OPF document");
        let document = document.map_err(ImportError::Syntax)?;
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n');
        Ok(Self {
            source,
            document,
            text,
            ends: ends.map(|(offset, _)| offset).collect(),
        })
    }

    /// The line of an element, from 1.
    pub(super) fn line(&self, node: Node<'_, '_>) -> usize {
        let start = node.range().start;
        1 + self.ends.partition_point(|&end| end < start)
    }

    /// An error at an element.
    pub(super) fn error(&self, node: Node<'_, '_>, message: impl Into<String>) -> ImportError {
        let start = node.range().start;
        let error = DocumentError::at(self.source.file(), self.text, start, message);
        ImportError::Syntax(error)
    }

    /// The numbers that an element holds.
    pub(super) fn numbers(&self, node: Node<'_, '_>) -> Result<Vec<f64>, ImportError> {
        let mut numbers = Vec::new();
        for word in node.text().unwrap_or_default().split_ascii_whitespace() {
            let number = word.parse::<f64>().ok().filter(|number| number.is_finite());
            let Some(number) = number else {
                let name = node.tag_name().name();
                let message = format!("{name} holds {word:?}, wanted finite numbers");
                return Err(self.error(node, message));
            };
            numbers.push(number);
        }
        Ok(numbers)
    }

    /// The only number that an element holds.
    pub(super) fn number(&self, node: Node<'_, '_>) -> Result<f64, ImportError> {
        match self.numbers(node)?.as_slice() {
            [number] => Ok(*number),
            others => {
                let name = node.tag_name().name();
                let message = format!("{name} holds {} numbers, wanted 1", others.len());
                Err(self.error(node, message))
            }
        }
    }

    /// A number of a table's row: what an element holds.
    pub(super) fn id(&self, node: Node<'_, '_>) -> Result<i64, ImportError> {
        let text = node.text().unwrap_or_default().trim();
        text.parse().map_err(|_error| {
            let name = node.tag_name().name();
            self.error(node, format!("{name} is {text:?}, wanted a whole number"))
        })
    }

    /// The number of a table's row: its `Id`.
    pub(super) fn own_id(&self, node: Node<'_, '_>) -> Result<i64, ImportError> {
        let id = node.attribute("Id").or(node.attribute("id"));
        let name = node.tag_name().name();
        let Some(id) = id else {
            return Err(self.error(node, format!("a {name} without Id")));
        };
        id.trim().parse().map_err(|_error| {
            self.error(
                node,
                format!("{name} has the Id {id:?}, wanted a whole number"),
            )
        })
    }
}

/// The first child element of a name.
pub(super) fn child<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|child| child.has_tag_name(name))
}
