//! What is kept as digests, one line each: `golden/digests.txt`.
//!
//! ```text
//! plant/SPECIES           the plant of seed 1
//! collapses/SPECIES       its collapses, of some species
//! model/KIND/SPECIES      the bytes that a model of it keeps on the host
//! digest/SCENE-FRAME      a frame of a scene without a [golden] table: its picture, its ledger
//! ```

use std::sync::Arc;

use spinney::math::{Digest, Digester};
use spinney::models::{Crown, Extraction, Gather, Kind, ModelOptions};
use spinney::plant::{Species, grow};

use crate::scenes::{GoldenScene, names, path};
use crate::table::table;

/// Species whose collapses are kept, and a scene that has them.
const COLLAPSED: [[&str; 2]; 2] = [
    ["betula_populifolia", "lodf/stamps"],
    [MODELLED, "lodf/stamps_variable"],
];

/// The species whose models are kept.
const MODELLED: &str = "pistacia_lentiscus";

/// Tells a line's name and digests to `tell`, in the order of the file.
pub(crate) fn digests(tell: &mut dyn FnMut(&str, &[Digest])) {
    for name in species() {
        let file = path("scenes/species").join(format!("{name}.toml"));
        let species = Species::read(&file).unwrap_or_else(|error| panic!("{error}"));
        let plant = grow(&species, 1).unwrap_or_else(|error| panic!("{name}: {error}"));
        tell(&format!("plant/{name}"), &[plant.digest()]);
    }
    for [name, scene] in COLLAPSED {
        let world = GoldenScene::read(scene).world();
        let crown = &world.crowns[0];
        tell(&format!("collapses/{name}"), &[crown.sequence().digest()]);
        if name == MODELLED {
            models(name, crown, tell);
        }
    }
    let scenes = names().into_iter().map(|name| GoldenScene::read(&name));
    for scene in scenes.filter(|scene| scene.golden().is_none()) {
        frames(&scene, tell);
    }
}

/// Tells the frames that a scene keeps: the picture's digest, and BLAKE3 over the ledger's table,
/// which holds a digest of the transfers.
pub(crate) fn frames(scene: &GoldenScene, tell: &mut dyn FnMut(&str, &[Digest])) {
    for drawn in scene.draw() {
        let table = table(&drawn.frame, &drawn.context);
        let ledger = Digester::plain().raw(table.as_bytes()).finish();
        tell(&drawn.name, &[drawn.frame.image_digest, ledger]);
    }
}

fn models(name: &str, crown: &Arc<Crown>, tell: &mut dyn FnMut(&str, &[Digest])) {
    let options = ModelOptions {
        extraction: Extraction::Batched,
        gather: Gather::Single,
    };
    for kind in Kind::ALL {
        let bytes = kind.model(crown, options).host_bytes();
        let digest = Digester::plain().raw(&bytes).finish();
        tell(&format!("model/{}/{name}", kind.label()), &[digest]);
    }
}

/// The names of all species, in order.
fn species() -> Vec<String> {
    let folder = path("scenes/species");
    let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{error}"));
    let mut names: Vec<String> = entries
        .filter_map(|entry| {
            let name = entry.ok()?.file_name().into_string().ok()?;
            name.strip_suffix(".toml").map(str::to_owned)
        })
        .collect();
    names.sort();
    names
}
