//! Plant files of other programs as text, and Arbaro's species.

use spinney::plant::import::{Format, ImportOptions, Reading, import_bytes};
use spinney::plant::{ArbaroSpecies, Species};

/// OBJ files.
pub fn obj(bytes: &[u8]) {
    import("fuzz.obj", Format::Obj, bytes);
}

/// OPF files.
pub fn opf(bytes: &[u8]) {
    import("fuzz.opf", Format::Opf, bytes);
}

fn import(file: &str, format: Format, bytes: &[u8]) {
    for foliage in [vec![], vec!["leaf".to_owned()]] {
        let options = ImportOptions {
            reading: Reading {
                format: Some(format),
                ..Reading::default()
            },
            foliage,
            ..ImportOptions::default()
        };
        match import_bytes(file, bytes, None, &options) {
            Ok(imported) => {
                for entry in &imported.report.entries {
                    _ = entry.to_string();
                }
                crate::gltf::returns(&imported.plant);
            }
            Err(error) => _ = error.to_string(),
        }
    }
}

/// Arbaro's files: what is read is a species that is written, read as the same, and grows.
pub fn arbaro(bytes: &[u8]) {
    let Some(document) = crate::document("fuzz.xml", bytes) else {
        return;
    };
    let found = match ArbaroSpecies::parse(&document) {
        Ok(found) => found,
        Err(error) => {
            _ = error.to_string();
            return;
        }
    };
    for entry in &found.report.entries {
        _ = entry.to_string();
    }
    let written = found.species.to_toml();
    let document = crate::document("written.toml", written.as_bytes()).expect("a text");
    match Species::parse(&document) {
        Ok(again) => assert_eq!(again, found.species, "{written}"),
        Err(error) => panic!("{error}\n{written}"),
    }
    crate::species::species(written.as_bytes());
}
