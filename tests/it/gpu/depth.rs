//! Targets of depth alone, and depth that fragment stages read.

use super::*;

/// Draws positions as they are, coloured by the depth that was drawn before.
#[derive(Debug)]
struct Behind;

impl Program for Behind {
    fn layout(&self) -> Layout {
        PUSHED
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        Flat(PUSHED).vertex_stage(call, geometry);
        geometry.flats.clear();
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        Box::new(DepthBehind(bindings.depth(3)))
    }
}

#[derive(Debug)]
struct DepthBehind<'a>(Option<DepthMap<'a>>);

impl Fragment for DepthBehind<'_> {
    const VARYINGS: usize = 0;
    const FLATS: usize = 0;
    const TESTS_ALPHA: bool = false;

    fn keeps(&self, _: &Pixel<'_>) -> bool {
        true
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let depth = self.0.map_or(-1.0, |map| map.depth(pixel.position));
        Vec4::new(depth, pixel.depth, 0.0, 1.0)
    }
}

#[test]
fn depth_alone_takes_half_the_memory_and_reads_as_it_was_drawn() {
    let mut bench = Bench::new(3);
    let held = bench.device.resident_bytes();
    let shadow = TargetDescriptor {
        label: "shadow",
        width: SIDE,
        height: SIDE,
        samples: Samples::One,
    };
    let shadow = bench.device.create_depth_target(&shadow);
    let shadow = shadow.expect("memory suffices");
    assert_eq!(
        bench.device.resident_bytes(),
        held + 4 * u64::from(SIDE * SIDE)
    );
    let all = [draw(Corners::Indexed, 0, 4 * QUADS)];
    let pass = bench.bound(all);
    let (_, keys, coloured) = bench.shown(pass.clone());
    let depths = |bench: &mut Bench, target| {
        let layer = TargetLayer::Depth;
        let bytes = bench.device.queue().read_target(target, layer, CAUSE);
        bytes.expect("it exists")
    };
    let picture = bench.target;
    let expected = depths(&mut bench, picture);
    let Command::Render(pass) = pass else {
        panic!("a pass that renders");
    };
    let into_shadow = Command::Render(RenderPass {
        target: shadow,
        ..pass
    });
    bench.device.take_ledger();
    bench.submit(into_shadow).expect("a sound pass");
    let ledger = bench.device.take_ledger();
    assert_eq!(ledger.visible_samples, coloured.visible_samples);
    assert_eq!(ledger.command_bytes, coloured.command_bytes);
    assert_eq!(depths(&mut bench, shadow), expected);
    let found = bench.device.inspect_target(shadow).expect("it exists");
    let pixels = (0..SIDE * SIDE).map(|pixel| found.key(pixel % SIDE, pixel / SIDE));
    assert!(pixels.map(|key| key.map(|key| key.vertex)).eq(keys));

    // Read by a pass into the other target.
    let behind = bench.device.create_program(Arc::new(Behind));
    let steps = [
        Step::Depth {
            slot: 3,
            target: shadow,
        },
        Step::Program(behind),
        all[0],
    ];
    let (_, _, ledger) = bench.shown(bench.bound(steps));
    assert_eq!(ledger.command_bytes, coloured.command_bytes + 2 * 8);
    let held = bench.device.inspect_target(bench.target);
    let held = held.expect("it exists");
    let mut compared = 0;
    for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
        if held.key(x, y).is_some() {
            let depth = held.depth(x, y);
            assert_eq!(held.colour(x, y), Vec4::new(depth, depth, 0.0, 1.0));
            compared += 1;
        }
    }
    assert!(compared > 200, "{compared} pixels");
}

#[test]
fn what_depth_cannot_be_is_refused() {
    let mut bench = Bench::new(3);
    let shadow = TargetDescriptor {
        label: "shadow",
        width: 8,
        height: 8,
        samples: Samples::Four,
    };
    let shadow = bench.device.create_depth_target(&shadow);
    let shadow = shadow.expect("memory suffices");
    let own = Step::Depth {
        slot: 0,
        target: bench.target,
    };
    let found = bench.refused(|bench| bench.submit(bench.bound([own])));
    let says =
        "\"picture\" was created for the target of the pass, but is used as depth that it reads";
    assert_eq!(found, says);
    let far = Step::Depth {
        slot: 16,
        target: shadow,
    };
    let found = bench.refused(|bench| bench.submit(bench.bound([far])));
    assert_eq!(found, "binding slot 16 does not exist on this device");
    let says = "\"shadow\" was created for depth alone, but is used as colour";
    for layer in [TargetLayer::Colour, TargetLayer::Linear] {
        let found = bench.refused(|bench| {
            let queue = &mut bench.device.queue();
            queue.read_target(shadow, layer, CAUSE)
        });
        assert_eq!(found, says);
    }
    let found = bench.refused(|bench| bench.device.present(shadow).map(|_| ()));
    assert_eq!(found, says);
    let wide = TargetDescriptor {
        label: "wide",
        width: 16_385,
        height: 1,
        samples: Samples::One,
    };
    let found = bench.refused(|bench| bench.device.create_depth_target(&wide));
    assert_eq!(found, "\"wide\": width is 16385, wanted 1 to 16384");
}
