//! Files of wood: the cylinder tables, treefiles and tree graphs.

use spinney::plant::import::{Format, ImportOptions, Reading, import_bytes};

/// The formats that a first byte of 0 to 4 tells.
const FORMATS: [Format; 5] = [
    Format::TreeQsm,
    Format::SimpleForest,
    Format::Archi,
    Format::Treefile,
    Format::Mtg,
];

/// Leaves up to which a plant is also written: a few digits ask for millions.
const FEW_LEAVES: usize = 1000;

/// Files of wood: their format is what a first byte of 0 to 4 tells, which is taken off, or else what their
/// content says. What is read is sound, and comes back when it is written.
pub fn wood(bytes: &[u8]) {
    let told = bytes
        .first()
        .and_then(|&byte| FORMATS.get(usize::from(byte)));
    let options = ImportOptions {
        reading: Reading {
            format: told.copied(),
            ..Reading::default()
        },
        ..ImportOptions::default()
    };
    let bytes = &bytes[usize::from(told.is_some())..];
    match import_bytes("fuzz.mtg", bytes, None, &options) {
        Ok(imported) => {
            _ = imported.report.to_string();
            let plant = &imported.plant;
            if let Some(skeleton) = plant.skeleton() {
                assert!(skeleton.roots().count() > 0, "no branch is a root");
                for branch in &skeleton.branches {
                    assert!(!skeleton.nodes_of(branch).is_empty());
                }
            }
            if plant.foliage().leaf_count() <= FEW_LEAVES {
                crate::gltf::returns(plant);
            }
        }
        Err(error) => _ = error.to_string(),
    }
}
