//! XML, of any nesting and with places.

use roxmltree::{Document as Xml, Error, ParsingOptions};

use super::{DocumentError, line_and_column};
use crate::limits::XML_NODES;

/// Parses a text. Nesting costs no stack; entities of the document's own are refused, which could stand for any
/// amount of text.
///
/// `kind` is what the text should be, with its article.
///
/// # Errors
///
/// When the text is no XML, or of more than [`XML_NODES`] elements and texts. What is never closed is named at
/// the end of the text.
pub(crate) fn parse_xml<'a>(
    file: &str,
    text: &'a str,
    kind: &str,
) -> Result<Xml<'a>, DocumentError> {
    let options = ParsingOptions {
        nodes_limit: XML_NODES,
        ..ParsingOptions::default()
    };
    Xml::parse_with_options(text, options).map_err(|error| {
        let (line, column) = match error {
            Error::UnclosedRootNode | Error::UnexpectedEndOfStream => {
                line_and_column(text, text.len())
            }
            _ => (error.pos().row as usize, error.pos().col as usize),
        };
        let message = match error {
            Error::NodesLimitReached => {
                format!("more than {XML_NODES} elements and texts; split or thin the tree")
            }
            error => format!("not {kind}: {error}"),
        };
        DocumentError {
            file: file.to_owned(),
            line,
            column,
            message,
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_have_the_place_of_what_is_wrong() {
        for (text, place, says) in [
            ("<a>\n  <b>\n", (3, 1), "not a tree: "),
            ("<a>\n<b c='", (2, 7), "not a tree: "),
            ("", (1, 1), "not a tree: "),
            ("<a>\n <b></c></a>", (2, 5), "not a tree: "),
            ("<!DOCTYPE a [<!ENTITY b 'c'>]><a/>", (1, 1), "not a tree: "),
        ] {
            let error = parse_xml("a.xml", text, "a tree").unwrap_err();
            assert_eq!((error.line, error.column), place, "{text:?}: {error}");
            assert!(error.message.starts_with(says), "{error}");
        }
        assert!(parse_xml("a.xml", "<a><b/></a>", "a tree").is_ok());
    }
}
