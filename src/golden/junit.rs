//! What a check found, as JUnit XML: what continuous integration shows as a list of tests.
//!
//! ```text
//! testsuites ─ testsuite (a folder) ─ testcase (a frame) ─ failure | error
//! ```
//!
//! Elements, their order and their attributes are those that Jenkins' `junit-10.xsd` allows; times
//! are 0, since nothing here reads a clock.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::outcome::{Case, CaseOutcome, Finding, Outcome, SceneOutcome};

/// The tests of a folder.
type Suites<'a> = BTreeMap<&'a str, Vec<Test>>;

/// A test.
struct Test {
    class: String,
    name: String,
    wrong: Option<Wrong>,
}

/// What is wrong with it.
struct Wrong {
    /// `failure` for what differs, `error` for what cannot be compared.
    element: &'static str,
    kind: &'static str,
    message: String,
    text: String,
}

/// The outcome as a JUnit file.
#[must_use]
pub fn junit(outcome: &Outcome) -> String {
    let mut suites = Suites::new();
    for scene in &outcome.scenes {
        let suite = suites.entry(folder_of(&scene.name)).or_default();
        suite.extend(scene.cases.iter().map(|case| case_test(scene, case)));
    }
    if !outcome.strays.is_empty() {
        let strays = outcome.strays.iter().map(stray_test);
        suites.entry("references").or_default().extend(strays);
    }
    let all: Vec<&Test> = suites.values().flatten().collect();
    let mut xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n".to_owned();
    _ = writeln!(xml, "<testsuites name=\"spinney golden\" {}>", counts(&all));
    for (name, tests) in &suites {
        let tests: Vec<&Test> = tests.iter().collect();
        let (name, counts) = (attribute(name), counts(&tests));
        _ = writeln!(xml, "  <testsuite name=\"{name}\" {counts} skipped=\"0\">");
        for test in tests {
            xml += &test.xml();
        }
        xml += "  </testsuite>\n";
    }
    xml + "</testsuites>\n"
}

/// The folder of a scene, `.` for that of all scenes.
fn folder_of(name: &str) -> &str {
    name.rsplit_once('/').map_or(".", |(folder, _)| folder)
}

fn case_test(scene: &SceneOutcome, case: &CaseOutcome) -> Test {
    let words = case.words(scene.reason.as_deref()).unwrap_or_default();
    let wrong = case.findings.first().map(|first| Wrong {
        element: match case.case {
            Case::Scene => "error",
            Case::Frame(_) | Case::Digests => "failure",
        },
        kind: first.kind.name(),
        message: words,
        text: findings_text(&case.findings),
    });
    Test {
        class: scene.name.clone(),
        name: case.case.to_string(),
        wrong,
    }
}

fn stray_test(stray: &Finding) -> Test {
    Test {
        class: "references".to_owned(),
        name: stray.file.display().to_string(),
        wrong: Some(Wrong {
            element: "failure",
            kind: stray.kind.name(),
            message: stray.words(),
            text: findings_text(std::slice::from_ref(stray)),
        }),
    }
}

/// All that is known, a line each.
fn findings_text(findings: &[Finding]) -> String {
    let mut text = String::new();
    for finding in findings {
        text += &format!("{finding}\n");
        if let super::FindingKind::Ledger(changes) = &finding.kind {
            for change in changes {
                text += &format!("  {change}\n");
            }
        }
    }
    text
}

fn counts(tests: &[&Test]) -> String {
    let count = |element| {
        let wrong = tests.iter().filter_map(|test| test.wrong.as_ref());
        wrong.filter(|wrong| wrong.element == element).count()
    };
    format!(
        "tests=\"{}\" failures=\"{}\" errors=\"{}\" time=\"0\"",
        tests.len(),
        count("failure"),
        count("error")
    )
}

impl Test {
    fn xml(&self) -> String {
        let (class, name) = (attribute(&self.class), attribute(&self.name));
        let head = format!("    <testcase classname=\"{class}\" name=\"{name}\" time=\"0\"");
        let Some(wrong) = &self.wrong else {
            return format!("{head}/>\n");
        };
        let Wrong { element, kind, .. } = wrong;
        let (message, text) = (attribute(&wrong.message), escaped(&wrong.text));
        format!(
            "{head}>\n      <{element} message=\"{message}\" type=\"{kind}\">{text}</{element}>\n    \
             </testcase>\n"
        )
    }
}

/// Text within an element; characters that XML forbids become spaces.
fn escaped(text: &str) -> String {
    let mut xml = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => xml += "&amp;",
            '<' => xml += "&lt;",
            '>' => xml += "&gt;",
            '"' => xml += "&quot;",
            '\'' => xml += "&apos;",
            '\n' => xml.push('\n'),
            _ if character.is_control() || matches!(character, '\u{fffe}' | '\u{ffff}') => {
                xml.push(' ');
            }
            _ => xml.push(character),
        }
    }
    xml
}

/// Text between double quotes: line feeds, which a reader would take for spaces, by their number.
fn attribute(text: &str) -> String {
    escaped(text).replace('\n', "&#10;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::golden::FindingKind;

    #[test]
    fn every_frame_is_a_test_in_the_suite_of_its_folder() {
        let finding = |kind| Finding {
            file: "golden/b/c-0003.png".into(),
            kind,
            evidence: None,
        };
        let case = |case, findings| CaseOutcome {
            case,
            findings,
            tolerated: None,
        };
        let scene = |name: &str, cases| SceneOutcome {
            name: name.to_owned(),
            file: format!("scenes/{name}.toml").into(),
            line: 1,
            tolerance: 0,
            reason: None,
            cases,
        };
        let missing = vec![finding(FindingKind::Missing)];
        let broken = FindingKind::Unreadable("<\"\u{7}'&>\nno".to_owned());
        let outcome = Outcome {
            scenes: vec![
                scene("a", vec![case(Case::Scene, vec![finding(broken)])]),
                scene(
                    "b/c",
                    vec![
                        case(Case::Frame(0), Vec::new()),
                        case(Case::Frame(3), missing),
                    ],
                ),
            ],
            strays: vec![finding(FindingKind::Unused)],
            digests: false,
        };
        assert_eq!(
            junit(&outcome),
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>
<testsuites name=\"spinney golden\" tests=\"4\" failures=\"2\" errors=\"1\" time=\"0\">
  <testsuite name=\".\" tests=\"1\" failures=\"0\" errors=\"1\" time=\"0\" skipped=\"0\">
    <testcase classname=\"a\" name=\"scene\" time=\"0\">
      <error message=\"picture: &lt;&quot; &apos;&amp;&gt;&#10;no\" type=\"unreadable\">golden/b/c-0003.png: &lt;&quot; &apos;&amp;&gt;\nno
</error>
    </testcase>
  </testsuite>
  <testsuite name=\"b\" tests=\"2\" failures=\"1\" errors=\"0\" time=\"0\" skipped=\"0\">
    <testcase classname=\"b/c\" name=\"frame 0\" time=\"0\"/>
    <testcase classname=\"b/c\" name=\"frame 3\" time=\"0\">
      <failure message=\"picture: missing\" type=\"missing\">golden/b/c-0003.png: missing
</failure>
    </testcase>
  </testsuite>
  <testsuite name=\"references\" tests=\"1\" failures=\"1\" errors=\"0\" time=\"0\" skipped=\"0\">
    <testcase classname=\"references\" name=\"golden/b/c-0003.png\" time=\"0\">
      <failure message=\"unused: no scene keeps it\" type=\"unused\">golden/b/c-0003.png: unused: no scene keeps it
</failure>
    </testcase>
  </testsuite>
</testsuites>
"
        );
    }
}
