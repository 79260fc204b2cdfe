//! Compute passes: groups own what they write, so nothing shows how many threads ran them.

use spinney::gpu::{
    Access, Card, ComputeLayout, ComputePass, ComputeProgram, ComputeStep, DispatchWork, Group,
};

use super::*;

/// Owned word `i` of a group becomes itself plus the sum of the first words of the input, as many
/// as the word's place in the buffer says.
#[derive(Debug)]
struct Prefix(ComputeLayout);

const PREFIX: ComputeLayout = ComputeLayout {
    name: "prefix",
    version: 1,
    slots: &[Access::Read, Access::Own { group_bytes: 12 }],
    group_operations: 100,
};

impl ComputeProgram for Prefix {
    fn layout(&self) -> ComputeLayout {
        self.0
    }

    fn run(&self, group: &mut Group<'_>) {
        for word in 0..group.len(1) {
            let place = 3 * group.number() as usize + word;
            let mut sum = group.u32(1, word);
            for index in 0..place {
                sum = sum.wrapping_add(group.u32(0, index));
            }
            group.set(1, word, sum);
            // Past what it owns: dropped.
            group.set(1, word + 3, 0);
            group.set(0, word, 0);
        }
    }
}

/// A device with an input of `words` words and an output of as many; both filled.
fn device(words: u32, card: &str) -> (Device, [BufferId; 2]) {
    let mut device = Device::new(DeviceDescriptor {
        card: Card::named(card).expect("a known card"),
        raster: Options {
            tile: TileSize::Side32,
            counters: Counters::Exact,
        },
        ..descriptor()
    });
    device.record();
    let mut buffer = |label, first: u32| {
        let bytes = super::words((first..).take(words as usize));
        let size = bytes.len() as u64;
        let id = device
            .create_buffer(&buffer_of(label, size, Residency::Device))
            .expect("memory suffices");
        let written = device.queue().write(id, 0, &bytes, CAUSE);
        written.expect("within the buffer");
        id
    };
    let buffers = [buffer("input", 5), buffer("output", 1000)];
    (device, buffers)
}

fn pass(steps: &[ComputeStep]) -> Command {
    Command::Compute(ComputePass {
        label: "test".to_owned(),
        steps: steps.to_vec(),
    })
}

fn bound(device: &mut Device, buffers: [BufferId; 2], groups: u32) -> Vec<ComputeStep> {
    let program = device.create_compute_program(Arc::new(Prefix(PREFIX)));
    vec![
        ComputeStep::Program(program.expect("this card computes")),
        ComputeStep::Storage {
            slot: 0,
            buffer: buffers[0],
        },
        ComputeStep::Storage {
            slot: 1,
            buffer: buffers[1],
        },
        ComputeStep::Dispatch { groups },
    ]
}

#[test]
fn any_number_of_threads_computes_the_same_and_counts_the_same() {
    let words = 100;
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("a pool").install(|| {
            let (mut device, buffers) = device(words, "gtx770");
            // 33 groups own three words, the last one.
            let steps = bound(&mut device, buffers, 34);
            device.take_ledger();
            let twice = [&steps[..], &steps[3..]].concat();
            let submitted = device.queue().submit(&[pass(&twice)]);
            submitted.expect("a sound pass");
            let held = device.inspect_buffer(buffers[1]).expect("it lives");
            let held = held.to_vec();
            let ledger = device.take_ledger();
            check_conservation(&device, 8 * u64::from(words)).expect("computed bytes are recorded");
            (held, ledger)
        })
    };
    let (held, ledger) = run(1);
    let sum = |place: u32| (0..place).map(|index| index + 5).sum::<u32>();
    let wanted = super::words((0..words).map(|place| 1000 + place + 2 * sum(place)));
    assert_eq!(held, wanted);
    // Two dispatches of 34 groups: for each word, itself and what stands before it, then three
    // writes, of which two are dropped.
    let words = u64::from(words);
    let bytes = 2 * 4 * (words * (words - 1) / 2 + 4 * words);
    let compute = ledger.compute;
    assert_eq!((compute.dispatches, compute.groups), (2, 68));
    assert_eq!(compute.bytes, bytes);
    assert_eq!(ledger.command_bytes, 8 + 2 * 8 + 2 * 16);
    assert!(ledger.transfers.is_empty(), "nothing crosses the bus");
    let card = Card::named("gtx770").expect("a known card");
    let operations = 34 * 100;
    let one = DispatchWork {
        operations,
        bytes: bytes / 2,
    };
    assert_eq!(ledger.gpu_ticks, Some(2 * card.dispatch_ticks(&one)));
    for threads in [2, 7] {
        assert!(run(threads) == (held.clone(), ledger.clone()), "{threads}");
    }
}

/// A word a pixel of a target of four columns: its depth.
#[derive(Debug)]
struct Depths;

impl ComputeProgram for Depths {
    fn layout(&self) -> ComputeLayout {
        ComputeLayout {
            name: "depths",
            slots: &[Access::Depth, Access::Own { group_bytes: 16 }],
            ..PREFIX
        }
    }

    fn run(&self, group: &mut Group<'_>) {
        assert_eq!(group.size(0), [4, 2], "of the target");
        assert_eq!(group.size(1), [0, 0], "a buffer has no columns");
        assert_eq!(group.len(0), 0, "and a depth no words");
        for x in 0..4 {
            let depth = group.farthest_depth(0, [x, group.number()]);
            group.set(1, x as usize, depth.to_bits());
        }
    }
}

#[test]
fn the_depth_of_a_target_is_read_and_counted_sample_by_sample() {
    for (samples, bytes) in [(Samples::One, 4), (Samples::Four, 16)] {
        let (mut device, buffers) = device(12, "gtx770");
        let target = device.create_target(&TargetDescriptor {
            label: "depths",
            width: 4,
            height: 2,
            samples,
        });
        let target = target.expect("memory suffices");
        let clear = RenderPass {
            label: "clear".to_owned(),
            target,
            load: Load::Clear {
                color: Vec4::ZERO,
                depth: 0.625,
            },
            steps: Vec::new(),
        };
        let program = device.create_compute_program(Arc::new(Depths));
        let buffer = |slot, buffer| ComputeStep::Storage { slot, buffer };
        let depth = |slot| ComputeStep::Depth { slot, target };
        let program = ComputeStep::Program(program.expect("this card computes"));
        let dispatch = ComputeStep::Dispatch { groups: 3 };
        device.take_ledger();
        let read = [program, depth(0), buffer(1, buffers[1]), dispatch];
        let submitted = device
            .queue()
            .submit(&[Command::Render(clear), pass(&read)]);
        submitted.expect("a sound pass");
        let held = device.inspect_buffer(buffers[1]).expect("it lives");
        let wanted = [[0.625_f32; 8].as_slice(), &[0.0; 4]].concat();
        let wanted = words(wanted.into_iter().map(f32::to_bits));
        assert_eq!(held, wanted, "beside the target nothing is far");
        let ledger = device.take_ledger();
        assert_eq!(ledger.compute.bytes, 8 * bytes + 12 * 4);
        assert_eq!(ledger.command_bytes, 24 + 3 * 8 + 16);
        let tallied = device.queue().tally(&[pass(&read)]);
        assert!(matches!(tallied, Err(GpuError::Unsupported { .. })));
        // A buffer is no depth, and a depth is no buffer.
        let mut refused = |steps: &[ComputeStep]| {
            let error = device.queue().submit(&[pass(steps)]);
            error.expect_err("this must be refused").to_string()
        };
        assert_eq!(
            refused(&[
                program,
                buffer(0, buffers[0]),
                buffer(1, buffers[1]),
                dispatch
            ]),
            "program \"depths\" draws without depth 0"
        );
        assert_eq!(
            refused(&[program, depth(0), depth(1), dispatch]),
            "program \"depths\" draws without storage buffer 1"
        );
    }
}

/// How many bytes were read, which are the first of the buffer.
fn first_bytes(device: &Device, buffer: BufferId) -> u64 {
    let reads = device.reads().expect("tracked");
    let mut ranges = reads.ranges(buffer).into_iter();
    let first = ranges.next().expect("something is read");
    assert!(first.start == 0 && ranges.next().is_none(), "one range");
    first.end
}

#[test]
fn what_was_written_before_it_is_read_is_no_input() {
    let (mut device, buffers) = device(9, "gtx770");
    let steps = bound(&mut device, buffers, 2);
    device.track_reads();
    let submitted = device.queue().submit(&[pass(&steps), pass(&steps)]);
    submitted.expect("a sound pass");
    // Words before the sixth are summed; each group reads its own three before it writes them.
    assert_eq!(first_bytes(&device, buffers[0]), 20);
    assert_eq!(first_bytes(&device, buffers[1]), 24);
    // The other way round: what the first pass writes, the second reads.
    device.track_reads();
    let back = [
        ComputeStep::Storage {
            slot: 0,
            buffer: buffers[1],
        },
        ComputeStep::Storage {
            slot: 1,
            buffer: buffers[0],
        },
    ];
    let back = [&steps[..1], &back[..], &steps[3..]].concat();
    let submitted = device.queue().submit(&[pass(&steps), pass(&back)]);
    submitted.expect("a sound pass");
    assert_eq!(first_bytes(&device, buffers[1]), 24);
    assert_eq!(first_bytes(&device, buffers[0]), 24);
}

#[test]
fn what_groups_cannot_own_is_refused_whole() {
    let (mut device, buffers) = device(9, "gtx770");
    let steps = bound(&mut device, buffers, 3);
    let mut refused = |steps: &[ComputeStep]| {
        let held = device
            .inspect_buffer(buffers[1])
            .expect("it lives")
            .to_vec();
        device.take_ledger();
        let error = device.queue().submit(&[pass(steps)]);
        let ledger = device.take_ledger();
        assert_eq!((ledger.compute, ledger.command_bytes), Default::default());
        assert!(held == device.inspect_buffer(buffers[1]).expect("it lives"));
        error.expect_err("this must be refused").to_string()
    };
    let dispatch = |groups| ComputeStep::Dispatch { groups };
    // A sound dispatch before the refused one does not run either.
    let too_many = [&steps[..], &[dispatch(4)]].concat();
    assert_eq!(
        refused(&too_many),
        "\"output\" holds 36 bytes, dispatch wants 36..40"
    );
    let aliased = ComputeStep::Storage {
        slot: 0,
        buffer: buffers[1],
    };
    assert_eq!(
        refused(&[&steps[..3], &[aliased, dispatch(1)]].concat()),
        "\"output\" was created for one slot of a dispatch that writes it, but is used as another"
    );
    assert_eq!(
        refused(&[steps[0], steps[1], dispatch(1)]),
        "program \"prefix\" draws without storage buffer 1"
    );
    assert_eq!(
        refused(&[steps[1], dispatch(1)]),
        "program \"\" draws without compute program 0"
    );
    let layout = ComputeLayout {
        slots: &[Access::Read],
        ..PREFIX
    };
    let error = device.create_compute_program(Arc::new(Prefix(layout)));
    assert_eq!(
        error.expect_err("writes nothing").to_string(),
        "\"prefix\": number of slots that it writes is 0, wanted at least 1"
    );
}

#[test]
fn cards_of_2004_name_those_that_compute() {
    let (mut device, _) = device(1, "geforce6800");
    let error = device.create_compute_program(Arc::new(Prefix(PREFIX)));
    assert_eq!(
        error.expect_err("no compute passes").to_string(),
        "card \"geforce6800\" runs no compute passes; these do: \"gtx770\""
    );
}
