//! Crowns whose collapses add vertices.

use std::sync::Arc;

use spinney::gpu::Device;
use spinney::models::{
    Crown, Environment, Kind, LeafFormat, ModelOptions, Records, State, Vertices,
};
use spinney::plant::{Foliage, LeafGroup, NO_BRANCH, Plant};
use spinney::scene::Simplifier;
use spinney::simplify::{CollapseSequence, PruningOptions, prune_leaves};

use crate::support::{OPTIONS, Stage, StageExt as _, birches, descriptor, pruned, random_crown};

const COMPACT: ModelOptions = ModelOptions {
    format: LeafFormat {
        records: Records::Compact,
        vertices: Vertices::Float,
    },
    ..OPTIONS
};

/// A plant whose original leaves are what shows of a crown.
fn shown(crown: &Crown, state: &State) -> Arc<Crown> {
    let visible = state.visible(crown.clusters());
    let sequence = crown.sequence();
    let mut first = 0;
    let groups = crown.plant().foliage().quad_groups().map(|(group, _)| {
        let own = first..first + 4 * group.leaf_count();
        first = own.end;
        let corners = visible
            .iter()
            .map(|&leaf| sequence.corners()[leaf as usize]);
        let of_group = corners.filter(|corners| {
            own.contains(&(4 * sequence.original_of_vertex(corners[0]) as usize))
        });
        let positions: Vec<_> = of_group
            .flatten()
            .map(|vertex| crown.vertices()[vertex as usize])
            .collect();
        LeafGroup {
            owners: vec![NO_BRANCH; positions.len() / 4],
            positions,
            ..group.clone()
        }
    });
    let foliage = Foliage {
        groups: groups.collect(),
    };
    let leaves = u32::try_from(foliage.quad_count()).expect("few");
    let plant = Plant::new("shown", None, None, foliage).expect("sound parts");
    let corners = (0..leaves).map(|leaf| [0, 1, 2, 3].map(|role| 4 * leaf + role));
    let sequence = CollapseSequence::new(leaves, corners.collect(), Vec::new());
    Arc::new(Crown::new(Arc::new(plant), sequence.expect("no collapse")))
}

/// Grown leaves look as if the plant had them from the first, each with its own group's material.
#[test]
fn leaves_that_grew_look_like_leaves_of_that_size() {
    for seed in 0..6 {
        let crown = pruned(&random_crown(seed, 40, 6));
        for collapses in [1, 17, crown.sequence().collapse_count()] {
            let state = State::Uniform { collapses };
            for kind in [Kind::LodfCluster, Kind::LodfStamps, Kind::LodfDevice] {
                let found = Stage::at(kind, COMPACT, &crown, &state, 64).draw();
                let plain = shown(&crown, &state);
                let wanted = Stage::at(Kind::Full, OPTIONS, &plain, &State::FINEST, 64).draw();
                assert_eq!(found.digest(), wanted.digest(), "{kind:?}, {collapses}");
            }
        }
    }
}

/// Bytes of one buffer, or 0 if there is none of this name.
fn bytes(stage: &Stage, label: &str) -> u64 {
    let list = stage.device.resident_by_label().into_iter();
    list.filter(|(name, _)| *name == label)
        .map(|(_, bytes)| bytes)
        .sum()
}

/// What pruning costs more than leaf collapse: 48 bytes a collapse, and with compact records 4 for the
/// number; what has no levels does not pay.
#[test]
fn a_collapse_adds_four_vertices_and_no_more() {
    let crown = random_crown(3, 50, 7);
    let pruned = pruned(&crown);
    for (kind, options, vertices, numbers) in [
        (Kind::Full, OPTIONS, 0, 0),
        (Kind::LodfCluster, OPTIONS, 48 * 43, 0),
        (Kind::LodfStamps, COMPACT, 48 * 43, 4 * 43),
        (Kind::VdfIndices, OPTIONS, 48 * 43, 0),
    ] {
        let [with, without] =
            [&pruned, &crown].map(|crown| Stage::at(kind, options, crown, &State::FINEST, 1));
        let more = |label| bytes(&with, label) - bytes(&without, label);
        assert_eq!(more("leaf vertices"), vertices, "{kind:?}");
        assert_eq!(more("leaf numbers"), numbers, "{kind:?}");
        let storage = |crown| kind.model(crown, options).storage();
        let [with, without] = [&pruned, &crown].map(storage);
        assert_eq!(with.shared_bytes - without.shared_bytes, vertices + numbers);
        assert_eq!(with.host_bytes, without.host_bytes);
        assert_eq!(with.instance_bytes, without.instance_bytes);
    }
    // Collapses that add vertices are not expanded on the device: their records are sent.
    let [with, without] = [&pruned, &crown]
        .map(|crown| Stage::at(Kind::LodfDevice, COMPACT, crown, &State::FINEST, 1));
    assert_eq!(
        bytes(&with, "collapse operands") + bytes(&with, "collapse masks"),
        0
    );
    assert_eq!(bytes(&without, "collapse operands"), 8 * 43);
    assert_eq!(bytes(&with, "windowed records"), 16 * 93);
}

/// New leaves with vertices of their own count among those that `u16` must number.
#[test]
fn compact_records_number_what_collapses_add() {
    let upload = |leaves: u32| {
        let plant = random_crown(1, 2 * leaves, 2);
        let sequence = prune_leaves(plant.plant().foliage(), &PruningOptions::to(2));
        let crown = Arc::new(Crown::new(Arc::clone(plant.plant()), sequence));
        let mut device = Device::new(descriptor());
        let environment = Environment::new(&mut device, 1).expect("memory suffices");
        let model = Kind::LodfCluster.model(&crown, COMPACT);
        model.upload(&mut device, &environment).map(|_| ())
    };
    assert_eq!(upload(8_192), Ok(()));
    let refused = upload(8_193).expect_err("one too many").to_string();
    assert!(
        refused.starts_with("a cluster of 16385 leaves"),
        "{refused}"
    );
}

#[test]
fn a_world_is_simplified_anew_to_as_many_leaves() {
    let world = birches();
    let other = world.simplified_by(Simplifier::Pruning);
    assert_eq!(other.trees, world.trees);
    for (ours, theirs) in world.crowns.iter().zip(&other.crowns) {
        assert!(Arc::ptr_eq(ours.plant(), theirs.plant()));
        assert_eq!(ours.original_vertices(), theirs.original_vertices());
        assert_eq!(ours.sequence().root_count(), theirs.sequence().root_count());
        let added = theirs.sequence().added_vertices().len();
        assert_eq!(added, 4 * theirs.sequence().collapse_count() as usize);
    }
}
