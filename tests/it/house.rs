//! House rules that no lint holds: short files, no test that is skipped, no `unsafe`.

use std::path::{Path, PathBuf};

/// Past this a file holds two ideas.
const MAX_LINES: usize = 600;

/// Where our code lies.
const FOLDERS: [&str; 4] = ["src", "tests", "benches", "examples"];

#[test]
fn files_are_short_and_nothing_is_skipped_or_unsafe() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    for folder in FOLDERS {
        collect(&root.join(folder), &mut files);
    }
    assert!(files.len() > 100, "only {} files", files.len());
    files.sort();
    let mut wrong = Vec::new();
    for file in files {
        let text = std::fs::read_to_string(&file).expect("UTF-8");
        let name = file.strip_prefix(root).expect("below the root").display();
        wrong.extend(check(&text).into_iter().map(|what| format!("{name}{what}")));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What is wrong with a file: at which line, what.
fn check(text: &str) -> Vec<String> {
    let mut wrong = Vec::new();
    for (number, line) in (1..).zip(text.lines()) {
        let code = line.trim_start();
        let skipped = ["#[ignore", "#![ignore"]
            .iter()
            .any(|mark| code.starts_with(mark));
        if skipped {
            wrong.push(format!(":{number}: a test that is skipped"));
        }
        let mut words = code.split(|c: char| !(c.is_alphanumeric() || c == '_'));
        let comment = code.starts_with("//");
        if !comment && !code.contains('"') && words.any(|word| word == "unsafe") {
            wrong.push(format!(":{number}: code that is unsafe"));
        }
    }
    let lines = text.lines().count();
    if lines > MAX_LINES {
        wrong.push(format!(": {lines} lines, at most {MAX_LINES}"));
    }
    wrong
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("readable").path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
}

#[test]
fn breaches_are_found() {
    assert_eq!(
        check("    #[ignore]\nfn a() {}"),
        [":1: a test that is skipped"]
    );
    assert_eq!(
        check("fn a() {}\nunsafe fn b() {}"),
        [":2: code that is unsafe"]
    );
    assert_eq!(
        check("// unsafe\n//! unsafe { }\nfn unsafely() {}"),
        [""; 0]
    );
    let long = "\n".repeat(MAX_LINES + 1);
    assert_eq!(check(&long), [": 601 lines, at most 600"]);
    assert_eq!(check(&long[1..]), [""; 0]);
}
