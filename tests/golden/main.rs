//! The list of goldens, by suite.
//!
//! Each is a scene `scenes/golden/SUITE/NAME.toml`; its `[golden]` table says which frames are
//! compared, how large they are, and the tolerance with its reason, where one is needed. After a
//! wanted change, `BLESS=1 cargo test --test golden lodf` replaces the references of what it draws,
//! and fails, so that nothing is blessed unseen.

mod harness;
mod picture;

/// A test for each scene, and the list of all.
macro_rules! goldens {
    ($($suite:ident { $($name:ident)+ })+) => {
        $(mod $suite {
            $(#[test]
            fn $name() {
                crate::harness::check_scene(concat!(stringify!($suite), "/", stringify!($name)));
            })+
        })+

        /// Every scene that is compared as pictures.
        const SCENES: &[&str] = &[$($(concat!(stringify!($suite), "/", stringify!($name)),)+)+];
    };
}

goldens! {
    full { resident four_samples }
    lodf {
        cluster host literal slots stamps
        cluster_variable slots_gathered slots_variable stamps_variable
    }
    species {
        betula_lenta betula_populifolia black_tupelo ca_black_oak cupressus_sempervirens
        juniperus_oxycedrus olea_europaea pistacia_lentiscus quaking_aspen quercus_cerris
        quercus_suber sorbus_aucuparia spartium_junceum taxus_baccata weeping_willow
    }
    vdf { host indices }
    view { grove inside orthographic }
}

#[test]
fn digests_are_those_on_file() {
    harness::check_digests();
}

#[test]
fn every_reference_is_drawn_and_every_scene_tested() {
    harness::check_references(SCENES);
}
