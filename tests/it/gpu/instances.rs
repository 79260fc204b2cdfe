//! Draws of several instances, and colours that fragment stages read.

use spinney::gpu::{ColourMap, DrawInstanced, DrawInstancedIndirect};

use super::*;

/// Positions moved to the right by a tenth for each number of the instance.
#[derive(Debug)]
struct Moved;

impl Program for Moved {
    fn layout(&self) -> Layout {
        PUSHED
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        Flat(PUSHED).vertex_stage(call, geometry);
        for position in &mut geometry.clip {
            position.x += call.instance as f32 / 10.0;
        }
    }

    fn fragment_stage<'a>(&self, _: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        Box::new(Grey)
    }
}

const NUMBERS: [u32; 5] = [7, 3, 0, 3, 9];

/// A buffer of numbers of instances.
fn numbers(bench: &mut Bench, residency: Residency) -> BufferId {
    let descriptor = BufferDescriptor {
        label: "instances",
        size: 4 * NUMBERS.len() as u64,
        usage: Usage::VERTEX,
        residency,
    };
    let buffer = bench.device.create_buffer(&descriptor);
    let buffer = buffer.expect("memory suffices");
    let mut queue = bench.device.queue();
    let written = queue.write(buffer, 0, &words(NUMBERS), CAUSE);
    written.expect("within the buffer");
    buffer
}

fn instanced(instances: BufferId, first_instance: u32, instance_count: u32) -> Step {
    Step::DrawInstanced(DrawInstanced {
        source: Corners::Indexed,
        first_corner: 4,
        corner_count: 4 * 20,
        instances,
        first_instance,
        instance_count,
        group: 5,
    })
}

fn one_by_one(range: std::ops::Range<usize>) -> Vec<Step> {
    let draw = |&instance| {
        Step::Draw(Draw {
            source: Corners::Indexed,
            first_corner: 4,
            corner_count: 4 * 20,
            instance,
            group: 5,
        })
    };
    NUMBERS[range].iter().map(draw).collect()
}

#[test]
fn an_instanced_draw_shows_what_one_draw_an_instance_does() {
    let mut bench = Bench::new(5);
    let program = bench.device.create_program(Arc::new(Moved));
    let moved = |steps: Vec<Step>| [vec![Step::Program(program)], steps].concat();
    let numbers = numbers(&mut bench, Residency::Device);
    let [host, arguments] = [bench.host, bench.arguments];
    let written = {
        let mut queue = bench.device.queue();
        let record = IndirectRecord {
            corner_count: 4 * 20,
            instances: 3,
            first_corner: 4,
            instance: 1,
        };
        let written = queue.write(arguments, 16, &record.to_bytes(), CAUSE);
        written.and(queue.write(host, 8, &words(NUMBERS), CAUSE))
    };
    written.expect("within the buffers");
    let (image, keys, single) = bench.shown(bench.bound(moved(one_by_one(1..4))));
    let ways = [
        (instanced(numbers, 1, 3), 28, 0),
        (instanced(host, 3, 3), 28, 12),
        (
            Step::DrawInstancedIndirect(DrawInstancedIndirect {
                source: Corners::Indexed,
                arguments,
                offset: 16,
                instances: numbers,
                group: 5,
            }),
            16,
            0,
        ),
    ];
    for (step, command_bytes, pulled) in ways {
        let (found, found_keys, ledger) = bench.shown(bench.bound(moved(vec![step])));
        assert_eq!((&found, &found_keys), (&image, &keys), "{step:?}");
        assert_eq!(ledger.draws, 1);
        assert_eq!(ledger.work, single.work);
        assert_eq!(
            [ledger.vertices, ledger.primitives, ledger.visible_samples],
            [single.vertices, single.primitives, single.visible_samples]
        );
        assert_eq!(
            ledger.command_bytes + 3 * 20,
            single.command_bytes + command_bytes
        );
        assert_eq!(ledger.stream(Stream::Fetch).payload_bytes, pulled);
    }
}

#[test]
fn no_instances_are_an_empty_draw_and_those_beyond_the_buffer_are_refused() {
    let mut bench = Bench::new(5);
    let numbers = numbers(&mut bench, Residency::Device);
    let (_, keys, ledger) = bench.shown(bench.bound([instanced(numbers, 2, 0)]));
    assert!(keys.iter().all(Option::is_none));
    assert_eq!(
        [ledger.draws, ledger.empty_draws, ledger.vertices],
        [1, 1, 0]
    );
    let found = bench.refused(|bench| bench.submit(bench.bound([instanced(numbers, 3, 3)])));
    assert_eq!(
        found,
        "\"instances\" holds 20 bytes, instanced draw wants 12..24"
    );
    let [indices, arguments] = [bench.indices, bench.arguments];
    let found = bench.refused(|bench| bench.submit(bench.bound([instanced(indices, 0, 1)])));
    assert_eq!(
        found,
        "\"indices\" was created for {INDEX}, but is used as {VERTEX}"
    );
    let in_host = DrawInstancedIndirect {
        source: Corners::Indexed,
        arguments: bench.host,
        offset: 0,
        instances: numbers,
        group: 5,
    };
    let found =
        bench.refused(|bench| bench.submit(bench.bound([Step::DrawInstancedIndirect(in_host)])));
    assert!(found.contains("arguments of an instanced draw"), "{found}");
    let beyond = Step::DrawInstancedIndirect(DrawInstancedIndirect {
        arguments,
        offset: 632,
        ..in_host
    });
    let found = bench.refused(|bench| bench.submit(bench.bound([beyond])));
    assert!(found.contains("instanced draw"), "{found}");
}

/// Draws positions as they are, in the colour that a target has there, red and blue swapped.
#[derive(Debug)]
struct Swapped;

impl Program for Swapped {
    fn layout(&self) -> Layout {
        PUSHED
    }

    fn vertex_stage(&self, call: &VertexCall<'_>, geometry: &mut Geometry) {
        Flat(PUSHED).vertex_stage(call, geometry);
        geometry.flats.clear();
    }

    fn fragment_stage<'a>(&self, bindings: &Bindings<'a>) -> Box<dyn Kernel + 'a> {
        Box::new(ColourBehind(bindings.colour(2)))
    }
}

#[derive(Debug)]
struct ColourBehind<'a>(Option<ColourMap<'a>>);

impl Fragment for ColourBehind<'_> {
    const VARYINGS: usize = 0;
    const FLATS: usize = 0;
    const TESTS_ALPHA: bool = false;
    const IN_LANES: bool = false;

    fn keeps(&self, _: &Pixel<'_>) -> bool {
        true
    }

    fn shade(&self, pixel: &Pixel<'_>) -> Vec4 {
        let colour = self.0.map_or(Vec4::ONE, |map| map.colour(pixel.position));
        Vec4::new(colour.z, colour.y, colour.x, colour.w)
    }
}

#[test]
fn colours_read_as_they_were_drawn() {
    let mut bench = Bench::new(9);
    let first = TargetDescriptor {
        label: "first",
        width: SIDE,
        height: SIDE,
        samples: Samples::Four,
    };
    let first = bench.device.create_target(&first).expect("memory suffices");
    let Command::Render(pass) = bench.bound([draw(Corners::Indexed, 0, 4 * QUADS)]) else {
        panic!("a pass that renders");
    };
    let into_first = Command::Render(RenderPass {
        target: first,
        ..pass
    });
    bench.submit(into_first).expect("a sound pass");
    let program = bench.device.create_program(Arc::new(Swapped));
    let read = |target| Step::Colour { slot: 2, target };
    let all = draw(Corners::Indexed, 0, 4 * QUADS);
    bench.shown(bench.bound([Step::Program(program), read(first), all]));
    let target = |id| bench.device.inspect_target(id).expect("it exists");
    let (read_from, shown) = (target(first), target(bench.target));
    let mut compared = 0;
    for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
        if shown.key(x, y).is_some() {
            let colour = read_from.colour(x, y);
            let swapped = Vec4::new(colour.z, colour.y, colour.x, colour.w);
            assert_eq!(shown.colour(x, y), swapped);
            compared += 1;
        }
    }
    assert!(compared > 200, "{compared} pixels");

    let own = read(bench.target);
    let found = bench.refused(|bench| bench.submit(bench.bound([own])));
    assert_eq!(
        found,
        "\"picture\" was created for the target of the pass, but is used as colour that it reads"
    );
    let shadow = TargetDescriptor {
        label: "shadow",
        width: 8,
        height: 8,
        samples: Samples::One,
    };
    let shadow = bench.device.create_depth_target(&shadow);
    let shadow = read(shadow.expect("memory suffices"));
    let found = bench.refused(|bench| bench.submit(bench.bound([shadow])));
    assert_eq!(
        found,
        "\"shadow\" was created for depth alone, but is used as colour"
    );
}
