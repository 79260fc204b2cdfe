//! Pages that open offline: one HTML file with its style and images in it.

use super::ReportError;
use super::table::{Align, Cell, Table};
use crate::limits;

/// A page.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Page {
    /// The heading, and the title of the window.
    pub title: String,
    /// What follows, from top to bottom.
    pub sections: Vec<Section>,
}

/// A part of a page.
#[derive(Debug, Clone, PartialEq)]
pub enum Section {
    /// A heading.
    Heading(String),
    /// A paragraph.
    Text(String),
    /// A table with its caption; wide ones scroll sideways.
    Table {
        /// What it shows; may be empty.
        caption: String,
        /// The table.
        table: Table,
    },
    /// An SVG file that spinney made, such as [`Plot::to_svg`](super::Plot::to_svg); it is put in
    /// as it is, and scrolls sideways where its text would become too small.
    Figure(String),
    /// Pictures beside each other.
    Images(Vec<PageImage>),
    /// Pictures beside each other, two a row where the window is wide, else one.
    Large(Vec<PageImage>),
}

/// A picture on a page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PageImage {
    /// What stands below it.
    pub caption: String,
    /// A PNG file.
    pub png: Vec<u8>,
}

impl Page {
    /// The most pictures of a page.
    pub const MAX_IMAGES: usize = limits::PAGE_IMAGES;

    /// The most bytes of a page.
    pub const MAX_BYTES: usize = limits::PAGE_BYTES;

    /// The page as an HTML file.
    ///
    /// # Errors
    ///
    /// When it has more than [`MAX_IMAGES`](Self::MAX_IMAGES) pictures or takes more than
    /// [`MAX_BYTES`](Self::MAX_BYTES).
    pub fn to_html(&self) -> Result<String, ReportError> {
        let images: usize = self
            .sections
            .iter()
            .map(|section| match section {
                Section::Images(images) | Section::Large(images) => images.len(),
                _ => 0,
            })
            .sum();
        if images > Self::MAX_IMAGES {
            return Err(ReportError::TooLarge {
                what: "pictures of a page",
                found: images,
                limit: Self::MAX_IMAGES,
            });
        }
        let title = escape(&self.title);
        let mut html = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n"
        );
        for section in &self.sections {
            html += &section_html(section);
        }
        html += "</main>\n</body>\n</html>\n";
        if html.len() > Self::MAX_BYTES {
            return Err(ReportError::TooLarge {
                what: "bytes of a page",
                found: html.len(),
                limit: Self::MAX_BYTES,
            });
        }
        Ok(html)
    }
}

const STYLE: &str = "\
:root{color-scheme:light dark;--ground:#fff;--ink:#24292f;--soft:#5a646e;--rule:#d5dae0;--band:#f4f6f8}
@media(prefers-color-scheme:dark){:root{--ground:#15181c;--ink:#dde3ea;--soft:#9aa5b0;--rule:#363d45;--band:#1d2126}}
body{margin:0;background:var(--ground);color:var(--ink);font:16px/1.5 system-ui,sans-serif}
main{max-width:60rem;margin:0 auto;padding:1rem}
h1{font-size:1.5rem;line-height:1.2;overflow-wrap:anywhere}h2{font-size:1.15rem;margin:2rem 0 .5rem}
p{max-width:44rem;overflow-wrap:anywhere}
.wide{overflow-x:auto;margin:1rem 0}
table{border-collapse:collapse;font-size:.875rem;font-variant-numeric:tabular-nums}
caption{text-align:left;color:var(--soft);padding:.25rem 0}
th,td{padding:.2rem .6rem;border-bottom:1px solid var(--rule);text-align:left;vertical-align:top}
th{border-bottom-width:2px}tbody tr:nth-child(even){background:var(--band)}
.n{text-align:right;white-space:nowrap}td:first-child{white-space:nowrap}
figure{margin:1rem 0}svg,img{display:block;max-width:100%;height:auto}svg{min-width:32rem}
.images{display:grid;grid-template-columns:repeat(auto-fill,minmax(10rem,1fr));gap:.75rem;margin:1rem 0}
.large{grid-template-columns:repeat(auto-fill,minmax(min(100%,24rem),1fr))}.large img{width:100%}
.images figure{margin:0}.images img{border:1px solid var(--rule);image-rendering:pixelated}
figcaption{font-size:.8125rem;color:var(--soft);overflow-wrap:anywhere}
";

/// A thin space that does not break: between groups of three digits.
const THIN_SPACE: &str = "\u{202f}";

fn section_html(section: &Section) -> String {
    match section {
        Section::Heading(heading) => format!("<h2>{}</h2>\n", escape(heading)),
        Section::Text(text) => format!("<p>{}</p>\n", escape(text)),
        Section::Table { caption, table } => table_html(caption, table),
        Section::Figure(svg) => format!("<figure class=\"wide\">\n{svg}</figure>\n"),
        Section::Images(images) => images_html("images", images),
        Section::Large(images) => images_html("images large", images),
    }
}

fn table_html(caption: &str, table: &Table) -> String {
    let class = |align| match align {
        Align::Left => "",
        Align::Right => " class=\"n\"",
    };
    let mut html = "<div class=\"wide\"><table>\n".to_owned();
    if !caption.is_empty() {
        html += &format!("<caption>{}</caption>\n", escape(caption));
    }
    html += "<thead><tr>";
    for column in &table.columns {
        html += &format!(
            "<th{}>{}</th>",
            class(column.align),
            escape(&column.heading)
        );
    }
    html += "</tr></thead>\n<tbody>\n";
    for row in &table.rows {
        html += "<tr>";
        for (index, column) in table.columns.iter().enumerate() {
            let cell = row.get(index).unwrap_or(&Cell::Missing).shown(THIN_SPACE);
            html += &format!("<td{}>{}</td>", class(column.align), escape(&cell));
        }
        html += "</tr>\n";
    }
    html + "</tbody>\n</table></div>\n"
}

fn images_html(class: &str, images: &[PageImage]) -> String {
    let images: String = images.iter().map(image_html).collect();
    format!("<div class=\"{class}\">\n{images}</div>\n")
}

fn image_html(image: &PageImage) -> String {
    let caption = escape(&image.caption);
    format!(
        "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{}\">\
         <figcaption>{caption}</figcaption></figure>\n",
        base64(&image.png)
    )
}

/// Text as it may stand in HTML and SVG, also between double quotes. Control characters, which XML
/// forbids, become spaces.
pub(super) fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\'' => escaped += "&#39;",
            _ if character.is_control() || matches!(character, '\u{fffe}' | '\u{ffff}') => {
                escaped.push(' ');
            }
            _ => escaped.push(character),
        }
    }
    escaped
}

/// Bytes in base64 ([RFC 4648](https://www.rfc-editor.org/rfc/rfc4648), section 4).
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let byte = |index: usize| u32::from(chunk.get(index).copied().unwrap_or(0));
        let group = byte(0) << 16 | byte(1) << 8 | byte(2);
        for place in 0..4 {
            let digit = DIGITS[(group >> (18 - 6 * place) & 63) as usize];
            text.push(if place <= chunk.len() {
                char::from(digit)
            } else {
                '='
            });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::super::table::Column;
    use super::*;

    #[test]
    fn base64_of_the_standards_examples() {
        for (text, wanted) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(text.as_bytes()), wanted);
        }
        assert_eq!(base64(&[0xff, 0xfe, 0xfd]), "//79");
    }

    #[test]
    fn nothing_of_the_input_becomes_markup() {
        let evil = "<script>\"'&\u{7}";
        let page = Page {
            title: evil.to_owned(),
            sections: vec![
                Section::Heading(evil.to_owned()),
                Section::Text(evil.to_owned()),
                Section::Table {
                    caption: evil.to_owned(),
                    table: Table {
                        columns: vec![Column::words(evil)],
                        rows: vec![vec![Cell::Text(evil.to_owned())]],
                    },
                },
                Section::Images(vec![PageImage {
                    caption: evil.to_owned(),
                    png: vec![1],
                }]),
            ],
        };
        let html = page.to_html().unwrap();
        assert!(!html.contains("<script") && !html.contains('\u{7}'));
        assert_eq!(html.matches("&lt;script&gt;&quot;&#39;&amp; ").count(), 9);
    }

    #[test]
    fn numbers_stand_at_the_right_in_groups() {
        let table = Table {
            columns: vec![Column::words("a"), Column::numbers("b")],
            rows: vec![vec![Cell::Text("x".to_owned()), Cell::Count(1_234_567)]],
        };
        let html = table_html("", &table);
        assert!(html.contains("<th>a</th><th class=\"n\">b</th>"), "{html}");
        assert!(
            html.contains("<td>x</td><td class=\"n\">1\u{202f}234\u{202f}567</td>"),
            "{html}"
        );
    }

    #[test]
    fn pages_are_bounded() {
        let image = |bytes| PageImage {
            caption: String::new(),
            png: vec![0; bytes],
        };
        let page = |images| Page {
            title: String::new(),
            sections: vec![Section::Images(images)],
        };
        assert!(page(vec![image(1); 24]).to_html().is_ok());
        assert_eq!(
            page(vec![image(1); 25]).to_html().unwrap_err().to_string(),
            "pictures of a page: 25 exceed the limit of 24"
        );
        assert!(page(vec![image(6_000_000)]).to_html().is_err());
    }
}
