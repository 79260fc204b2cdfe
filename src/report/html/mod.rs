//! Pages that open offline: one HTML file with its style, its script and its images in it.
//!
//! ```text
//! Page ─▶ section by section ─┬─ table_html        sorts by its headings
//!                             ├─ Comparison        two of its pictures, a divider, their difference
//!                             └─ figures, text, the scene as text
//! ```
//!
//! **Invariant.** Nothing of a page leads out of it: its own policy forbids the browser to load
//! anything, and to run anything but what stands in it. All that can be read can be read without the
//! script; it only adds ways to look.

mod comparison;
mod table;
mod text;

pub use comparison::{Choice, Comparison};

pub(super) use text::{THIN_SPACE, escape};

use self::comparison::images_html;
use self::table::table_html;
use self::text::escape_lines;
use super::table::Table;
use super::thumbnail::shrink;
use super::{Picture, ReportError};
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
    /// A few figures that say the most, each with its name.
    Facts(Vec<(String, String)>),
    /// A table with its caption; wide ones scroll sideways.
    Table {
        /// What it shows; may be empty.
        caption: String,
        /// The table; a last row called `all` holds the sums of the others.
        table: Table,
    },
    /// An SVG file that spinney made, such as [`Plot::to_svg`](super::Plot::to_svg); it is put in
    /// as it is, and scrolls sideways where its text would become too small.
    Figure(String),
    /// Small SVG files that spinney made, as many beside each other as fit.
    Panels(Vec<String>),
    /// Pictures beside each other.
    Images(Vec<PageImage>),
    /// Pictures beside each other, two a row where the window is wide, else one.
    Large(Vec<PageImage>),
    /// Pictures of which any two can be held against each other.
    Comparison(Comparison),
    /// Text of many lines that opens and can be copied, such as a scene.
    Source {
        /// What it is.
        summary: String,
        /// The text.
        text: String,
    },
}

/// A picture on a page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PageImage {
    /// What stands below it.
    pub caption: String,
    /// A PNG file.
    pub png: Vec<u8>,
}

impl Section {
    /// The scene that a page is about, below a heading; nothing without one.
    pub(super) fn scene(resolved: &str) -> Vec<Self> {
        if resolved.is_empty() {
            return Vec::new();
        }
        vec![
            Self::Heading("The scene that made it".to_owned()),
            Self::Source {
                summary: "The whole scene, every choice resolved".to_owned(),
                text: resolved.to_owned(),
            },
        ]
    }
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
        let images: usize = self.sections.iter().map(image_count).sum();
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
             <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{title}</h1>\n"
        );
        for (number, section) in self.sections.iter().enumerate() {
            html += &section_html(number, section);
        }
        html += &format!("</main>\n<script>{SCRIPT}</script>\n</body>\n</html>\n");
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

/// What a browser may load for a page: what it holds itself.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'; \
     base-uri 'none'; form-action 'none'";

const STYLE: &str = include_str!("style.css");

const SCRIPT: &str = include_str!("script.js");

/// What stands below pictures of frames.
pub(super) const SMALLER: &str = "Pictures may be smaller than the frames, by a whole factor; pixels are counted in \
     what is shown here.";

/// Bytes of a [source](Section::Source) that a page shows: a wood of thousands of trees takes more.
const SOURCE_BYTES: usize = 200_000;

fn image_count(section: &Section) -> usize {
    match section {
        Section::Images(images) | Section::Large(images) => images.len(),
        Section::Comparison(comparison) => comparison.pictures.len(),
        Section::Heading(_)
        | Section::Text(_)
        | Section::Facts(_)
        | Section::Table { .. }
        | Section::Figure(_)
        | Section::Panels(_)
        | Section::Source { .. } => 0,
    }
}

fn section_html(number: usize, section: &Section) -> String {
    match section {
        Section::Heading(heading) => format!("<h2>{}</h2>\n", escape(heading)),
        Section::Text(text) => format!("<p>{}</p>\n", escape(text)),
        Section::Facts(facts) => facts_html(facts),
        Section::Table { caption, table } => table_html(caption, table),
        Section::Figure(svg) => format!("<figure class=\"wide\">\n{svg}</figure>\n"),
        Section::Panels(panels) => {
            let panel = |svg: &String| format!("<figure>\n{svg}</figure>\n");
            let panels: String = panels.iter().map(panel).collect();
            format!("<div class=\"panels\">\n{panels}</div>\n")
        }
        Section::Images(images) => images_html("images", images),
        Section::Large(images) => images_html("images large", images),
        Section::Comparison(comparison) => comparison.to_html(number),
        Section::Source { summary, text } => source_html(summary, text),
    }
}

fn facts_html(facts: &[(String, String)]) -> String {
    let fact = |(name, value): &(String, String)| {
        let (name, value) = (escape(name), escape(value));
        format!("<div><dt>{name}</dt><dd>{value}</dd></div>\n")
    };
    let facts: String = facts.iter().map(fact).collect();
    format!("<dl class=\"facts\">\n{facts}</dl>\n")
}

fn source_html(summary: &str, text: &str) -> String {
    let most = (0..=text.len().min(SOURCE_BYTES)).rev();
    let end = most.into_iter().find(|&end| text.is_char_boundary(end));
    let shown = &text[..end.unwrap_or(0)];
    let more = match text.len() - shown.len() {
        0 => String::new(),
        more => format!("<p>{more} more bytes do not fit here.</p>\n"),
    };
    format!(
        "<details class=\"source\"><summary>{}</summary>\n<pre><code>{}</code></pre>\n{more}</details>\n",
        escape(summary),
        escape_lines(shown)
    )
}

/// The first that is small enough of pages with the same pictures: as they are, with sides halved until
/// none is longer than 80 pixels, and at last without. `page` makes one of the pictures' PNG files.
pub(super) fn fitting(
    mut pictures: Vec<Picture>,
    page: impl Fn(Vec<Vec<u8>>) -> Page,
) -> Result<String, ReportError> {
    loop {
        let files = pictures.iter().map(Picture::to_png);
        let html = page(files.collect::<Result<_, _>>()?).to_html();
        if pictures.is_empty() || !matches!(html, Err(ReportError::TooLarge { .. })) {
            return html;
        }
        let sides = pictures
            .iter()
            .map(|picture| picture.width().max(picture.height()));
        if sides.max() > Some(80) {
            for picture in &mut pictures {
                *picture = shrink(picture, 2)?;
            }
        } else {
            pictures.clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::{Cell, Column};
    use super::*;

    #[test]
    fn nothing_of_the_input_becomes_markup() {
        let evil = "<script>\"'&\u{7}";
        let image = PageImage {
            caption: evil.to_owned(),
            png: vec![1],
        };
        let choice = Choice {
            name: evil.to_owned(),
            values: vec![evil.to_owned(); 2],
        };
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
                Section::Facts(vec![(evil.to_owned(), evil.to_owned())]),
                Section::Source {
                    summary: evil.to_owned(),
                    text: evil.to_owned(),
                },
                Section::Images(vec![image.clone()]),
                Section::Comparison(Comparison {
                    ways: choice.clone(),
                    places: choice,
                    shows: vec![vec![0, 0]; 2],
                    pictures: vec![image.clone(), image],
                    begin: [[0, 0], [1, 1]],
                }),
            ],
        };
        let html = page.to_html().unwrap();
        // The only script is the page's own.
        assert_eq!(html.matches("<script").count(), 1);
        assert!(html.contains(&format!("<script>{SCRIPT}</script>")));
        assert!(!html.contains('\u{7}'));
        // Nine of what stands above, two facts, two of the source; of the comparison two captions twice,
        // two options and a label in each chooser, two names of places, and what they are called twice.
        let count = html.matches("&lt;script&gt;&quot;&#39;&amp; ").count();
        assert_eq!(count, 9 + 2 + 2 + 4 + 2 * 3 + 2 + 2 * 2);
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

    #[test]
    fn long_scenes_are_cut_and_say_so() {
        let text = "ä\n".repeat(SOURCE_BYTES / 2);
        let html = source_html("The scene", &text);
        assert!(
            html.contains("<p>100000 more bytes do not fit here.</p>"),
            "{}",
            &html[..90]
        );
        assert!(!source_html("The scene", "seed = 1\n").contains("do not fit"));
    }

    #[test]
    fn pictures_give_way_to_the_rest() {
        // Noise, which no encoder makes smaller: 24 of 320 × 320 take 13 MB in base64.
        let stream = crate::math::Stream::new(1, 0);
        let bytes = (0..4 * 320 * 320_u64).map(|index| stream.below(index, 256));
        let bytes = bytes.map(|byte| u8::try_from(byte).expect("a byte"));
        let noise = Picture::new(320, 320, bytes.collect()).unwrap();
        let page = |text: usize| {
            move |files: Vec<Vec<u8>>| {
                let image = |png| PageImage {
                    caption: String::new(),
                    png,
                };
                Page {
                    title: "noise".to_owned(),
                    sections: vec![
                        Section::Text("x".repeat(text)),
                        Section::Images(files.into_iter().map(image).collect()),
                    ],
                }
            }
        };
        let small = fitting(vec![noise.clone(); 24], page(0)).unwrap();
        assert!(
            (1_000_000..Page::MAX_BYTES).contains(&small.len()),
            "{}",
            small.len()
        );
        assert_eq!(small.matches("<img ").count(), 24);
        let bare = fitting(vec![noise.clone(); 2], page(Page::MAX_BYTES - 30_000)).unwrap();
        assert!(!bare.contains("<img "));
        assert!(fitting(vec![noise], page(Page::MAX_BYTES)).is_err());
    }
}
