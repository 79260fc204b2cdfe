//! Where draw arguments lie does not show.

use super::*;

/// One topology after another over the same corners.
#[test]
fn topologies_make_primitives_of_their_corners() {
    let mut bench = Bench::new(1);
    for (topology, primitives) in [
        (Topology::LineList, 12),
        (Topology::TriangleList, 8),
        (Topology::QuadList, 6),
    ] {
        let program = bench.program(Layout { topology, ..PUSHED });
        let steps = [Step::Program(program), draw(Corners::Indexed, 0, 24)];
        let (_, keys, ledger) = bench.shown(bench.bound(steps));
        assert_eq!((ledger.vertices, ledger.primitives), (24, primitives));
        assert!(keys.iter().any(Option::is_some), "{topology:?}");
    }
}

crate::support::properties! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    /// However quads are cut into indirect draws, and where empty ones stand between them.
    #[test]
    fn indirect_draws_equal_the_direct_one(
        seed in any::<u64>(),
        cuts in proptest::collection::btree_set(0..=QUADS, 0..18),
        source in proptest::sample::select(vec![Corners::Counted, Corners::Indexed]),
    ) {
        let mut bench = Bench::new(seed);
        let (image, keys, direct) = bench.shown(bench.bound([draw(source, 0, 4 * QUADS)]));
        let ends: Vec<u32> = cuts.into_iter().chain([QUADS]).collect();
        let mut records = Vec::new();
        let mut first = 0;
        for &end in &ends {
            let record = IndirectRecord {
                corner_count: 4 * (end - first),
                instances: 1,
                first_corner: 4 * first,
                instance: 3,
            };
            let nothing = IndirectRecord {
                instances: 0,
                corner_count: 5,
                ..record
            };
            records.extend([record, nothing].map(IndirectRecord::to_bytes).concat());
            first = end;
        }
        let count = 2 * index_u32(ends.len());
        for buffer in [bench.arguments, bench.host] {
            let written = bench.device.queue().write(buffer, 0, &records, CAUSE);
            written.expect("within the buffer");
            let steps = [indirect(source, buffer, 0, count)];
            let (found_image, found_keys, ledger) = bench.shown(bench.bound(steps));
            prop_assert_eq!(&found_image, &image);
            prop_assert_eq!(&found_keys, &keys);
            prop_assert_eq!(ledger.work, direct.work);
            prop_assert_eq!(ledger.vertices, direct.vertices);
            prop_assert_eq!(ledger.visible_samples, direct.visible_samples);
            prop_assert_eq!(ledger.draws, u64::from(count));
        }
    }

    #[test]
    fn draws_from_a_counter_equal_the_direct_one(
        seed in any::<u64>(),
        counter in proptest::prop_oneof![0..40_u32, proptest::prelude::Just(u32::MAX), any::<u32>()],
        quads in 0..=QUADS,
        source in proptest::sample::select(vec![Corners::Counted, Corners::Indexed]),
    ) {
        let mut bench = Bench::new(seed);
        let end = 4 * quads;
        let first = match counter {
            u32::MAX => 0,
            counter => counter.saturating_mul(8).min(end),
        };
        let (image, keys, direct) = bench.shown(bench.bound([draw(source, first, end - first)]));
        let buffer = bench.counter;
        let written = bench.device.queue().write(buffer, 0, &words([counter]), CAUSE);
        written.expect("within the buffer");
        let (found_image, found_keys, ledger) =
            bench.shown(bench.bound([from_counter(source, buffer, 0, end)]));
        prop_assert_eq!(found_image, image);
        prop_assert_eq!(found_keys, keys);
        prop_assert_eq!(ledger, direct);
    }
}
