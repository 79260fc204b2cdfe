//! What a check found, in lines of text.

use super::outcome::{CaseOutcome, Counts, Evidence, Finding, FindingKind, Outcome, SceneOutcome};

impl Finding {
    /// What it is about: `picture`, `ledger`, `digests` or `scene`.
    #[must_use]
    pub fn what(&self) -> &'static str {
        let name = self.file.file_name().unwrap_or_default().to_string_lossy();
        match &self.kind {
            FindingKind::Digests(_) | FindingKind::MissingLine | FindingKind::UnusedLine { .. } => {
                "digests"
            }
            _ if name == "digests.txt" => "digests",
            _ if name.ends_with(".png") => "picture",
            _ if name.ends_with(".txt") => "ledger",
            _ => "scene",
        }
    }

    /// What is wrong, in words that do not name the file.
    #[must_use]
    pub fn words(&self) -> String {
        match &self.kind {
            FindingKind::Unreadable(message) => {
                let file = self.file.display().to_string();
                let rest = message.strip_prefix(&file);
                rest.map_or(message.as_str(), |rest| rest.trim_start_matches([':', ' ']))
                    .to_owned()
            }
            kind => kind.to_string(),
        }
    }

    /// The picture to look at, if there is one.
    #[must_use]
    pub fn picture(&self) -> Option<&Evidence> {
        let evidence = self.evidence.as_ref();
        evidence.filter(|evidence| evidence.name.ends_with(".png"))
    }
}

impl CaseOutcome {
    /// What is wrong, or passes by a tolerance; `None` where there is nothing to tell.
    #[must_use]
    pub fn words(&self, reason: Option<&str>) -> Option<String> {
        let mut words: Vec<String> = self
            .findings
            .iter()
            .map(|finding| format!("{}: {}", finding.what(), finding.words()))
            .collect();
        if let Some(difference) = &self.tolerated {
            let reason = reason.unwrap_or_default();
            words.push(format!("picture: {difference} ({reason})"));
        }
        (!words.is_empty()).then(|| words.join("; "))
    }
}

impl SceneOutcome {
    /// A line for each part of which there is something to tell: `frame 4: picture: …; ledger: …`.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let line = |case: &CaseOutcome| {
            let words = case.words(self.reason.as_deref())?;
            // What is wrong with a whole scene says so.
            let named = format!("{}: {words}", case.case);
            Some(named.replacen("scene: scene: ", "", 1).replacen(
                "digests: digests: ",
                "digests: ",
                1,
            ))
        };
        self.cases.iter().filter_map(line).collect()
    }
}

impl Outcome {
    /// The outcome as text: a line for every part of a scene and every stray of which there is something
    /// to tell, and one that sums up.
    #[must_use]
    pub fn to_text(&self) -> String {
        let mut text = String::new();
        for scene in &self.scenes {
            for line in scene.lines() {
                text += &format!("{}: {line}\n", scene.name);
            }
        }
        for stray in &self.strays {
            text += &format!("{stray}\n");
        }
        text + &self.summary() + "\n"
    }

    /// One line: `35 scenes, 63 frames: 2 differ, 1 missing, 32 scenes the same`.
    #[must_use]
    pub fn summary(&self) -> String {
        let counts = self.counts();
        let extent = self.extent();
        let mut wrong: Vec<String> = counts
            .wrong()
            .iter()
            .filter(|(_, count)| *count > 0)
            .map(|(name, count)| format!("{count} {name}"))
            .collect();
        if wrong.is_empty() {
            return format!("{extent}: all the same");
        }
        wrong.push(format!("{} the same", plural(counts.same, "scene")));
        format!("{extent}: {}", wrong.join(", "))
    }

    /// How much was compared: `35 scenes, 63 frames, 2 of them within a tolerance`.
    pub(super) fn extent(&self) -> String {
        let counts = self.counts();
        let scenes = plural(counts.scenes, "scene");
        let frames = plural(counts.frames, "frame");
        match counts.tolerated {
            0 => format!("{scenes}, {frames}"),
            some => format!("{scenes}, {frames}, {some} of them within a tolerance"),
        }
    }
}

impl Counts {
    /// What is wrong, by name.
    #[must_use]
    pub fn wrong(&self) -> [(&'static str, usize); 5] {
        [
            ("differ", self.differ),
            ("missing", self.missing),
            ("unused", self.unused),
            ("oversized", self.oversized),
            ("unreadable", self.unreadable),
        ]
    }
}

fn plural(count: usize, noun: &str) -> String {
    match count {
        1 => format!("1 {noun}"),
        _ => format!("{count} {noun}s"),
    }
}
