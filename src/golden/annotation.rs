//! What a check found, where GitHub shows it beside the code.
//!
//! A line `::error file=…,line=…,title=…::MESSAGE` that a step of a workflow prints becomes an
//! annotation ([workflow commands]). As GitHub's own toolkit does, `%`, carriage return and line feed
//! are written as `%25`, `%0D` and `%0A`, and in properties also `:` and `,` as `%3A` and `%2C`.
//!
//! [workflow commands]: https://docs.github.com/en/actions/reference/workflows-and-actions/workflow-commands

use std::path::Path;

use super::outcome::Outcome;

/// A line for every scene and every stray of which something is wrong.
#[must_use]
pub fn github_annotations(outcome: &Outcome) -> String {
    let mut text = String::new();
    for scene in outcome.scenes.iter().filter(|scene| !scene.is_same()) {
        let title = format!("{} is not as its reference", scene.name);
        let message = scene.lines().join("\n");
        text += &annotation(&scene.file, Some(scene.line), &title, &message);
    }
    for stray in &outcome.strays {
        let title = format!("{} reference", stray.kind.name());
        text += &annotation(&stray.file, None, &title, &stray.to_string());
    }
    text
}

fn annotation(file: &Path, line: Option<usize>, title: &str, message: &str) -> String {
    // GitHub wants the separators of its own paths.
    let file = file.display().to_string();
    let file = property(&file.replace(std::path::MAIN_SEPARATOR, "/"));
    let line = line.map_or(String::new(), |line| format!(",line={line}"));
    let title = property(title);
    format!(
        "::error file={file}{line},title={title}::{}\n",
        data(message)
    )
}

fn data(text: &str) -> String {
    text.replace('%', "%25")
        .replace('\r', "%0D")
        .replace('\n', "%0A")
}

fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_end_a_message_or_property_is_escaped() {
        assert_eq!(
            annotation(
                Path::new("a,b:c%.toml"),
                Some(3),
                "t: u, v",
                "100 %\r\nx: y, z"
            ),
            "::error file=a%2Cb%3Ac%25.toml,line=3,title=t%3A u%2C v::100 %25%0D%0Ax: y, z\n"
        );
        assert_eq!(
            annotation(Path::new("a/b.png"), None, "t", "m"),
            "::error file=a/b.png,title=t::m\n"
        );
    }
}
