//! What is not there, or not made for a use, is refused.

use super::*;

#[test]
fn uses_that_a_resource_was_not_made_for_are_refused() {
    let mut bench = Bench::new(0);
    let (vertices, indices, counter, host) =
        (bench.vertices, bench.indices, bench.counter, bench.host);
    let pull = Layout {
        name: "pulled",
        vertex_stride: 0,
        pulled_primitive_bytes: 0,
        pulled_vertex_bytes: 0,
        storage_slots: 1,
        ..PUSHED
    };
    let pulled = bench.program(pull);
    let indexed = draw(Corners::Indexed, 0, 4);
    let storage = |buffer| Step::Storage { slot: 0, buffer };
    let only_index = "\"indices\" was created for {INDEX}, but is used as";
    let cases: [(&[Step], String); 5] = [
        (
            &[Step::Vertices(indices), indexed],
            format!("{only_index} {{VERTEX}}"),
        ),
        (
            &[Step::Indices(counter), indexed],
            "\"counter\" was created for {INDIRECT}, but is used as {INDEX}".to_owned(),
        ),
        (
            &[Step::Program(pulled), storage(indices), indexed],
            format!("{only_index} {{STORAGE}}"),
        ),
        (
            &[indirect(Corners::Indexed, indices, 0, 1)],
            format!("{only_index} {{INDIRECT}}"),
        ),
        (
            &[from_counter(Corners::Indexed, indices, 0, 4)],
            format!("{only_index} {{INDIRECT}}"),
        ),
    ];
    for (steps, message) in cases {
        let found = bench.refused(|bench| bench.submit(bench.bound(steps.iter().copied())));
        assert_eq!(found, message);
    }
    let found = bench.refused(|bench| bench.device.queue().read(indices, 0, 4, CAUSE));
    assert_eq!(found, format!("{only_index} {{COPY_SOURCE}}"));
    let copy = |source, destination| Command::Copy {
        source,
        source_offset: 0,
        destination,
        destination_offset: 0,
        size: 4,
    };
    let found = bench.refused(|bench| bench.submit(copy(indices, counter)));
    assert_eq!(found, format!("{only_index} {{COPY_SOURCE}}"));
    // Whatever would move bytes between host and device past the bus.
    let from_host = "\"host\" was created for host memory, but is used as";
    let found = bench.refused(|bench| bench.submit(copy(host, counter)));
    assert_eq!(found, format!("{from_host} the source of a copy"));
    let found = bench.refused(|bench| bench.submit(copy(vertices, host)));
    assert_eq!(found, format!("{from_host} the destination of a copy"));
    let clear = Command::Clear {
        buffer: host,
        offset: 0,
        size: 4,
    };
    let found = bench.refused(|bench| bench.submit(clear));
    assert_eq!(found, format!("{from_host} the target of a clear"));
    let region = Region {
        buffer: host,
        offset: 0,
        bytes: &[1],
        cause: CAUSE,
    };
    let found = bench.refused(|bench| bench.device.queue().write_regions(&[region]));
    assert_eq!(found, format!("{from_host} the target of a gathered write"));
    let steps = [Step::Program(pulled), storage(host), indexed];
    let found = bench.refused(|bench| bench.submit(bench.bound(steps)));
    assert_eq!(found, format!("{from_host} a storage buffer"));
}

#[test]
fn handles_that_name_nothing_are_refused() {
    let mut bench = Bench::new(0);
    // Handles of a device that holds more, and one that was freed.
    let mut other = Bench::new(0);
    let strange = other
        .device
        .create_buffer(&buffer_of("strange", 4, Residency::Device))
        .expect("memory suffices");
    let strange_program = [(); 3].map(|()| other.program(PUSHED))[2];
    let strange_texture = other
        .device
        .create_texture(&TextureDescriptor {
            label: "strange",
            format: TextureFormat::Srgb8,
            width: 1,
            height: 1,
            levels: 1,
        })
        .expect("memory suffices");
    let strange_target = other
        .device
        .create_target(&TargetDescriptor {
            label: "strange",
            width: 1,
            height: 1,
            samples: Samples::One,
        })
        .expect("memory suffices");
    let freed = bench.counter;
    bench.device.destroy_buffer(freed).expect("it lives");
    let pulled = bench.program(Layout {
        vertex_stride: 0,
        pulled_primitive_bytes: 0,
        pulled_vertex_bytes: 0,
        ..PUSHED
    });
    let counted = draw(Corners::Counted, 0, 4);
    for buffer in [strange, freed] {
        let missing = format!("buffer {} does not exist on this device", buffer.index());
        let copy = |source, destination| Command::Copy {
            source,
            source_offset: 0,
            destination,
            destination_offset: 0,
            size: 0,
        };
        let (vertices, indices) = (bench.vertices, bench.indices);
        let refused = [
            bench.refused(|bench| bench.device.queue().write(buffer, 0, &[], CAUSE)),
            bench.refused(|bench| bench.device.queue().read(buffer, 0, 0, CAUSE)),
            bench.refused(|bench| {
                let region = Region {
                    buffer,
                    offset: 0,
                    bytes: &[],
                    cause: CAUSE,
                };
                bench.device.queue().write_regions(&[region])
            }),
            bench.refused(|bench| bench.submit(copy(buffer, indices))),
            bench.refused(|bench| bench.submit(copy(vertices, buffer))),
            bench.refused(|bench| {
                bench.submit(Command::Clear {
                    buffer,
                    offset: 0,
                    size: 0,
                })
            }),
            bench.refused(|bench| bench.device.inspect_buffer(buffer).map(|_| ())),
            bench.refused(|bench| bench.device.poison(buffer, 0..0, 0)),
            bench.refused(|bench| bench.device.destroy_buffer(buffer)),
        ];
        assert!(
            refused.iter().all(|message| *message == missing),
            "{refused:?}"
        );
        // Also where the program that draws reads neither vertices nor indices.
        for step in [
            Step::Vertices(buffer),
            Step::Indices(buffer),
            Step::Storage { slot: 9, buffer },
            indirect(Corners::Counted, buffer, 0, 0),
            from_counter(Corners::Counted, buffer, 0, 4),
        ] {
            let steps = [Step::Program(pulled), step, counted];
            let found = bench.refused(|bench| bench.submit(bench.pass(steps)));
            assert_eq!(found, missing, "{step:?}");
        }
    }
    let missing = |what: &str, index: u32| format!("{what} {index} does not exist on this device");
    let found = bench.refused(|bench| bench.submit(bench.pass([Step::Program(strange_program)])));
    assert_eq!(found, missing("program", strange_program.index()));
    let texture = Step::Texture {
        slot: 0,
        texture: strange_texture,
    };
    let found = bench.refused(|bench| bench.submit(bench.bound([texture])));
    assert_eq!(found, missing("texture", strange_texture.index()));
    let found = bench.refused(|bench| {
        let queue = &mut bench.device.queue();
        queue.write_texture(strange_texture, 0, &[0; 4], CAUSE)
    });
    assert_eq!(found, missing("texture", strange_texture.index()));
    let texture = bench.texture;
    let found = bench.refused(|bench| bench.device.inspect_texture(texture, 2).map(|_| ()));
    assert_eq!(found, missing("mip level", 2));
    let found = bench.refused(|bench| bench.device.present(strange_target).map(|_| ()));
    assert_eq!(found, missing("target", strange_target.index()));
    let found = bench.refused(|bench| {
        let queue = &mut bench.device.queue();
        queue.read_target(strange_target, TargetLayer::Depth, CAUSE)
    });
    assert_eq!(found, missing("target", strange_target.index()));
    let found = bench.refused(|bench| {
        bench.submit(Command::Render(RenderPass {
            label: "nowhere".to_owned(),
            target: strange_target,
            load: Load::Keep,
            steps: Vec::new(),
        }))
    });
    assert_eq!(found, missing("target", strange_target.index()));
    let (vertices, texture) = (bench.vertices, bench.texture);
    for step in [
        Step::Storage {
            slot: 16,
            buffer: vertices,
        },
        Step::Texture { slot: 16, texture },
        Step::NoTexture { slot: 16 },
    ] {
        let found = bench.refused(|bench| bench.submit(bench.bound([step])));
        assert_eq!(found, missing("binding slot", 16));
    }
}

#[test]
fn draws_that_lack_something_or_do_not_fit_are_refused() {
    let mut bench = Bench::new(0);
    let (vertices, indices, arguments, texture) = (
        bench.vertices,
        bench.indices,
        bench.arguments,
        bench.texture,
    );
    let pushed = Step::Program(bench.pushed);
    let two_slots = Step::Program(bench.program(Layout {
        name: "two slots",
        storage_slots: 2,
        texture_slots: 2,
        ..PUSHED
    }));
    let lines = Step::Program(bench.program(Layout {
        name: "lines",
        topology: Topology::LineList,
        ..PUSHED
    }));
    let triangles = Step::Program(bench.program(Layout {
        name: "triangles",
        topology: Topology::TriangleList,
        ..PUSHED
    }));
    let record = |corner_count, instances| IndirectRecord {
        corner_count,
        instances,
        first_corner: 0,
        instance: 0,
    };
    let bytes = [record(4, 1).to_bytes(), record(4, 2).to_bytes()].concat();
    let written = bench.device.queue().write(arguments, 0, &bytes, CAUSE);
    written.expect("within the buffer");
    let counted = draw(Corners::Counted, 0, 4);
    let with_vertices = Step::Vertices(vertices);
    let storage = |slot| Step::Storage {
        slot,
        buffer: vertices,
    };
    let picture = |slot| Step::Texture { slot, texture };
    let cases: [(&[Step], &str); 12] = [
        (
            &[with_vertices, counted],
            "program \"\" draws without program 0",
        ),
        (
            &[pushed, counted],
            "program \"pushed\" draws without vertex buffer 0",
        ),
        (
            &[pushed, with_vertices, draw(Corners::Indexed, 0, 4)],
            "program \"pushed\" draws without index buffer 0",
        ),
        (
            &[
                two_slots,
                with_vertices,
                storage(0),
                picture(0),
                picture(1),
                counted,
            ],
            "program \"two slots\" draws without storage buffer 1",
        ),
        (
            &[
                two_slots,
                with_vertices,
                storage(0),
                storage(1),
                picture(1),
                counted,
            ],
            "program \"two slots\" draws without texture 0",
        ),
        (
            &[
                two_slots,
                with_vertices,
                storage(0),
                storage(1),
                picture(0),
                picture(1),
                Step::NoTexture { slot: 1 },
                counted,
            ],
            "program \"two slots\" draws without texture 1",
        ),
        (
            &[pushed, with_vertices, draw(Corners::Counted, 0, 6)],
            "a draw of program \"pushed\" has 6 corners, not a multiple of 4",
        ),
        (
            &[triangles, with_vertices, draw(Corners::Counted, 0, 4)],
            "a draw of program \"triangles\" has 4 corners, not a multiple of 3",
        ),
        (
            &[lines, with_vertices, draw(Corners::Counted, 0, 3)],
            "a draw of program \"lines\" has 3 corners, not a multiple of 2",
        ),
        // The second record is wrong: the first is not drawn either.
        (
            &[
                pushed,
                with_vertices,
                indirect(Corners::Counted, arguments, 0, 2),
            ],
            "2 instances is not supported by this version",
        ),
        (
            &[
                pushed,
                with_vertices,
                Step::Indices(indices),
                draw(Corners::Indexed, 0, 4),
                draw(Corners::Counted, 0, 5),
            ],
            "a draw of program \"pushed\" has 5 corners, not a multiple of 4",
        ),
        (
            &[
                pushed,
                with_vertices,
                from_counter(Corners::Counted, bench.counter, 0, 7),
            ],
            "a draw of program \"pushed\" has 7 corners, not a multiple of 4",
        ),
    ];
    for (steps, message) in cases {
        let found = bench.refused(|bench| bench.submit(bench.pass(steps.iter().copied())));
        assert_eq!(found, message);
    }
}

#[test]
fn commands_before_a_refused_one_stand() {
    let mut bench = Bench::new(0);
    bench.device.take_ledger();
    let clear = |size| Command::Clear {
        buffer: bench.vertices,
        offset: 0,
        size,
    };
    let commands = [clear(8), clear(VERTEX_BYTES + 1), clear(16)];
    assert!(bench.device.queue().submit(&commands).is_err());
    assert_eq!(bench.device.take_ledger().command_bytes, 24);
    let bytes = bench
        .device
        .inspect_buffer(bench.vertices)
        .expect("it lives");
    assert!(bytes[..8].iter().all(|&byte| byte == 0) && bytes[8..16].iter().any(|&b| b != 0));
}
