//! What a check found, as a folder with one page for all.

use super::change::{Change, shown};
use super::outcome::{Case, CaseOutcome, Finding, FindingKind, Outcome, SceneOutcome};
use crate::report::{Cell, Column, OutputFolder, Page, PageImage, ReportError, Section, Table};

/// The most rows of the page's tables together; what is more is counted.
const MAX_ROWS: usize = 4000;

impl Outcome {
    /// Writes `report.html`, and beside it what there is to look at, under the names of references.
    ///
    /// # Errors
    ///
    /// When a file cannot be written.
    pub fn write(&self, folder: &OutputFolder) -> Result<(), ReportError> {
        for evidence in self
            .findings()
            .filter_map(|finding| finding.evidence.as_ref())
        {
            folder.write(&evidence.name, &evidence.bytes)?;
        }
        folder.write("report.html", self.page().to_html()?.as_bytes())
    }

    /// One page for all that was found: a table of scenes, as many pictures as a page can hold, then
    /// what is wrong scene by scene.
    #[must_use]
    pub fn page(&self) -> Page {
        let counts = self.counts();
        let title = match counts.scenes - counts.same {
            0 if self.is_same() => "Goldens: all the same".to_owned(),
            0 => "Goldens: references that no scene keeps".to_owned(),
            1 => format!("Goldens: 1 of {} scenes is not the same", counts.scenes),
            more => format!(
                "Goldens: {more} of {} scenes are not the same",
                counts.scenes
            ),
        };
        let mut sections = vec![Section::Text(format!("{}.", self.summary()))];
        let mut room = Room { rows: MAX_ROWS };
        if !self.is_same() {
            sections.push(self.overview(&mut room));
        }
        sections.extend(self.tolerated_table(&mut room));
        sections.extend(self.pictures());
        for scene in self.scenes.iter().filter(|scene| !scene.is_same()) {
            sections.extend(scene_sections(scene, &mut room));
        }
        Page { title, sections }
    }

    /// The scenes that are not the same, and in what, in as few words as can be.
    fn overview(&self, room: &mut Room) -> Section {
        let mut rows = Vec::new();
        for scene in self.scenes.iter().filter(|scene| !scene.is_same()) {
            let parts: Vec<String> = scene.cases.iter().filter_map(case_words).collect();
            let name = Cell::Text(scene.name.clone());
            rows.push(vec![name, Cell::Text(parts.join("; "))]);
        }
        for stray in &self.strays {
            let file = Cell::Text(stray.file.display().to_string());
            rows.push(vec![file, Cell::Text(stray.words())]);
        }
        let caption = room.bounded(&mut rows);
        let columns = ["scene", "what is not the same"].map(Column::words);
        Section::Table {
            caption,
            table: Table {
                columns: columns.into(),
                rows,
            },
        }
    }

    /// The pictures that differ.
    fn pictures(&self) -> Vec<Section> {
        let cases = self.scenes.iter().flat_map(|scene| {
            let name = scene.name.as_str();
            scene.cases.iter().map(move |case| (name, case))
        });
        let mut images: Vec<PageImage> = cases
            .flat_map(|(name, case)| {
                let findings = case.findings.iter();
                findings.filter_map(move |finding| page_image(name, case, finding))
            })
            .collect();
        if images.is_empty() {
            return Vec::new();
        }
        let left = images.len().saturating_sub(Page::MAX_IMAGES);
        images.truncate(Page::MAX_IMAGES);
        let mut sections = vec![
            Section::Heading("Expected | differing | actual".to_owned()),
            Section::Large(images),
        ];
        if left > 0 {
            sections.push(Section::Text(format!(
                "{left} more pictures lie beside this page, under the names of their references."
            )));
        }
        sections
    }

    /// What passes by a tolerance, with the reason for it.
    fn tolerated_table(&self, room: &mut Room) -> Option<Section> {
        let mut rows = Vec::new();
        for scene in &self.scenes {
            for case in &scene.cases {
                if let Some(difference) = &case.tolerated {
                    rows.push(vec![
                        Cell::Text(scene.name.clone()),
                        Cell::Text(case.case.to_string()),
                        Cell::Text(difference.to_string()),
                        Cell::Text(scene.reason.clone().unwrap_or_default()),
                    ]);
                }
            }
        }
        if rows.is_empty() {
            return None;
        }
        let more = room.bounded(&mut rows);
        let columns = ["scene", "part", "what passes", "reason"].map(Column::words);
        Some(Section::Table {
            caption: format!("What passes by the tolerance of its scene {more}"),
            table: Table {
                columns: columns.into(),
                rows,
            },
        })
    }
}

/// What still fits on a page.
struct Room {
    rows: usize,
}

impl Room {
    /// Cuts rows to those that fit; says how many were cut.
    fn bounded(&mut self, rows: &mut Vec<Vec<Cell>>) -> String {
        let cut = rows.len().saturating_sub(self.rows);
        rows.truncate(self.rows);
        self.rows -= rows.len();
        match cut {
            0 => String::new(),
            cut => format!("({cut} more rows do not fit here)"),
        }
    }
}

/// `frame 4: picture, ledger missing`.
fn case_words(case: &CaseOutcome) -> Option<String> {
    let words: Vec<String> = case
        .findings
        .iter()
        .map(|finding| match finding.kind.name() {
            "differs" => finding.what().to_owned(),
            name => format!("{} {name}", finding.what()),
        })
        .collect();
    match case.case {
        _ if words.is_empty() => None,
        Case::Frame(_) => Some(format!("{}: {}", case.case, words.join(", "))),
        Case::Scene | Case::Digests => Some(words.join(", ")),
    }
}

/// Heading, words and ledgers of a scene; nothing where a page has no more room.
fn scene_sections(scene: &SceneOutcome, room: &mut Room) -> Vec<Section> {
    if room.rows == 0 {
        return Vec::new();
    }
    let mut sections = vec![
        Section::Heading(scene.name.clone()),
        Section::Text(format!("{}:{}", scene.file.display(), scene.line)),
    ];
    for case in &scene.cases {
        for finding in &case.findings {
            match &finding.kind {
                FindingKind::Ledger(changes) if !changes.is_empty() => {
                    sections.push(ledger_table(&case.case.to_string(), changes, room));
                }
                _ => {
                    room.rows = room.rows.saturating_sub(1);
                    let mut words = format!("{}: {}", finding.what(), finding.words());
                    if matches!(case.case, Case::Frame(_)) {
                        words = format!("{}: {words}", case.case);
                    }
                    sections.push(Section::Text(words));
                }
            }
        }
    }
    sections
}

/// What a finding about a picture shows, with its scene and frame.
fn page_image(scene: &str, case: &CaseOutcome, finding: &Finding) -> Option<PageImage> {
    let evidence = finding.picture()?;
    let alone = match finding.kind {
        FindingKind::Picture(_) | FindingKind::Size { .. } => "",
        _ => " (this is what it shows)",
    };
    Some(PageImage {
        caption: format!("{scene}, {}: {}{alone}", case.case, finding.words()),
        png: evidence.bytes.clone(),
    })
}

fn ledger_table(case: &str, changes: &[Change], room: &mut Room) -> Section {
    let cell = |value: &Option<String>| match value {
        None => Cell::Missing,
        Some(text) => match text.parse() {
            Ok(count) => Cell::Count(count),
            Err(_) => Cell::Text(shown(Some(text))),
        },
    };
    // The change stands first, so that a narrow window shows it.
    let row = |change: &Change| {
        let by = change
            .by()
            .map_or(Cell::Missing, |by| Cell::Text(format!("{by:+}")));
        let what = Cell::Text(change.what.clone());
        vec![what, by, cell(&change.before), cell(&change.after)]
    };
    let mut rows: Vec<Vec<Cell>> = changes.iter().map(row).collect();
    let more = room.bounded(&mut rows);
    Section::Table {
        caption: format!("{case}: ledger {more}"),
        table: Table {
            columns: vec![
                Column::words("count"),
                Column::numbers("change"),
                Column::numbers("expected"),
                Column::numbers("actual"),
            ],
            rows,
        },
    }
}
