//! Who may name whom: the table of stages, checked on the text of `src/`.
//!
//! A path that begins with `crate::`, or with as many `super::` as lead to the root, names the stage
//! that follows. Comments and texts are no code and may name anything.

use std::path::{Path, PathBuf};

/// Every stage, and the stages that it may name. All may name `limits`, which names none, and
/// `document`, which names only that.
/// `lib.rs` and `main.rs` belong to no stage: they name all.
const STAGES: &[(&str, &[&str])] = &[
    ("limits", &[]),
    ("document", &["limits"]),
    ("math", &[]),
    ("raster", &["math"]),
    ("plant", &["math"]),
    ("scene", &["math", "plant"]),
    ("gpu", &["math", "raster"]),
    ("simplify", &["math", "plant"]),
    ("models", &["math", "scene", "plant", "simplify", "gpu"]),
    (
        "run",
        &[
            "math", "raster", "plant", "scene", "gpu", "simplify", "models",
        ],
    ),
    ("report", &["math", "gpu", "models", "run"]),
    (
        "golden",
        &["math", "scene", "gpu", "models", "run", "report"],
    ),
    (
        "explain",
        &["math", "scene", "gpu", "models", "run", "report", "golden"],
    ),
    (
        "testkit",
        &[
            "math", "raster", "plant", "scene", "gpu", "simplify", "models", "run", "report",
            "golden", "explain",
        ],
    ),
    (
        "cli",
        &[
            "math", "raster", "plant", "scene", "gpu", "simplify", "models", "run", "report",
            "golden", "explain", "testkit",
        ],
    ),
];

#[test]
fn stages_name_only_whom_they_may() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    collect(&source, &mut files);
    files.sort();
    assert!(files.len() > 10, "{files:?}");
    let violations: Vec<String> = files
        .iter()
        .flat_map(|file| {
            let parts = file.strip_prefix(&source).expect("below src").iter();
            let name: Vec<_> = parts.map(|part| part.to_string_lossy()).collect();
            let text = std::fs::read_to_string(file).expect("UTF-8");
            check(&name.join("/"), &text)
        })
        .collect();
    assert!(violations.is_empty(), "{}", violations.join("\n"));
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

/// What is wrong with a file, by its path below `src`.
fn check(file: &str, text: &str) -> Vec<String> {
    if ["lib.rs", "main.rs"].contains(&file) {
        return Vec::new();
    }
    let module: Vec<&str> = file
        .trim_end_matches(".rs")
        .split('/')
        .filter(|part| *part != "mod")
        .collect();
    let Some((stage, allowed)) = STAGES
        .iter()
        .find(|(stage, _)| module.first() == Some(stage))
    else {
        return vec![format!("src/{file}: belongs to no stage of the table")];
    };
    let may_name = |name: &str| {
        name == *stage
            || allowed.contains(&name)
            || (matches!(name, "document" | "limits") && *stage != "limits")
    };
    named_at_root(&tokens(text), module.len())
        .into_iter()
        .filter(|(_, name)| !may_name(name))
        .map(|(line, name)| format!("src/{file}:{line}: `{stage}` must not name `{name}`"))
        .collect()
}

/// A word or a sign of code, with its line.
type Token = (usize, String);

/// The words and signs of code: no comments, texts or characters; `::` is one sign.
fn tokens(text: &str) -> Vec<Token> {
    let characters: Vec<char> = text.chars().collect();
    let at = |index: usize| characters.get(index).copied().unwrap_or('\0');
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut tokens = Vec::new();
    let (mut index, mut line) = (0, 1);
    while index < characters.len() {
        let start = index;
        match at(index) {
            '/' if at(index + 1) == '/' => {
                while index < characters.len() && at(index) != '\n' {
                    index += 1;
                }
            }
            '/' if at(index + 1) == '*' => {
                let mut depth = 0;
                loop {
                    match (at(index), at(index + 1)) {
                        ('/', '*') => depth += 1,
                        ('*', '/') => depth -= 1,
                        _ => {
                            index += 1;
                            continue;
                        }
                    }
                    index += 2;
                    if depth == 0 || index >= characters.len() {
                        break;
                    }
                }
            }
            '"' => index = text_end(&characters, index),
            // A character, not a lifetime.
            '\'' if at(index + 1) == '\\' || at(index + 2) == '\'' => {
                index += if at(index + 1) == '\\' { 3 } else { 2 };
                while index < characters.len() && at(index) != '\'' {
                    index += 1;
                }
                index += 1;
            }
            'r' if at(index + 1) == '"'
                || (at(index + 1) == '#' && "#\"".contains(at(index + 2))) =>
            {
                let hashes = (index + 1..).take_while(|place| at(*place) == '#').count();
                let end: String = std::iter::once('"')
                    .chain((0..hashes).map(|_| '#'))
                    .collect();
                let body: String = characters[index + 2 + hashes..].iter().collect();
                let length = body
                    .find(&end)
                    .map_or(body.len(), |bytes| bytes + end.len());
                let length = body.get(..length).map_or(0, |body| body.chars().count());
                index += 2 + hashes + length;
            }
            ':' if at(index + 1) == ':' => {
                tokens.push((line, "::".to_owned()));
                index += 2;
            }
            c if is_word(c) => {
                while is_word(at(index)) {
                    index += 1;
                }
                tokens.push((line, characters[start..index].iter().collect()));
            }
            c => {
                if !c.is_whitespace() {
                    tokens.push((line, c.to_string()));
                }
                index += 1;
            }
        }
        let end = index.min(characters.len());
        line += characters[start..end]
            .iter()
            .filter(|c| **c == '\n')
            .count();
    }
    tokens
}

/// The index after a text that begins at `index` with `"`.
fn text_end(characters: &[char], index: usize) -> usize {
    let mut index = index + 1;
    while index < characters.len() && characters[index] != '"' {
        index += if characters[index] == '\\' { 2 } else { 1 };
    }
    index + 1
}

/// What code names at the root of the crate, where the file's module lies `depth` below it.
fn named_at_root(tokens: &[Token], depth: usize) -> Vec<Token> {
    let word = |index: usize| tokens.get(index).map_or("", |(_, word)| word.as_str());
    let mut named = Vec::new();
    let mut braces = 0_usize;
    // How many braces were open before each inline module that is open.
    let mut inline: Vec<usize> = Vec::new();
    for index in 0..tokens.len() {
        match word(index) {
            "{" => {
                if index >= 2 && word(index - 2) == "mod" {
                    inline.push(braces);
                }
                braces += 1;
            }
            "}" => {
                braces = braces.saturating_sub(1);
                if inline.last() == Some(&braces) {
                    inline.pop();
                }
            }
            "crate" if word(index + 1) == "::" => names_after(tokens, index + 2, &mut named),
            // Only the first of a chain: the others have `::` before them.
            "super" if index == 0 || word(index - 1) != "::" => {
                let chain = (0..).take_while(|step| {
                    word(index + 2 * step) == "super" && word(index + 2 * step + 1) == "::"
                });
                let count = chain.count();
                if count == depth + inline.len() {
                    names_after(tokens, index + 2 * count, &mut named);
                }
            }
            _ => {}
        }
    }
    named
}

/// The name at `index`, or the first name of each path of the group there.
fn names_after(tokens: &[Token], index: usize, named: &mut Vec<Token>) {
    let Some((line, word)) = tokens.get(index) else {
        return;
    };
    if word != "{" {
        named.push((*line, word.clone()));
        return;
    }
    let mut depth = 0_usize;
    let mut begins = true;
    for (line, word) in &tokens[index..] {
        match word.as_str() {
            "{" => depth += 1,
            "}" => depth -= 1,
            "," if depth == 1 => begins = true,
            _ if depth == 1 && begins => {
                named.push((*line, word.clone()));
                begins = false;
            }
            _ => {}
        }
        if depth == 0 {
            return;
        }
    }
}

#[test]
fn seeded_violations_are_found() {
    for (file, text, wanted) in [
        (
            "raster/tile.rs",
            "use crate::plant::Plant;",
            "1: `raster` must not name `plant`",
        ),
        (
            "models/lodf.rs",
            "\nfn f() { crate::raster::draw() }",
            "2: `models` must not name `raster`",
        ),
        (
            "plant/mod.rs",
            "use crate::{\n  math::{Vec3, gpu},\n  gpu::Queue,\n};",
            "3: `plant` must not name `gpu`",
        ),
        (
            "gpu/bus.rs",
            "use super::super::models::Model;",
            "1: `gpu` must not name `models`",
        ),
        (
            "gpu/mod.rs",
            "use super::models::Model;",
            "1: `gpu` must not name `models`",
        ),
        (
            "gpu/bus.rs",
            "mod tests { use super::super::super::plant; }",
            "1: `gpu` must not name `plant`",
        ),
        (
            "document.rs",
            "use crate::math::Vec3;",
            "1: `document` must not name `math`",
        ),
        (
            "math/det.rs",
            "macro_rules! m { () => { $crate::scene::Scene } }",
            "1: `math` must not name `scene`",
        ),
        (
            "report/diff.rs",
            "use crate::golden::Suite;",
            "1: `report` must not name `golden`",
        ),
        // What looks like the end of a comment or text, and is none.
        (
            "math/det.rs",
            "const A: &str = \"// \\\" /*\"; const B: char = '\"'; use crate::gpu;",
            "1: `math` must not name `gpu`",
        ),
        (
            "math/det.rs",
            "const A: &str = r#\"ä\" // \"#;\nfn f<'a>(x: &'a u8) {} use crate::gpu;",
            "2: `math` must not name `gpu`",
        ),
        (
            "math/det.rs",
            "/* a /* b */ c\n */ use crate::gpu;",
            "2: `math` must not name `gpu`",
        ),
    ] {
        assert_eq!(
            check(file, text),
            [format!("src/{file}:{wanted}")],
            "{text}"
        );
    }
    assert_eq!(
        check("helpers.rs", ""),
        ["src/helpers.rs: belongs to no stage of the table"]
    );
}

#[test]
fn what_is_allowed_is_not_reported() {
    for (file, text) in [
        ("lib.rs", "pub use crate::cli;"),
        (
            "scene/parse.rs",
            "use crate::document::Document; use crate::plant::Plant;",
        ),
        (
            "scene/parse.rs",
            "use super::reader::Reader; use crate::scene::Scene;",
        ),
        ("gpu/bus.rs", "mod tests { use super::super::models; }"),
        (
            "gpu/bus.rs",
            "mod tests { mod inner {} use super::super::ledger; }",
        ),
        (
            "raster/mod.rs",
            "//! Nothing of [`crate::plant`].\n/* crate::plant */",
        ),
        (
            "raster/mod.rs",
            "const A: &str = \"crate::plant\"; const B: &str = r\"crate::plant\";",
        ),
        (
            "raster/mod.rs",
            "pub(crate) fn f() {} pub(in crate::raster) fn g() {}",
        ),
    ] {
        assert_eq!(check(file, text), [""; 0], "{text}");
    }
}
