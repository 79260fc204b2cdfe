//! Which format a file has: as told, or by its content, or by its ending.

use crate::document::choices;

use super::{ImportError, ImportReport, ReportKind, Source};

choices! {
    /// A format that trees are kept in.
    #[derive(serde::Serialize)]
    #[serde(rename_all = "kebab-case")]
    #[non_exhaustive]
    Format {
        /// glTF 2.0, as text or binary: meshes.
        Gltf = "gltf",
        /// Wavefront OBJ: meshes.
        Obj = "obj",
        /// The cylinder table of `TreeQSM`: wood of a scanned tree.
        TreeQsm = "tree-qsm",
        /// The cylinder table of `SimpleForest`: wood of a scanned tree.
        SimpleForest = "simple-forest",
        /// A cylinder table as aRchi keeps it: wood of a scanned tree.
        Archi = "archi",
        /// A treefile of raycloudtools: wood of scanned trees.
        Treefile = "treefile",
        /// A multi-scale tree graph: wood, and leaves by number, area or size.
        Mtg = "mtg",
        /// AMAP's Open Plant Format: wood and leaves by reference meshes.
        Opf = "opf",
        /// A scene of Open Plant Format files.
        Ops = "ops",
    }
}

impl Format {
    /// As its users write it.
    #[must_use]
    pub fn title(self) -> &'static str {
        match self {
            Self::Gltf => "glTF",
            Self::Obj => "OBJ",
            Self::TreeQsm => "TreeQSM",
            Self::SimpleForest => "SimpleForest",
            Self::Archi => "aRchi",
            Self::Treefile => "raycloudtools",
            Self::Mtg => "MTG",
            Self::Opf => "OPF",
            Self::Ops => "OPS",
        }
    }

    /// The ending of a copy of a file.
    pub(super) fn ending(self, bytes: &[u8]) -> &'static str {
        match self {
            Self::Gltf if bytes.starts_with(b"glTF") => "glb",
            Self::Gltf => "gltf",
            Self::Obj => "obj",
            Self::TreeQsm | Self::Treefile => "txt",
            Self::SimpleForest | Self::Archi => "csv",
            Self::Mtg => "mtg",
            Self::Opf => "opf",
            Self::Ops => "ops",
        }
    }

    /// The format of a file: `told`, or what its content says, or its ending.
    pub(super) fn of(
        source: &Source<'_>,
        told: Option<Self>,
        report: &mut ImportReport,
    ) -> Result<Self, ImportError> {
        if let Some(told) = told {
            return Ok(told);
        }
        if let Some(format) = Self::by_content(source.bytes()) {
            return Ok(format);
        }
        let ending = source.ending();
        let Some(format) = Self::by_ending(&ending) else {
            let names = Self::NAMES.join(", ");
            let message = format!(
                "neither its content nor the ending {ending:?} says what it is; tell its format, one of {names}"
            );
            return Err(ImportError::Format {
                file: source.file().to_owned(),
                message,
            });
        };
        let message = format!("the format {}, by the file's ending", format.title());
        report.add(ReportKind::Guessed, 1, "line 1", message);
        Ok(format)
    }

    /// What the first bytes can only be.
    fn by_content(bytes: &[u8]) -> Option<Self> {
        let head = &bytes[..bytes.len().min(HEAD_BYTES)];
        let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
        if head.starts_with(b"glTF") || head.trim_ascii_start().starts_with(b"{") {
            return Some(Self::Gltf);
        }
        // Latin-1 occurs; what is looked for is ASCII.
        let text = String::from_utf8_lossy(head);
        let mut lines = text.lines().map(str::trim);
        let first = lines.clone().find(|line| !line.is_empty())?;
        if text.contains("<opf") {
            return Some(Self::Opf);
        }
        let is_code = |line: &str| line.starts_with("CODE:") || line.starts_with("CODE :");
        if is_code(first) {
            return Some(Self::Mtg);
        }
        let names = |line: &str| -> Vec<String> {
            let names = line.split([',', ';', '\t']);
            names
                .map(|name| name.trim().trim_matches('"').to_lowercase())
                .collect()
        };
        let has = |wanted: &[&str]| {
            let found = names(first);
            wanted
                .iter()
                .all(|name| found.iter().any(|found| found == name))
        };
        if has(&["cyl_id", "parent_id"]) {
            return Some(Self::Archi);
        }
        if has(&["id", "parentid", "startx"]) {
            return Some(Self::SimpleForest);
        }
        let is_fields = |line: &str| {
            let names = line.trim_start_matches('#').replace(' ', "");
            names.contains("x,y,z,radius") && names.contains("parent_id")
        };
        if lines.clone().take(HEAD_LINES).any(is_fields) {
            return Some(Self::Treefile);
        }
        if first.starts_with("radius") && first.contains("parent") && first.contains("extension") {
            return Some(Self::TreeQsm);
        }
        let keyword = |line: &str| line.split_whitespace().next().map(str::to_owned);
        let is_mesh = |word: &str| matches!(word, "v" | "vt" | "vn" | "f" | "mtllib" | "usemtl");
        if lines
            .by_ref()
            .take(HEAD_LINES)
            .filter_map(keyword)
            .any(|word| is_mesh(&word))
        {
            return Some(Self::Obj);
        }
        let numbers = first.split_whitespace().map(str::parse::<f64>);
        let numbers: Option<Vec<f64>> = numbers.map(Result::ok).collect();
        numbers
            .is_some_and(|numbers| matches!(numbers.len(), 15 | 17))
            .then_some(Self::TreeQsm)
    }

    fn by_ending(ending: &str) -> Option<Self> {
        Some(match ending {
            "glb" | "gltf" => Self::Gltf,
            "obj" => Self::Obj,
            "mtg" => Self::Mtg,
            "opf" => Self::Opf,
            "ops" => Self::Ops,
            _ => return None,
        })
    }
}

/// How many bytes and lines are looked at: what says the format stands at the top, below comments.
const HEAD_BYTES: usize = 65_536;
const HEAD_LINES: usize = 1000;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_go_both_ways() {
        for &format in Format::ALL {
            assert_eq!(Format::from_name(format.name()), Some(format));
        }
        assert_eq!(Format::from_name("ply"), None);
    }

    #[test]
    fn content_says_the_format() {
        for (text, format) in [
            ("glTF....", Some(Format::Gltf)),
            ("\u{feff} {\"asset\":{}}", Some(Format::Gltf)),
            ("# a tree\n\no oak\nv 0 0 0\n", Some(Format::Obj)),
            (
                "radius (m)\tlength (m)\tstart_point\tparent\textension\n",
                Some(Format::TreeQsm),
            ),
            ("1 2 3 4 5 6 7 8 0 10 0 12 1 0 15\n", Some(Format::TreeQsm)),
            ("1 2 3 4 5 6 7 8 9 10 11 12 13 14\n", None),
            ("ID, parentID, startX, startY\n", Some(Format::SimpleForest)),
            ("type; ID; parentID; startX\n", Some(Format::SimpleForest)),
            (
                "\"startX\",\"radius_cyl\",\"cyl_ID\",\"parent_ID\"\n",
                Some(Format::Archi),
            ),
            (
                "# one\n# x,y,z,radius,parent_id\nx,y,z,radius,parent_id\n",
                Some(Format::Treefile),
            ),
            ("CODE:\tFORM-A\n", Some(Format::Mtg)),
            (
                "<?xml version=\"1.0\"?>\n<opf version=\"2.0\">",
                Some(Format::Opf),
            ),
            ("", None),
            ("hello, world\n", None),
        ] {
            assert_eq!(Format::by_content(text.as_bytes()), format, "{text:?}");
        }
    }

    #[test]
    fn a_file_that_says_nothing_is_refused_with_the_names() {
        let source = Source::new("a/b.xyz", b"1 2 3\n", None).unwrap();
        let error = Format::of(&source, None, &mut ImportReport::default()).unwrap_err();
        let said = error.to_string();
        assert!(
            said.starts_with("a/b.xyz: neither its content nor the ending \"xyz\""),
            "{said}"
        );
        assert!(
            said.ends_with("gltf, obj, tree-qsm, simple-forest, archi, treefile, mtg, opf, ops")
        );
        let mut report = ImportReport::default();
        let source = Source::new("a/b.OPS", b"T 0 0\n", None).unwrap();
        assert_eq!(Format::of(&source, None, &mut report), Ok(Format::Ops));
        assert_eq!(report.entries.len(), 1);
    }
}
