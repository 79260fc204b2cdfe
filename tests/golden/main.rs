//! The list of goldens, by suite.
//!
//! Each is a scene `scenes/golden/SUITE/NAME.toml`; its `[golden]` table says which frames are
//! compared, how large they are, and the tolerance with its reason, where one is needed. Scenes
//! without the table are kept as digests. After a wanted change,
//! `cargo run --release -- golden bless scenes/golden --only lodf` replaces the references that
//! differ, and says by how much.

use std::path::PathBuf;

use spinney::golden::Goldens;
use spinney::models::Kind;
use spinney::scene::{ModelName, Scene};

/// A test for each scene, and the list of all.
macro_rules! goldens {
    ($($suite:ident { $($name:ident)+ })+) => {
        $(mod $suite {
            $(#[test]
            fn $name() {
                crate::goldens().assert_scene(concat!(stringify!($suite), "/", stringify!($name)));
            })+
        })+

        /// Every scene.
        const SCENES: &[&str] = &[$($(concat!(stringify!($suite), "/", stringify!($name)),)+)+];
    };
}

goldens! {
    branches { far holly_levels holly_mesh holly_skeleton pine shadow }
    cards {
        billboard billboard_depth billboard_facing crossed impostors impostors_blended
        impostors_coverage impostors_indirect impostors_relief impostors_trimmed octahedral
        octahedral_sphere sprites
    }
    digest { walk_cluster walk_slots walk_stamps yew }
    forest { hill near_far }
    full { flattened four_samples resident }
    grove { coverage hashed moments naive patches peeled sorted weighted }
    lodf {
        cluster cluster_variable device device_occlusion host literal pruned_cluster pruned_device
        slots slots_gathered slots_variable stamps stamps_variable
    }
    select { hysteresis leaf_budget_variable pixel_error }
    shadow { hill impostors tree }
    species {
        betula_lenta betula_populifolia black_tupelo ca_black_oak castanea_sativa cupressus_sempervirens
        juniperus_oxycedrus olea_europaea pistacia_lentiscus quaking_aspen quercus_cerris
        quercus_suber sorbus_aucuparia spartium_junceum taxus_baccata weeping_willow
    }
    strokes {
        apple_oil apple_watercolour spruce_watercolour ternary_far ternary_host ternary_oil
        ternary_watercolour
    }
    trunk { lodstrips lodstrips_cut mom }
    vdf { host indices }
    view { grove inside orthographic }
}

/// Tests run in the package's folder.
fn goldens() -> Goldens {
    Goldens {
        scenes: PathBuf::from("scenes/golden"),
        references: PathBuf::from("golden"),
    }
}

#[test]
fn every_scene_has_a_test_and_every_reference_a_scene() {
    assert_eq!(goldens().names().unwrap(), SCENES);
    let unused = goldens().unused().unwrap();
    let unused: Vec<String> = unused.iter().map(ToString::to_string).collect();
    assert_eq!(unused, [""; 0]);
}

#[test]
fn every_model_is_some_scenes() {
    let mut kinds: Vec<Kind> = SCENES
        .iter()
        .map(|name| {
            let scene = Scene::read(&goldens().scenes.join(format!("{name}.toml"))).unwrap();
            // Flattened leaves are drawn as any others are, and so is what is left of none.
            let name = match scene.model.name {
                ModelName::Flattened | ModelName::Bare => ModelName::Full,
                name => name,
            };
            Kind::named(name.name(), scene.model.mode.name()).unwrap()
        })
        .collect();
    kinds.sort();
    kinds.dedup();
    assert_eq!(kinds, Kind::ALL);
}
