//! What the device does is counted once, and recorded.

use super::*;

#[test]
fn host_memory_is_written_and_read_for_free() {
    let mut bench = Bench::new(0);
    let before = bench.device.recording().expect("from the start").clone();
    bench.device.take_ledger();
    let mut queue = bench.device.queue();
    queue
        .write(bench.host, 4, &[1, 2, 3], CAUSE)
        .expect("within");
    let read = queue.read(bench.host, 3, 4, CAUSE).expect("within");
    assert_eq!(read[1..], [1, 2, 3]);
    let ledger = bench.device.take_ledger();
    assert!(ledger.transfers.is_empty() && ledger.by_cause.is_empty());
    assert_eq!(bench.device.recording(), Some(&before));
    // Nor does the bus see nothing at all.
    let mut queue = bench.device.queue();
    queue.write(bench.vertices, 4, &[], CAUSE).expect("within");
    queue.write_regions(&[]).expect("nothing to refuse");
    assert!(
        queue
            .read(bench.vertices, 4, 0, CAUSE)
            .expect("within")
            .is_empty()
    );
    assert!(bench.device.take_ledger().transfers.is_empty());
    assert_eq!(bench.device.recording(), Some(&before));
}

#[test]
fn reads_are_counted_as_readback() {
    let mut bench = Bench::new(0);
    bench.device.take_ledger();
    let cause = Cause::numbered("sort", 7);
    let vertices = bench.vertices;
    let read = bench.device.queue().read(vertices, 12, 300, cause);
    let held = bench.device.inspect_buffer(vertices).expect("it lives");
    assert_eq!(read.expect("within"), held[12..312]);
    let ledger = bench.device.take_ledger();
    let link = bench.device.link();
    let transfer = Transfer {
        stream: Stream::Readback,
        resource: "vertices".to_owned(),
        cause,
        ranges: 1,
        payload_bytes: 300,
        wire_bytes: link.wire_bytes(300),
        ticks: link.ticks_up(300),
    };
    assert_eq!(ledger.transfers, [transfer]);
    let sum = ledger.readback;
    assert_eq!((sum.transfers, sum.payload_bytes), (1, 300));
    assert_eq!(
        (sum.wire_bytes, sum.ticks),
        (link.wire_bytes(300), link.ticks_up(300))
    );
    assert_eq!((ledger.upload.transfers, ledger.fetch.transfers), (0, 0));
    assert_eq!(ledger.by_cause["sort"].payload_bytes, 300);
    assert_eq!(ledger.by_buffer["vertices"].payload_bytes, 300);
    assert_eq!(ledger.command_bytes, 0);
}

#[test]
fn a_target_is_read_back_in_one_transfer() {
    let mut bench = Bench::new(0);
    let pass = bench.bound([draw(Corners::Indexed, 0, 4 * QUADS)]);
    let (picture, ..) = bench.shown(pass);
    let (target, cause) = (bench.target, Cause::of("bake"));
    let mut read = |layer| {
        let bytes = bench.device.queue().read_target(target, layer, cause);
        bytes.expect("it exists")
    };
    let [colour, plain, depth] =
        [TargetLayer::Colour, TargetLayer::Linear, TargetLayer::Depth].map(&mut read);
    assert_eq!(colour, picture.rgba);
    let held = bench.device.inspect_target(target).expect("it exists");
    let pixels = (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y)));
    for (index, (x, y)) in pixels.enumerate() {
        let at = 4 * index..4 * index + 4;
        assert_eq!(depth[at.clone()], held.depth(x, y).to_le_bytes());
        let green = (held.colour(x, y).y * 255.0 + 0.5).floor();
        assert_eq!(f32::from(plain[at.start + 1]), green);
    }
    let ledger = bench.device.take_ledger();
    let size = 4 * u64::from(SIDE * SIDE);
    let sum = ledger.readback;
    assert_eq!((sum.transfers, sum.payload_bytes), (3, 3 * size));
    assert_eq!(sum.ticks, 3 * bench.device.link().ticks_up(size));
    assert_eq!(ledger.by_buffer["picture"].payload_bytes, 3 * size);
    assert_eq!(ledger.by_cause["bake"].transfers, 3);
    assert_eq!((ledger.upload.transfers, ledger.command_bytes), (0, 0));
}

#[test]
fn texels_of_floats_take_sixteen_bytes() {
    let mut bench = Bench::new(0);
    let held = bench.device.resident_bytes();
    let written = bench.device.take_ledger().upload.payload_bytes;
    let texture = bench.device.create_texture(&TextureDescriptor {
        label: "map",
        format: TextureFormat::Float32,
        width: 3,
        height: 2,
        levels: 2,
    });
    let texture = texture.expect("memory suffices");
    assert_eq!(bench.device.resident_bytes(), held + 16 * (3 * 2 + 1));
    let message = bench.refused(|bench| {
        let queue = &mut bench.device.queue();
        queue.write_texture(texture, 0, &[0; 24], CAUSE)
    });
    assert_eq!(message, "\"map\" holds 96 bytes, write wants 0..24");
    let bytes: Vec<u8> = (0..96).collect();
    let sent = bench
        .device
        .queue()
        .write_texture(texture, 0, &bytes, CAUSE);
    sent.expect("exactly the level");
    assert_eq!(bench.device.inspect_texture(texture, 0), Ok(&bytes[..]));
    check_conservation(&bench.device, written + 96).expect("the replay agrees");
}

#[test]
fn copies_and_clears_are_recorded_and_replayed() {
    let mut bench = Bench::new(4);
    let written = bench.device.take_ledger().upload.payload_bytes;
    let (vertices, arguments) = (bench.vertices, bench.arguments);
    let commands = [
        Command::Copy {
            source: vertices,
            source_offset: 100,
            destination: arguments,
            destination_offset: 7,
            size: 200,
        },
        // Onto itself, overlapping: as if through a copy of the source.
        Command::Copy {
            source: vertices,
            source_offset: 0,
            destination: vertices,
            destination_offset: 5,
            size: 90,
        },
        Command::Clear {
            buffer: arguments,
            offset: 20,
            size: 33,
        },
    ];
    let before = bench
        .device
        .inspect_buffer(vertices)
        .expect("it lives")
        .to_vec();
    bench.device.queue().submit(&commands).expect("all within");
    let held = |buffer| bench.device.inspect_buffer(buffer).expect("it lives");
    assert_eq!(held(arguments)[7..20], before[100..113]);
    assert!(held(arguments)[20..53].iter().all(|&byte| byte == 0));
    assert_eq!(held(arguments)[53..207], before[146..300]);
    assert_eq!(held(vertices)[5..95], before[..90]);
    let (device, texture) = (&mut bench.device, bench.texture);
    for (level, size) in [(0, 32), (1, 8)] {
        let bytes: Vec<u8> = (0..size).collect();
        let sent = device.queue().write_texture(texture, level, &bytes, CAUSE);
        sent.expect("exactly the level");
    }
    check_conservation(device, written + 40).expect("the replay agrees");
    let ledger = device.take_ledger();
    assert_eq!(ledger.command_bytes, 3 * 24);
    assert_eq!(
        (ledger.upload.transfers, ledger.upload.payload_bytes),
        (2, 40)
    );
}

#[test]
fn memory_in_use_and_its_peak() {
    let mut bench = Bench::new(0);
    let held = bench.device.resident_bytes();
    let make = |device: &mut Device, size, residency| {
        device
            .create_buffer(&buffer_of("more", size, residency))
            .expect("memory suffices")
    };
    let first = make(&mut bench.device, 1000, Residency::Device);
    let host = make(&mut bench.device, 5000, Residency::Host);
    let labels = bench.device.resident_by_label();
    assert!(labels.contains(&("more".to_owned(), 1000)), "{labels:?}");
    assert_eq!(
        labels.iter().map(|(_, bytes)| bytes).sum::<u64>(),
        held + 1000
    );
    assert!(labels.is_sorted_by_key(|(_, bytes)| std::cmp::Reverse(*bytes)));
    bench.device.destroy_buffer(first).expect("it lives");
    bench.device.destroy_buffer(host).expect("it lives");
    make(&mut bench.device, 10, Residency::Device);
    let ledger = bench.device.take_ledger();
    assert_eq!(
        (ledger.resident_bytes, ledger.peak_bytes),
        (held + 10, held + 1000)
    );
    // The peak is of the device's life, not of a ledger; a freed name is not given again.
    let ledger = bench.device.take_ledger();
    assert_eq!(
        (ledger.resident_bytes, ledger.peak_bytes),
        (held + 10, held + 1000)
    );
    assert!(bench.device.inspect_buffer(first).is_err());
    assert!(bench.device.buffers().all(|(buffer, _)| buffer != first));
}

#[test]
fn command_bytes_are_those_of_the_table() {
    let mut bench = Bench::new(0);
    let (vertices, indices, arguments, counter, host) = (
        bench.vertices,
        bench.indices,
        bench.arguments,
        bench.counter,
        bench.host,
    );
    let (texture, target, pushed) = (bench.texture, bench.target, bench.pushed);
    let mut cost = |command: Command| {
        bench.device.take_ledger();
        bench.submit(command).expect("a sound command");
        bench.device.take_ledger().command_bytes
    };
    let pass = |steps: &[Step]| {
        Command::Render(RenderPass {
            label: "pass".to_owned(),
            target,
            load: Load::Keep,
            steps: steps.to_vec(),
        })
    };
    assert_eq!(cost(pass(&[])), 24);
    for bind in [
        Step::Program(pushed),
        Step::Vertices(vertices),
        Step::Indices(indices),
        Step::Storage {
            slot: 15,
            buffer: vertices,
        },
        Step::Texture { slot: 15, texture },
        Step::NoTexture { slot: 15 },
    ] {
        assert_eq!(cost(pass(&[bind])), 24 + 8, "{bind:?}");
    }
    let bound = [Step::Program(pushed), Step::Vertices(vertices)];
    // Zeros as arguments: no instances; as vertices: some records of what they hold.
    for (step, bytes) in [
        (draw(Corners::Counted, 0, 8), 20),
        (from_counter(Corners::Counted, counter, 0, 8), 20),
        (indirect(Corners::Counted, arguments, 0, 0), 0),
        (indirect(Corners::Counted, arguments, 16, 3), 3 * 8),
    ] {
        assert_eq!(
            cost(pass(&[bound[0], bound[1], step, step])),
            40 + 2 * bytes,
            "{step:?}"
        );
    }
    let copy = Command::Copy {
        source: vertices,
        source_offset: 0,
        destination: counter,
        destination_offset: 0,
        size: 4,
    };
    assert_eq!(cost(copy), 24);
    let clear = Command::Clear {
        buffer: counter,
        offset: 0,
        size: 4,
    };
    assert_eq!(cost(clear), 24);
    // Arguments in host memory are put into the command stream as plain draws.
    let mut queue = bench.device.queue();
    queue.write(host, 0, &[0; 48], CAUSE).expect("within");
    bench.device.take_ledger();
    let steps = [bound[0], bound[1], indirect(Corners::Counted, host, 0, 3)];
    bench.submit(bench.pass(steps)).expect("a sound pass");
    let ledger = bench.device.take_ledger();
    assert_eq!(ledger.command_bytes, 40 + 3 * 20);
    assert!(ledger.transfers.is_empty());
    // A gathered write copies each region from the staging area.
    let region = |offset| Region {
        buffer: vertices,
        offset,
        bytes: &[1, 2],
        cause: CAUSE,
    };
    let empty = Region {
        bytes: &[],
        ..region(0)
    };
    let mut queue = bench.device.queue();
    queue
        .write_regions(&[region(0), empty, region(9)])
        .expect("within");
    let ledger = bench.device.take_ledger();
    assert_eq!((ledger.command_bytes, ledger.upload.transfers), (2 * 24, 1));
    assert_eq!(ledger.upload.payload_bytes, 4);
}

#[test]
fn host_vertices_are_fetched_again_by_every_draw() {
    let mut bench = Bench::new(2);
    let from_device = draw(Corners::Indexed, 0, 4 * QUADS);
    let (image, keys, ledger) = bench.shown(bench.bound([from_device]));
    assert!(ledger.transfers.is_empty());
    let steps = [Step::Vertices(bench.host), from_device, from_device];
    let (host_image, host_keys, ledger) = bench.shown(bench.bound(steps));
    assert_eq!((host_image, host_keys), (image, keys));
    let pulled: Vec<_> = ledger
        .transfers
        .iter()
        .map(|t| (t.stream, &*t.resource, t.payload_bytes))
        .collect();
    assert_eq!(pulled, [(Stream::Fetch, "host", VERTEX_BYTES); 2]);
}

#[test]
fn exact_counters_are_of_pictures() {
    let mut bench = Bench::new(0);
    bench.device.take_ledger();
    let pass = bench.bound([]);
    let refused = bench.device.queue().tally(&[pass]);
    assert!(matches!(refused, Err(GpuError::Unsupported { .. })));
    assert_eq!(bench.device.take_ledger().command_bytes, 0);
}
