//! Bytes over the bus equal their [closed forms](crate::closed_form), cause by cause and transfer by
//! transfer.

use std::sync::Arc;

use proptest::prelude::{ProptestConfig, any, prop_assert, prop_assert_eq};
use proptest::test_runner::TestCaseError;
use spinney::gpu::{
    Command, Device, DeviceDescriptor, Ledger, Link, Load, RenderPass, Stream, TargetDescriptor,
    nanoseconds,
};
use spinney::math::{Vec2, Vec3, Vec4, index_usize};
use spinney::models::{
    Crown, Environment, Gather, Kind, LeafFormat, ModelOptions, Placement, State, Trunk, TrunkKind,
    TrunkLevel,
};
use spinney::plant::{Foliage, Material, Mesh, Plant, Texture};
use spinney::raster::Samples;

use crate::closed_form::{Expected, Forest, Sent, by_cause, transfers};
use crate::laws::check_conservation;
use crate::support::{
    DeviceModel as _, OPTIONS, Stage, StageExt as _, descriptor, pruned, random_crown,
    random_state, with_faces,
};

const REGIONS: ModelOptions = ModelOptions {
    gather: Gather::Regions,
    ..OPTIONS
};

/// Records of 8 bytes.
const COMPACT: ModelOptions = ModelOptions {
    format: LeafFormat::ALL[1],
    ..OPTIONS
};

/// Records and vertices of 8 bytes.
const SMALL: ModelOptions = ModelOptions {
    format: LeafFormat::ALL[3],
    ..REGIONS
};

/// Held against the ledger: every transfer of a stream, its sums, and the shares of its causes.
fn check_stream(ledger: &Ledger, stream: Stream, wanted: &[Sent]) -> Result<(), TestCaseError> {
    let mut sorted = wanted.to_vec();
    sorted.sort_unstable();
    prop_assert_eq!(transfers(ledger, stream), sorted);
    let sum = ledger.stream(stream);
    prop_assert_eq!(sum.transfers, wanted.len() as u64);
    let bytes: u64 = wanted.iter().map(|sent| sent.3).sum();
    prop_assert_eq!(sum.payload_bytes, bytes);
    let listed = ledger.transfers.iter().filter(|t| t.stream == stream);
    let (wire, ticks) = listed.fold((0, 0), |(wire, ticks), t| {
        (wire + t.wire_bytes, ticks + t.ticks)
    });
    prop_assert_eq!((sum.wire_bytes, sum.ticks), (wire, ticks));
    for (cause, share) in by_cause(wanted) {
        prop_assert_eq!(ledger.by_cause.get(cause), Some(&share), "{}", cause);
    }
    Ok(())
}

/// Only what these streams sent is in the ledger.
fn check_nothing_else(ledger: &Ledger, wanted: &[&[Sent]]) -> Result<(), TestCaseError> {
    let all = wanted.iter().copied().flatten();
    prop_assert_eq!(&ledger.by_cause, &by_cause(all.clone()));
    let by_buffer: u64 = ledger.by_buffer.values().map(|s| s.payload_bytes).sum();
    prop_assert_eq!(by_buffer, all.map(|sent| sent.3).sum::<u64>());
    prop_assert_eq!(ledger.readback.transfers, 0);
    Ok(())
}

/// The view, the placement, and what the foliage looks like: one disc of 8 × 8 texels on both
/// groups.
fn scenery() -> Vec<Sent> {
    let mut sent = vec![
        ("view", None, "view", 100),
        ("placement", Some(0), "placements", 32),
        ("materials", None, "leaf materials", 2 * 64),
    ];
    for side in [8, 4, 2, 1] {
        sent.push(("texture", None, "leaf texture", 4 * side * side));
    }
    sent
}

/// Uploads, changes and draws of one walk.
fn check_walk(
    kind: Kind,
    options: ModelOptions,
    crown: &Arc<Crown>,
    states: &[State],
) -> Result<(), TestCaseError> {
    let forest = Forest::of(crown);
    let mut expected = Expected::at(&forest, kind, options.format, &states[0]);
    let mut stage = Stage::at(kind, options, crown, &states[0], 8);
    let ledger = stage.device.take_ledger();
    let initial = [scenery(), expected.initial()].concat();
    check_stream(&ledger, Stream::Upload, &initial)?;
    check_nothing_else(&ledger, &[&initial])?;
    prop_assert_eq!(ledger.command_bytes, expected.initial_command_bytes());
    for state in &states[1..] {
        stage.commit(state);
        let ledger = stage.device.take_ledger();
        let sent = expected.commit(state);
        match options.gather {
            Gather::Single => {
                check_stream(&ledger, Stream::Upload, &sent)?;
                check_nothing_else(&ledger, &[&sent])?;
                prop_assert!(ledger.transfers.iter().all(|t| t.ranges == 1));
                prop_assert_eq!(ledger.command_bytes, 0);
            }
            Gather::Regions => check_gathered(&ledger, &sent)?,
        }
        stage.draw();
        let ledger = stage.device.take_ledger();
        let fetched = expected.fetched();
        check_stream(&ledger, Stream::Fetch, &fetched)?;
        check_nothing_else(&ledger, &[&fetched])?;
        let (draws, vertices) = expected.draws_and_vertices();
        prop_assert_eq!((ledger.draws, ledger.vertices), (draws, vertices));
        prop_assert_eq!(ledger.primitives, vertices / 4);
        prop_assert_eq!(ledger.command_bytes, expected.command_bytes(1));
    }
    Ok(())
}

/// The same ranges in one transfer, and a region of 24 bytes of commands each.
fn check_gathered(ledger: &Ledger, sent: &[Sent]) -> Result<(), TestCaseError> {
    let bytes: u64 = sent.iter().map(|sent| sent.3).sum();
    let ranges = sent.len() as u64;
    let found: Vec<_> = ledger
        .transfers
        .iter()
        .map(|t| (t.stream, t.ranges, t.payload_bytes))
        .collect();
    let wanted = (!sent.is_empty()).then_some((Stream::Upload, ranges, bytes));
    prop_assert_eq!(found, Vec::from_iter(wanted));
    prop_assert_eq!(ledger.command_bytes, 24 * ranges);
    let payload = |shares: &std::collections::BTreeMap<&'static str, spinney::gpu::Share>| {
        let list = shares
            .iter()
            .map(|(&cause, share)| (cause, share.payload_bytes));
        list.collect::<Vec<_>>()
    };
    prop_assert_eq!(payload(&ledger.by_cause), payload(&by_cause(sent)));
    let transfers: u64 = ledger.by_cause.values().map(|share| share.transfers).sum();
    prop_assert_eq!(transfers, u64::from(!sent.is_empty()));
    Ok(())
}

macro_rules! closed_forms {
    ($($name:ident: $kind:expr, $options:expr;)*) => {
        crate::support::properties! {
            #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]
            $(
                #[test]
                fn $name(
                    seed in any::<u64>(),
                    leaves in 2_u32..40,
                    roots in 1_u32..8,
                    choices in proptest::collection::vec(any::<u64>(), 2..7),
                ) {
                    let crown = random_crown(seed, leaves, roots);
                    let states: Vec<State> =
                        choices.iter().map(|&choice| random_state(&crown, choice)).collect();
                    check_walk($kind, $options, &crown, &states)?;
                }
            )*
        }
    };
}

closed_forms! {
    full: Kind::Full, OPTIONS;
    vdf_host: Kind::VdfHost, OPTIONS;
    vdf_indices: Kind::VdfIndices, OPTIONS;
    lodf_host: Kind::LodfHost, OPTIONS;
    lodf_cluster: Kind::LodfCluster, OPTIONS;
    lodf_slots: Kind::LodfSlots, OPTIONS;
    lodf_slots_gathered: Kind::LodfSlots, REGIONS;
    lodf_stamps: Kind::LodfStamps, OPTIONS;
    lodf_stamps_gathered: Kind::LodfStamps, REGIONS;
    full_small: Kind::Full, SMALL;
    vdf_host_compact: Kind::VdfHost, COMPACT;
    vdf_indices_compact: Kind::VdfIndices, COMPACT;
    lodf_host_small: Kind::LodfHost, SMALL;
    lodf_cluster_compact: Kind::LodfCluster, COMPACT;
    lodf_slots_compact: Kind::LodfSlots, COMPACT;
    lodf_slots_small_gathered: Kind::LodfSlots, SMALL;
    lodf_stamps_compact: Kind::LodfStamps, COMPACT;
    lodf_stamps_small_gathered: Kind::LodfStamps, SMALL;
    lodf_device: Kind::LodfDevice, OPTIONS;
    lodf_device_compact: Kind::LodfDevice, COMPACT;
    lodf_device_small_gathered: Kind::LodfDevice, SMALL;
}

/// Every step of the sequence by itself, there and back: one cluster, one or two slots, one counter.
#[test]
fn single_steps_cost_what_the_table_says() {
    let crown = random_crown(11, 30, 4);
    let all = crown.sequence().collapse_count();
    let there_and_back = (0..=all).chain((0..all).rev());
    let states: Vec<State> = there_and_back
        .map(|collapses| State::Uniform { collapses })
        .collect();
    for kind in Kind::SOUND {
        check_walk(kind, OPTIONS, &crown, &states).expect("single steps");
    }
    let mut stage = Stage::at(Kind::LodfSlots, OPTIONS, &crown, &State::FINEST, 1);
    let mut slots = Vec::new();
    for state in &states[1..] {
        stage.device.take_ledger();
        stage.commit(state);
        let ledger = stage.device.take_ledger();
        assert_eq!(ledger.by_cause["draw-count"].payload_bytes, 4);
        slots.push(ledger.by_cause["slot"].payload_bytes);
    }
    assert!(slots.iter().all(|bytes| [16, 32].contains(bytes)));
    assert!(slots.contains(&16) && slots.contains(&32), "{slots:?}");
}

crate::support::properties! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn recordings_rebuild_buffers_and_textures(
        seed in any::<u64>(),
        leaves in 2_u32..30,
        roots in 1_u32..6,
        choices in proptest::collection::vec(any::<u64>(), 1..6),
    ) {
        let crown = random_crown(seed, leaves, roots);
        for kind in Kind::LEAVES {
            let start = random_state(&crown, seed);
            let options = if seed & 1 == 0 { OPTIONS } else { REGIONS };
            let mut stage = Stage::at(kind, options, &crown, &start, 8);
            for &choice in &choices {
                stage.commit(&random_state(&crown, choice));
                stage.draw();
            }
            let payload = stage.device.take_ledger().upload.payload_bytes;
            check_conservation(&stage.device, payload)?;
        }
    }

    #[test]
    fn wire_bytes_and_times_follow_the_rules_of_the_link(payload in 0_u64..1 << 40) {
        for link in Link::ALL {
            prop_assert_eq!(link.wire_bytes(payload), wire_bytes(link.name(), payload));
            let (down, up) = ticks_per_byte(link.name());
            let ticks = |per_byte| 1000 * 4096 + per_byte * wire_bytes(link.name(), payload);
            prop_assert_eq!((link.ticks_down(payload), link.ticks_up(payload)), (ticks(down), ticks(up)));
            prop_assert_eq!(nanoseconds(ticks(down)), ticks(down).div_ceil(4096));
        }
    }
}

/// AGP pads to 8 bytes; PCI Express pads to 4 and adds 24 to every packet of at most 256.
fn wire_bytes(link: &str, payload: u64) -> u64 {
    if link.starts_with("agp") {
        payload.div_ceil(8) * 8
    } else {
        payload.div_ceil(4) * 4 + 24 * payload.div_ceil(256)
    }
}

/// Ticks of 1/4096 ns a byte on the wire, to the device and from it, out of the standards' rates.
fn ticks_per_byte(link: &str) -> (u64, u64) {
    // 32 bits at 200/3 MHz, one to eight times; back at 400/3 MB/s.
    let agp = |times: u64| (4096 * 1000 * 3 / (4 * 200 * times), 4096 * 1000 * 3 / 400);
    // Sixteen lanes of so many tenths of gigabits a second, of which 8/10 or 128/130 are bytes.
    let pcie = |tenths: u64, (bits, of): (u64, u64)| {
        let ticks = 4096 * 8 * 10 * of / (16 * tenths * bits);
        (ticks, ticks)
    };
    match link {
        "agp1x" => agp(1),
        "agp2x" => agp(2),
        "agp4x" => agp(4),
        "agp8x" => agp(8),
        "pcie1x16" => pcie(25, (8, 10)),
        "pcie2x16" => pcie(50, (8, 10)),
        "pcie3x16" => pcie(80, (128, 130)),
        "pcie4x16" => pcie(160, (128, 130)),
        "pcie5x16" => pcie(320, (128, 130)),
        _ => unreachable!("{link} has no rate here"),
    }
}

/// The device makes of the collapses what would have been sent as records: corners counted in the
/// cluster, birth there, and the cluster.
#[test]
fn expanded_records_are_those_of_the_clusters() {
    for (seed, leaves, roots) in [(1, 2, 2), (2, 40, 3), (3, 90, 30), (4, 300, 2)] {
        let crown = random_crown(seed, leaves, roots);
        let stage = Stage::at(Kind::LodfDevice, COMPACT, &crown, &State::FINEST, 1);
        let named = |wanted: &str| {
            let mut buffers = stage.device.buffers();
            let (id, _) = buffers
                .find(|(_, label)| *label == wanted)
                .expect("it lives");
            let bytes = stage.device.inspect_buffer(id).expect("it lives");
            let words = bytes.as_chunks::<4>().0.iter();
            words
                .map(|four| u32::from_le_bytes(*four))
                .collect::<Vec<_>>()
        };
        let (records, numbers) = (named("windowed records"), named("leaf numbers"));
        let mut found = records.as_chunks::<4>().0.iter();
        let mut first = 0;
        for (number, cluster) in (0..).zip(&crown.clusters().clusters) {
            for record in &cluster.records {
                let [low, high, birth, of] = *found.next().expect("a record each");
                let local = [low & 0xffff, low >> 16, high & 0xffff, high >> 16];
                let corners =
                    local.map(|local| 4 * numbers[first + local as usize / 4] + local % 4);
                assert_eq!(corners, crown.sequence().corners()[record.leaf as usize]);
                assert_eq!((birth, of), (record.birth, number));
            }
            first += cluster.ops.len() + 1;
        }
        assert!(found.next().is_none(), "and no more");
    }
}

/// What `u16` cannot number is refused, not cut.
#[test]
fn clusters_too_large_for_compact_records_are_refused() {
    let model = |leaves: u32| Kind::LodfCluster.model(&random_crown(1, 2 * leaves, 2), COMPACT);
    let upload = |leaves| {
        let mut device = Device::new(descriptor());
        let environment = Environment::new(&mut device, 1).expect("memory suffices");
        model(leaves).upload(&mut device, &environment).map(|_| ())
    };
    assert_eq!(upload(16_384), Ok(()));
    assert_eq!(
        upload(16_385).expect_err("one too many").to_string(),
        "a cluster of 16385 leaves in compact records (at most 16384 fit) is not supported by this \
         version"
    );
}

#[test]
fn every_transfer_is_timed_by_its_devices_link() {
    let crown = random_crown(3, 40, 5);
    let states: Vec<State> = (0..12).map(|choice| random_state(&crown, choice)).collect();
    for link in Link::ALL {
        let descriptor = DeviceDescriptor {
            link,
            ..descriptor()
        };
        let (down, _) = ticks_per_byte(link.name());
        for kind in Kind::SOUND {
            let model = kind.model(&crown, OPTIONS);
            let mut stage = Stage::on(descriptor, &*model, &states[0], 8);
            for state in &states {
                stage.commit(state);
                stage.draw();
            }
            for transfer in stage.device.take_ledger().transfers {
                let wire = wire_bytes(link.name(), transfer.payload_bytes);
                assert_eq!(transfer.wire_bytes, wire, "{transfer:?}");
                assert_eq!(transfer.ticks, 4_096_000 + down * wire, "{transfer:?}");
            }
        }
    }
}

/// Host structures serialize to the length that they state; so do buffers, shared and per instance.
#[test]
fn storage_is_what_lies_there() {
    let scenery = [
        "leaf materials",
        "leaf face materials",
        "leaf face coordinates",
        "leaf texture",
        "view",
        "placements",
        "camera",
    ];
    let crowns = [(1, 2, 1), (2, 3, 3), (3, 25, 4), (4, 90, 9)].map(|(seed, leaves, roots)| {
        let crown = random_crown(seed, leaves, roots);
        [pruned(&crown), with_faces(&crown), crown]
    });
    for crown in crowns.into_iter().flatten() {
        let formats = LeafFormat::ALL.into_iter();
        let all = formats.flat_map(|format| Kind::LEAVES.map(|kind| (kind, format)));
        for (kind, format) in all {
            let model = kind.model(&crown, ModelOptions { format, ..OPTIONS });
            let storage = model.storage();
            let label = format!("{} {format:?}", kind.label());
            assert_eq!(
                storage.host_bytes,
                model.host_bytes().len() as u64,
                "{label}"
            );
            let mut device = Device::new(descriptor());
            let environment = Environment::of_kind(&mut device, 2, kind).expect("memory suffices");
            let shared = model
                .upload(&mut device, &environment)
                .expect("memory suffices");
            let held = |device: &Device| {
                let list = device.resident_by_label().into_iter();
                let models = list.filter(|(label, _)| !scenery.contains(&&**label));
                models.map(|(_, bytes)| bytes).sum::<u64>()
            };
            assert_eq!(held(&device), storage.shared_bytes, "{label}");
            let hosted = |device: &Device| {
                let lists = device
                    .buffers()
                    .filter(|(_, label)| label.starts_with("leaf list"));
                let bytes = |(id, label): (_, &str)| match (kind, label) {
                    // On the device, but for its lengths.
                    (Kind::VdfIndices, _) => 0,
                    _ => device.inspect_buffer(id).expect("it lives").len() as u64,
                };
                lists.map(bytes).sum::<u64>()
            };
            // A variable state, which takes the most.
            let counts = crown.clusters().clusters.iter();
            let counts = counts.map(|cluster| cluster.original_count() - 1).collect();
            let states = match kind.has_levels() {
                true => [(); 2].map(|()| State::Variable {
                    counts: Vec::clone(&counts),
                }),
                false => [State::FINEST, State::FINEST],
            };
            for instance in 1..=2 {
                let before = hosted(&device);
                let state = &states[instance as usize - 1];
                let mut resident = shared
                    .instance(&mut device, state, instance - 1)
                    .expect("memory suffices");
                // What it says it keeps on the host holds what lies there for the device to read.
                let lists = hosted(&device) - before;
                assert_eq!(
                    resident.host_bytes(),
                    storage.instance_host_bytes,
                    "{label}"
                );
                assert!(resident.host_bytes() >= lists, "{label}");
                for state in [&State::FINEST, state] {
                    let mut queue = device.queue();
                    resident.commit(&mut queue, state).expect("our own device");
                    assert!(resident.host_bytes() <= storage.instance_host_bytes);
                }
                assert_eq!(resident.host_bytes(), storage.instance_host_bytes);
                let wanted = storage.shared_bytes + u64::from(instance) * storage.instance_bytes;
                assert_eq!(held(&device), wanted, "{label} with {instance}");
            }
        }
    }
}

/// A texture of any size, with alpha from its place.
fn texture(width: u32, height: u32) -> Texture {
    let alpha = (0..=u8::MAX).cycle().step_by(37);
    let texels = alpha.map(|alpha| [200, 100, 50, alpha]);
    let rgba = texels
        .take(index_usize(u64::from(width * height)))
        .flatten()
        .collect();
    Texture::new(width, height, rgba).expect("four bytes a texel")
}

fn material(texture: Option<Texture>, alpha_cutoff: f32) -> Material {
    Material {
        name: "material".to_owned(),
        base_color: [1.0; 4],
        texture,
        alpha_cutoff,
    }
}

/// The levels of a texture in bytes: sides are halved, rounded down, until both are 1.
fn mip_bytes(mut width: u32, mut height: u32) -> Vec<u64> {
    let mut levels = vec![4 * u64::from(width * height)];
    while width.max(height) > 1 {
        (width, height) = ((width / 2).max(1), (height / 2).max(1));
        levels.push(4 * u64::from(width * height));
    }
    levels
}

/// Textures are sent once for each alpha cutoff that tests them; groups without one send none.
#[test]
fn textures_are_sent_once_with_all_their_levels() {
    let crown = random_crown(5, 12, 2);
    let groups = &crown.plant().foliage().groups;
    let variants = [
        // Both groups share one, differ in the cutoff, in the image, or have none at all.
        ((Some((9, 5)), 0.5), (Some((9, 5)), 0.5), vec![(9, 5)]),
        ((Some((9, 5)), 0.5), (Some((9, 5)), 0.25), vec![(9, 5); 2]),
        (
            (Some((16, 1)), 0.5),
            (Some((1, 3)), 0.5),
            vec![(16, 1), (1, 3)],
        ),
        ((None, 0.5), (Some((2, 2)), 0.0), vec![(2, 2)]),
        ((None, 0.5), (None, 0.0), vec![]),
    ];
    for (first, second, sent) in variants {
        let looks = [first, second].map(|(size, cutoff)| {
            let texture = size.map(|(width, height)| texture(width, height));
            material(texture, cutoff)
        });
        let mut groups = groups.clone();
        for (group, look) in groups.iter_mut().zip(looks) {
            group.material = look;
        }
        let plant = Plant::new("looks", None, None, Foliage { groups }).expect("sound parts");
        let crown = Arc::new(Crown::new(Arc::new(plant), crown.sequence().clone()));
        let mut stage = Stage::at(Kind::LodfSlots, OPTIONS, &crown, &State::FINEST, 8);
        let ledger = stage.device.take_ledger();
        let levels = sent.iter().flat_map(|&(w, h)| mip_bytes(w, h));
        let mut wanted: Vec<u64> = levels.collect();
        wanted.sort_unstable();
        let texture_transfers = ledger
            .transfers
            .iter()
            .filter(|t| t.cause.kind == "texture");
        let mut found: Vec<u64> = texture_transfers.map(|t| t.payload_bytes).collect();
        found.sort_unstable();
        assert_eq!(found, wanted);
        stage.draw();
        let forest = Forest::of(&crown);
        let expected = Expected::at(&forest, Kind::LodfSlots, LeafFormat::WIDE, &State::FINEST);
        let commands = stage.device.take_ledger().command_bytes;
        assert_eq!(commands, expected.command_bytes(sent.len() as u64));
    }
}

/// 32 bytes a vertex, 4 an index, 16 of surface, and the texture; a draw binds seven things.
#[test]
fn trunks_cost_what_their_mesh_holds() {
    for bark in [None, Some((6, 3))] {
        let mut device = Device::new(descriptor());
        let environment = Environment::new(&mut device, 1).expect("memory suffices");
        environment
            .place(&mut device.queue(), 0, &Placement::IDENTITY)
            .expect("room for one");
        device.take_ledger();
        let mesh = Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::ONE],
            normals: vec![Vec3::Z; 4],
            texture_coordinates: vec![Vec2::ZERO; 4],
            indices: vec![0, 1, 2, 2, 1, 3],
            material: material(bark.map(|(width, height)| texture(width, height)), 0.0),
        };
        let plant = Plant::new("trunk", None, Some(mesh), Foliage::default()).expect("sound parts");
        let trunk = Arc::new(Trunk::of(&Arc::new(plant), None).expect("it has one"));
        let model = TrunkKind::FULL.model(&trunk, OPTIONS);
        let shared = model.upload(&mut device, &environment);
        let shared = shared.expect("memory suffices");
        let levels = bark.map_or_else(Vec::new, |(w, h)| mip_bytes(w, h));
        let ledger = device.take_ledger();
        let bytes = 32 * 4 + 4 * 6 + 16 + levels.iter().sum::<u64>();
        assert_eq!(ledger.upload.payload_bytes, bytes);
        assert_eq!(ledger.upload.transfers, 3 + levels.len() as u64);
        assert_eq!(ledger.by_cause["trunk"].payload_bytes, bytes);
        let target = device
            .create_target(&TargetDescriptor {
                label: "frame",
                width: 8,
                height: 8,
                samples: Samples::One,
            })
            .expect("memory suffices");
        let mut steps = Vec::new();
        let resident = shared.instance(&mut device, &TrunkLevel::FINEST, 0);
        resident.expect("memory suffices").draw(&mut steps);
        let pass = RenderPass {
            label: "trunk".to_owned(),
            target,
            load: Load::Clear {
                color: Vec4::ZERO,
                depth: 1.0,
            },
            steps,
        };
        let submitted = device.queue().submit(&[Command::Render(pass)]);
        submitted.expect("a sound pass");
        let ledger = device.take_ledger();
        assert_eq!(ledger.command_bytes, 24 + 7 * 8 + 20);
        assert_eq!(
            (ledger.draws, ledger.vertices, ledger.primitives),
            (1, 6, 2)
        );
        assert!(ledger.transfers.is_empty());
    }
}
