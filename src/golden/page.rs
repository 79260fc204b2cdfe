//! What a check found, as a folder with one page for all.

use super::change::Change;
use super::outcome::{Case, Finding, FindingKind, Outcome, SceneOutcome};
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

    /// One page for all that was found: a table of everything, then the pictures and ledgers scene by
    /// scene, as many as a page can hold.
    #[must_use]
    pub fn page(&self) -> Page {
        let counts = self.counts();
        let title = match counts.scenes - counts.same {
            0 if self.is_same() => "Goldens: all the same".to_owned(),
            0 => "Goldens: references that no scene keeps".to_owned(),
            differing => format!(
                "Goldens: {differing} of {} scenes are not the same",
                counts.scenes
            ),
        };
        let mut sections = vec![Section::Text(format!("{}.", self.summary()))];
        let mut room = Room {
            rows: MAX_ROWS,
            pictures: Page::MAX_IMAGES,
        };
        if !self.is_same() {
            sections.push(self.findings_table(&mut room));
        }
        sections.extend(self.tolerated_table(&mut room));
        for scene in self.scenes.iter().filter(|scene| !scene.is_same()) {
            sections.extend(scene_sections(scene, &mut room));
        }
        let left = self
            .findings()
            .filter(|finding| finding.picture().is_some());
        let left = left.count().saturating_sub(Page::MAX_IMAGES);
        if left > 0 {
            sections.push(Section::Text(format!(
                "{left} more pictures lie beside this page, under the names of their references."
            )));
        }
        Page { title, sections }
    }

    fn findings_table(&self, room: &mut Room) -> Section {
        let text = |text: &str| Cell::Text(text.to_owned());
        let mut rows = Vec::new();
        for scene in &self.scenes {
            for case in &scene.cases {
                for finding in &case.findings {
                    let part = match case.case {
                        Case::Frame(_) => format!("{}, {}", case.case, finding.what()),
                        Case::Scene | Case::Digests => case.case.to_string(),
                    };
                    rows.push(vec![
                        text(&scene.name),
                        Cell::Text(part),
                        Cell::Text(finding.words()),
                    ]);
                }
            }
        }
        for stray in &self.strays {
            let file = stray.file.display().to_string();
            rows.push(vec![
                Cell::Text(file),
                text("reference"),
                Cell::Text(stray.words()),
            ]);
        }
        let caption = room.bounded(&mut rows);
        let columns = ["scene", "part", "what is wrong"].map(Column::words);
        Section::Table {
            caption,
            table: Table {
                columns: columns.into(),
                rows,
            },
        }
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
            caption: format!("Passed by the tolerance of the scene {more}"),
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
    pictures: usize,
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

/// The heading, pictures and ledgers of a scene; nothing where there is none to see.
fn scene_sections(scene: &SceneOutcome, room: &mut Room) -> Vec<Section> {
    let mut sections = Vec::new();
    for case in &scene.cases {
        let pictures: Vec<PageImage> = case
            .findings
            .iter()
            .filter_map(|finding| page_image(&case.case.to_string(), finding))
            .take(room.pictures)
            .collect();
        room.pictures -= pictures.len();
        if !pictures.is_empty() {
            sections.push(Section::Images(pictures));
        }
        for finding in &case.findings {
            if let FindingKind::Ledger(changes) = &finding.kind
                && room.rows > 0
            {
                sections.push(ledger_table(&case.case.to_string(), changes, room));
            }
        }
    }
    if !sections.is_empty() {
        sections.insert(0, Section::Heading(scene.name.clone()));
    }
    sections
}

fn page_image(case: &str, finding: &Finding) -> Option<PageImage> {
    let evidence = finding.picture()?;
    let shows = match finding.kind {
        FindingKind::Picture(_) | FindingKind::Size { .. } => "expected | differing | actual",
        _ => "actual",
    };
    Some(PageImage {
        caption: format!("{case}: {shows}. {}", finding.words()),
        png: evidence.bytes.clone(),
    })
}

fn ledger_table(case: &str, changes: &[Change], room: &mut Room) -> Section {
    let cell = |value: &Option<String>| match value {
        None => Cell::Missing,
        Some(text) => match text.parse() {
            Ok(count) => Cell::Count(count),
            Err(_) => Cell::Text(text.clone()),
        },
    };
    let row = |change: &Change| {
        let by = change
            .by()
            .map_or(Cell::Missing, |by| Cell::Text(format!("{by:+}")));
        let what = Cell::Text(change.what.clone());
        vec![what, cell(&change.before), cell(&change.after), by]
    };
    let mut rows: Vec<Vec<Cell>> = changes.iter().map(row).collect();
    let more = room.bounded(&mut rows);
    Section::Table {
        caption: format!("{case}: ledger {more}"),
        table: Table {
            columns: vec![
                Column::words("count"),
                Column::numbers("expected"),
                Column::numbers("actual"),
                Column::numbers("change"),
            ],
            rows,
        },
    }
}
