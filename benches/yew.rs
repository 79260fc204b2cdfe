//! The tree that all cases are about: a yew of 48,160 leaves.

use std::path::Path;
use std::sync::{Arc, OnceLock};

use spinney::document::Document;
use spinney::models::{Crown, Placement};
use spinney::plant::{Plant, Species, grow};
use spinney::run::{StandingTree, World, crown};
use spinney::scene::{Scene, SceneFile};

/// Its species.
pub(crate) fn species() -> Species {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/species/taxus_baccata.toml");
    Species::read(&file).expect("a shipped species")
}

/// The plant.
pub(crate) fn plant() -> Plant {
    grow(&species(), 1).expect("a shipped species grows")
}

/// The plant with all its collapses; made once.
pub(crate) fn world() -> World {
    static CROWN: OnceLock<Arc<Crown>> = OnceLock::new();
    let crown = CROWN.get_or_init(|| Arc::new(crown(plant(), species().stop_leaves)));
    let standing = StandingTree {
        crown: 0,
        placement: Placement::IDENTITY,
    };
    World::of(vec![Arc::clone(crown)], vec![standing])
}

/// A screen full of it, under a model; from frame 0 to frame 1 detail falls by a twentieth.
pub(crate) fn scene(model: &str, mode: &str) -> Scene {
    let text = format!(
        r#"
schema = "spinney.scene/1"
name = "yew"
size = [1024, 768]
frames = 2
[[tree]]
species = "taxus_baccata.toml"
[camera]
vertical_field_of_view = 40.0
path = [
    {{ frame = 0, eye = [0.25, 5.6, 16.0], target = [0.25, 5.6, 0.0] }},
    {{ frame = 1, eye = [0.25, 5.6, 18.0], target = [0.25, 5.6, 0.0] }},
]
[light]
direction = [0.4, 0.8, 0.45]
[model]
name = "{model}"
mode = "{mode}"
d_min = 0.0
d_max = 40.0
"#
    );
    let file = "yew.toml".to_owned();
    let read = SceneFile::parse(Document { file, text });
    read.expect("a sound scene").scene
}
