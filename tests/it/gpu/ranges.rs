//! What does not fit is refused, with the label and the two numbers that disagree.

use super::*;

#[test]
fn memory_that_is_not_there_is_refused_with_its_numbers() {
    let mut bench = Bench::new(0);
    let held = bench.device.resident_bytes();
    // Target, texture with two levels, vertices, indices, arguments, counter.
    let target = 8 * u64::from(SIDE * SIDE);
    let texture = 4 * (4 * 2 + 2);
    assert_eq!(
        held,
        target + texture + VERTEX_BYTES + 16 * u64::from(QUADS) + 640 + 4
    );
    let free = MEMORY - held;
    let advice = "are free; raise the budget or send less";
    let buffer = |size| buffer_of("far too large", size, Residency::Device);
    let message = bench.refused(|bench| bench.device.create_buffer(&buffer(free + 1)));
    let asked = free + 1;
    assert_eq!(
        message,
        format!(
            "\"far too large\" asks for {asked} bytes of device memory, but {free} of {MEMORY} {advice}"
        )
    );
    let message = bench.refused(|bench| bench.device.create_buffer(&buffer(u64::MAX)));
    assert!(
        message.contains(&format!("asks for {}", u64::MAX)),
        "{message}"
    );
    let message = bench.refused(|bench| {
        bench.device.create_texture(&TextureDescriptor {
            label: "atlas",
            format: TextureFormat::Srgb8,
            width: 1024,
            height: 512,
            levels: 3,
        })
    });
    let asked = 4 * (1024 * 512 + 512 * 256 + 256 * 128);
    assert_eq!(
        message,
        format!(
            "\"atlas\" asks for {asked} bytes of device memory, but {free} of {MEMORY} {advice}"
        )
    );
    let message = bench.refused(|bench| {
        bench.device.create_target(&TargetDescriptor {
            label: "poster",
            width: 300,
            height: 200,
            samples: Samples::Four,
        })
    });
    let asked = 4 * 8 * 300 * 200;
    assert_eq!(
        message,
        format!(
            "\"poster\" asks for {asked} bytes of device memory, but {free} of {MEMORY} {advice}"
        )
    );
    // To the last byte it fits, and what lies on the host takes none.
    bench.device.create_buffer(&buffer(free)).expect("it fits");
    let host = buffer_of("host", 1 << 22, Residency::Host);
    bench.device.create_buffer(&host).expect("host memory");
    assert_eq!(bench.device.resident_bytes(), MEMORY);
    // More than any machine has is refused, not asked for.
    let host = buffer_of("host", u64::MAX / 2, Residency::Host);
    assert!(bench.device.create_buffer(&host).is_err());
}

#[test]
fn sides_and_levels_that_cannot_be_are_refused() {
    let mut bench = Bench::new(0);
    for (side, what) in [((0, 9), "width is 0"), ((9, 20_000), "height is 20000")] {
        let message = bench.refused(|bench| {
            bench.device.create_target(&TargetDescriptor {
                label: "poster",
                width: side.0,
                height: side.1,
                samples: Samples::One,
            })
        });
        assert_eq!(message, format!("\"poster\": {what}, wanted 1 to 16384"));
    }
    for (width, height, levels, what) in [
        (0, 4, 1, "width is 0, wanted 1 to 8192"),
        (4, 8193, 1, "height is 8193, wanted 1 to 8192"),
        (8, 4, 0, "number of levels is 0, wanted 1 to 4"),
        (8, 4, 5, "number of levels is 5, wanted 1 to 4"),
    ] {
        let message = bench.refused(|bench| {
            bench.device.create_texture(&TextureDescriptor {
                label: "bark",
                format: TextureFormat::Srgb8,
                width,
                height,
                levels,
            })
        });
        assert_eq!(message, format!("\"bark\": {what}"));
    }
}

#[test]
fn ranges_past_the_end_are_refused() {
    let mut bench = Bench::new(0);
    let (vertices, counter, texture) = (bench.vertices, bench.counter, bench.texture);
    let says =
        |label: &str, holds: u64, what: &str| format!("{label:?} holds {holds} bytes, {what}");
    let write = |offset: u64, size: usize| {
        move |bench: &mut Bench| {
            let bytes = vec![1; size];
            bench.device.queue().write(counter, offset, &bytes, CAUSE)
        }
    };
    assert_eq!(
        bench.refused(write(1, 4)),
        says("counter", 4, "write wants 1..5")
    );
    assert_eq!(
        bench.refused(write(5, 0)),
        says("counter", 4, "write wants 5..5")
    );
    let far = format!("write wants {}..{}", u64::MAX - 1, u64::MAX);
    assert_eq!(
        bench.refused(write(u64::MAX - 1, 4)),
        says("counter", 4, &far)
    );
    // The second of two regions is wrong: the first is not written either.
    let message = bench.refused(|bench| {
        let region = |buffer, offset| Region {
            buffer,
            offset,
            bytes: &[9; 8],
            cause: CAUSE,
        };
        let regions = [region(vertices, 0), region(counter, 0)];
        bench.device.queue().write_regions(&regions)
    });
    assert_eq!(message, says("counter", 4, "write wants 0..8"));
    for (level, size, holds) in [(0, 31, 32), (1, 32, 8), (2, 4, 0)] {
        let message = bench.refused(|bench| {
            let bytes = vec![7; size];
            bench
                .device
                .queue()
                .write_texture(texture, level, &bytes, CAUSE)
        });
        assert_eq!(
            message,
            says("bark", holds, &format!("write wants 0..{size}"))
        );
    }
    let message =
        bench.refused(|bench| bench.device.queue().read(vertices, 1, VERTEX_BYTES, CAUSE));
    let range = format!("read wants 1..{}", VERTEX_BYTES + 1);
    assert_eq!(message, says("vertices", VERTEX_BYTES, &range));
    let message = bench.refused(|bench| {
        bench.submit(Command::Copy {
            source: vertices,
            source_offset: 0,
            destination: counter,
            destination_offset: 0,
            size: 8,
        })
    });
    assert_eq!(message, says("counter", 4, "copy wants 0..8"));
    let message = bench.refused(|bench| {
        bench.submit(Command::Clear {
            buffer: counter,
            offset: 4,
            size: 1,
        })
    });
    assert_eq!(message, says("counter", 4, "clear wants 4..5"));
    assert!(bench.device.poison(counter, 3..5, 1).is_err());
}

#[test]
fn draws_past_the_end_are_refused() {
    let mut bench = Bench::new(0);
    let all = 4 * QUADS;
    let (arguments, counter) = (bench.arguments, bench.counter);
    let says =
        |label: &str, holds: u64, what: &str| format!("{label:?} holds {holds} bytes, {what}");
    let index_bytes = 4 * u64::from(all);
    for (step, message) in [
        (
            draw(Corners::Indexed, 4, all),
            says(
                "indices",
                index_bytes,
                &format!("draw wants 16..{}", index_bytes + 16),
            ),
        ),
        (
            draw(Corners::Counted, all, 4),
            says(
                "vertices",
                VERTEX_BYTES,
                &format!("draw wants {}..{}", VERTEX_BYTES + 36, VERTEX_BYTES + 48),
            ),
        ),
        // So many corners that listing them would be the end.
        (
            draw(Corners::Counted, u32::MAX, u32::MAX - 3),
            says(
                "vertices",
                VERTEX_BYTES,
                &format!(
                    "draw wants {}..{}",
                    12 * (2 * u64::from(u32::MAX) - 4),
                    12 * (2 * u64::from(u32::MAX) - 3)
                ),
            ),
        ),
        (
            indirect(Corners::Indexed, arguments, 0, 41),
            says("arguments", 640, "indirect draw wants 0..656"),
        ),
        (
            indirect(Corners::Indexed, arguments, 632, 1),
            says("arguments", 640, "indirect draw wants 632..648"),
        ),
        (
            from_counter(Corners::Indexed, counter, 1, all),
            says("counter", 4, "draw from a counter wants 1..5"),
        ),
    ] {
        let found = bench.refused(|bench| bench.submit(bench.bound([step])));
        assert_eq!(found, message);
    }
    // An index that names no vertex.
    let indices = bench.indices;
    let written = bench.device.queue().write(indices, 8, &words([all]), CAUSE);
    written.expect("within the buffer");
    let found = bench.refused(|bench| bench.submit(bench.bound([draw(Corners::Indexed, 0, 8)])));
    let range = format!("draw wants {VERTEX_BYTES}..{}", VERTEX_BYTES + 12);
    assert_eq!(found, says("vertices", VERTEX_BYTES, &range));
}
