//! The lines of `digests.txt`.

use std::path::Path;

use super::digests::SceneDigests;
use super::outcome::FindingKind;
use crate::document::Document;

/// What `digests.txt` says.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct DigestLines {
    lines: Vec<DigestLine>,
    /// Numbers of lines that say nothing, and why.
    wrong: Vec<(usize, String)>,
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct DigestLine {
    number: usize,
    scene: String,
    all: String,
    parts: Vec<String>,
}

impl DigestLines {
    /// Reads the file, if it is there; what is wrong with it is kept.
    pub(super) fn read(file: &Path) -> Option<Self> {
        if file.symlink_metadata().is_err() {
            return None;
        }
        Some(match Document::read(file) {
            Ok(document) => Self::parse(&document.text),
            Err(error) => Self {
                lines: Vec::new(),
                wrong: vec![(error.line, error.message)],
            },
        })
    }

    fn parse(text: &str) -> Self {
        let mut found = Self::default();
        for (number, line) in (1..).zip(text.lines()) {
            match DigestLine::parse(number, line) {
                Some(line) if found.find(&line.scene).is_none() => found.lines.push(line),
                Some(line) => {
                    let message = format!("a second line of scene {:?}", line.scene);
                    found.wrong.push((number, message));
                }
                None => {
                    let parts: Vec<String> = SceneDigests::PARTS
                        .iter()
                        .map(|part| format!("{part}=…"))
                        .collect();
                    let message = format!("wanted SCENE DIGEST {}", parts.join(" "));
                    found.wrong.push((number, message));
                }
            }
        }
        found
    }

    /// What is wrong with the line of a scene, if something is.
    ///
    /// Where a tolerance allows other pictures, those and the ledgers' tables, which name them, are
    /// passed over.
    pub(super) fn compare(&self, digests: &SceneDigests, tolerance: u8) -> Option<FindingKind> {
        let Some(known) = self.find(&digests.scene) else {
            return Some(FindingKind::MissingLine);
        };
        let line = digests.to_string();
        // As a line, so that one that says the same is written the same.
        let actual = DigestLine::parse(0, &line)?;
        let compared = if tolerance > 0 {
            3
        } else {
            SceneDigests::PARTS.len()
        };
        let parts = SceneDigests::PARTS.iter().take(compared);
        let mut differing: Vec<String> = parts
            .zip(known.parts.iter().zip(&actual.parts))
            .filter(|(_, (known, actual))| known != actual)
            .map(|(name, _)| (*name).to_owned())
            .collect();
        if differing.is_empty() && tolerance == 0 && known.all != actual.all {
            differing.push("the digest over all parts".to_owned());
        }
        (!differing.is_empty()).then_some(FindingKind::Digests(differing))
    }

    fn find(&self, scene: &str) -> Option<&DigestLine> {
        self.lines.iter().find(|line| line.scene == scene)
    }

    /// The scenes, with the numbers of their lines.
    pub(super) fn names(&self) -> impl Iterator<Item = (usize, &str)> {
        self.lines
            .iter()
            .map(|line| (line.number, line.scene.as_str()))
    }

    /// Numbers of lines that say nothing, and why.
    pub(super) fn wrong(&self) -> impl Iterator<Item = (usize, &str)> {
        self.wrong
            .iter()
            .map(|(number, message)| (*number, message.as_str()))
    }

    /// The text with some lines replaced or added, in the order of names; `keep` decides about those
    /// that are not replaced. Lines that say nothing are dropped.
    pub(super) fn with(&self, renewed: &[SceneDigests], keep: &dyn Fn(&str) -> bool) -> String {
        let mut lines: Vec<(String, String)> = self
            .lines
            .iter()
            .filter(|line| renewed.iter().all(|digests| digests.scene != line.scene))
            .filter(|line| keep(&line.scene))
            .map(|line| (line.scene.clone(), line.text()))
            .collect();
        lines.extend(
            renewed
                .iter()
                .map(|digests| (digests.scene.clone(), digests.to_string())),
        );
        lines.sort();
        lines.iter().map(|(_, line)| format!("{line}\n")).collect()
    }
}

impl DigestLine {
    fn parse(number: usize, line: &str) -> Option<Self> {
        // From the right, since a name may have spaces.
        let mut rest = line.trim_end();
        let mut parts = Vec::new();
        for name in SceneDigests::PARTS.iter().rev() {
            let (before, part) = rest.rsplit_once(' ')?;
            let digits = part.strip_prefix(name)?.strip_prefix('=')?;
            parts.push(hexadecimal(digits, 16)?);
            rest = before;
        }
        parts.reverse();
        let (scene, all) = rest.rsplit_once(' ')?;
        let all = hexadecimal(all, 64)?;
        (!scene.is_empty()).then(|| Self {
            number,
            scene: scene.to_owned(),
            all,
            parts,
        })
    }

    fn text(&self) -> String {
        let mut text = format!("{} {}", self.scene, self.all);
        for (name, part) in SceneDigests::PARTS.iter().zip(&self.parts) {
            text += &format!(" {name}={part}");
        }
        text
    }
}

fn hexadecimal(digits: &str, length: usize) -> Option<String> {
    let is_sound = digits.len() == length && digits.bytes().all(|byte| byte.is_ascii_hexdigit());
    is_sound.then(|| digits.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Digest;

    fn digests(scene: &str, images: u8) -> SceneDigests {
        let digest = |byte| Digest([byte; 32]);
        SceneDigests {
            scene: scene.to_owned(),
            plants: digest(1),
            collapses: digest(2),
            models: digest(3),
            images: digest(images),
            ledgers: digest(5),
        }
    }

    #[test]
    fn lines_read_back_and_say_which_part_differs() {
        let text = format!("{}\n{}\n", digests("a b/c", 4), digests("d", 4));
        let lines = DigestLines::parse(&text);
        assert_eq!(lines.names().collect::<Vec<_>>(), [(1, "a b/c"), (2, "d")]);
        assert_eq!(lines.wrong().count(), 0);
        assert_eq!(lines.compare(&digests("d", 4), 0), None);
        let images = || FindingKind::Digests(vec!["images".to_owned()]);
        assert_eq!(lines.compare(&digests("d", 9), 0), Some(images()));
        assert_eq!(lines.compare(&digests("d", 9), 1), None);
        assert_eq!(
            lines.compare(&digests("e", 4), 0),
            Some(FindingKind::MissingLine)
        );
        let forged =
            DigestLines::parse(&text.replace(&digests("d", 4).all().to_string(), &"0".repeat(64)));
        let all = FindingKind::Digests(vec!["the digest over all parts".to_owned()]);
        assert_eq!(forged.compare(&digests("d", 4), 0), Some(all));

        let renewed = lines.with(&[digests("b", 4), digests("d", 9)], &|_| true);
        let wanted = [digests("a b/c", 4), digests("b", 4), digests("d", 9)];
        assert_eq!(renewed, super::super::digest_text(&wanted));
        let renewed = lines.with(&[], &|name| name == "d");
        assert_eq!(renewed, format!("{}\n", digests("d", 4)));
    }

    #[test]
    fn lines_that_say_nothing_are_told() {
        let line = digests("a", 4).to_string();
        for (text, wrong) in [
            (line.replace(" images", " image"), 1),
            (line.replace("plants=01", "plants=0g"), 1),
            (format!("{line}\n{line}"), 2),
            ("\n".to_owned(), 1),
        ] {
            let lines = DigestLines::parse(&text);
            assert_eq!(
                lines.wrong().map(|(number, _)| number).collect::<Vec<_>>(),
                [wrong],
                "{text}"
            );
        }
    }
}
