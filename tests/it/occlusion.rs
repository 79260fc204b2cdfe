//! What is hidden is left out and nothing shows it: whatever was seen before, however near depths are.
//! Instances of a species are selected and drawn together.

use std::sync::Arc;

use spinney::gpu::{BufferId, Device, Ledger, Load, RenderPass, TargetDescriptor, TargetId};
use spinney::math::{Draws, Quat, Stream, Vec3, Vec4, index_u32, index_usize};
use spinney::models::{
    Crown, Environment, Kind, ModelOptions, Occlusion, Placement, Resident, State, View,
    frame_commands,
};
use spinney::plant::{Foliage, LeafGroup, Material, NO_BRANCH, Plant, Prototype};
use spinney::raster::{Image, Key, Samples};
use spinney::run::{Session, SessionOptions};
use spinney::scene::{self, Mode};

use crate::support::{Cases, OPTIONS, Stage, birch_scene, birches, random_sequence};

const TWO_PHASE: ModelOptions = ModelOptions {
    occlusion: Occlusion::TwoPhase,
    ..OPTIONS
};

/// A crown of squares that face +z, each a cluster of its own: centre and half a side.
fn squares(squares: &[(Vec3, f32)]) -> Arc<Crown> {
    let (green, brown) = squares.split_at(squares.len() / 2);
    let group = |squares: &[(Vec3, f32)], base_color| LeafGroup {
        name: "squares".to_owned(),
        prototype: Prototype::Quad {
            texture_corners: Prototype::WHOLE_IMAGE,
        },
        material: Material {
            name: "square".to_owned(),
            base_color,
            texture: None,
            alpha_cutoff: 0.5,
        },
        positions: squares
            .iter()
            .flat_map(|&(centre, half)| {
                let corner = |x: f32, y: f32| centre + half * Vec3::new(x, y, 0.0);
                [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| corner(x, y))
            })
            .collect(),
        owners: vec![NO_BRANCH; squares.len()],
    };
    let groups = vec![
        group(green, [0.2, 0.8, 0.1, 1.0]),
        group(brown, [0.9, 0.5, 0.1, 1.0]),
    ];
    let plant = Plant::new("squares", None, None, Foliage { groups }).expect("sound parts");
    let (leaves, split) = (index_u32(squares.len()), index_u32(green.len()));
    let sequence = random_sequence(1, leaves, split, leaves);
    Arc::new(Crown::new(Arc::new(plant), sequence))
}

/// A device with several instances of a crown.
struct Grove {
    device: Device,
    environment: Environment,
    residents: Vec<Box<dyn Resident>>,
    target: TargetId,
}

impl Grove {
    fn new(
        crown: &Arc<Crown>,
        options: ModelOptions,
        placements: &[Placement],
        rooms: u32,
        samples: Samples,
    ) -> Self {
        let mut device = Device::new(Stage::descriptor());
        let target = device.create_target(&TargetDescriptor {
            label: "frame",
            // Neither a whole number of blocks, nor of any cells.
            width: 101,
            height: 75,
            samples,
        });
        let target = target.expect("memory suffices");
        let instances = index_u32(placements.len());
        let environment = Environment::of_kind(&mut device, instances, Kind::LodfDevice);
        let mut environment = environment.expect("this card computes").with_rooms(rooms);
        let occluded = environment.occlude(&mut device, target);
        occluded.expect("memory suffices");
        let model = Kind::LodfDevice.model(crown, options);
        let shared = model.upload(&mut device, &environment).expect("it fits");
        let residents = (0..).zip(placements).map(|(number, placement)| {
            let placed = environment.place(&mut device.queue(), number, placement);
            placed.expect("there is room");
            let resident = shared.instance(&mut device, &State::FINEST, number);
            resident.expect("memory suffices")
        });
        Self {
            residents: residents.collect(),
            device,
            environment,
            target,
        }
    }

    fn draw(&mut self, view: &View) -> (Image, Ledger) {
        let sent = self.environment.set_view(&mut self.device.queue(), view);
        sent.expect("our own device");
        let mut steps = Vec::new();
        for resident in &self.residents {
            resident.draw(&mut steps);
        }
        let pass = RenderPass {
            label: "test".to_owned(),
            target: self.target,
            load: Load::Clear {
                color: Vec4::new(0.1, 0.1, 0.2, 1.0),
                depth: 1.0,
            },
            steps,
        };
        let residents = self.residents.iter().map(|resident| &**resident);
        let commands = frame_commands(&self.environment, pass, Vec::new(), residents);
        self.device.take_ledger();
        let submitted = self.device.queue().submit(&commands);
        submitted.expect("sound commands");
        let image = self.device.present(self.target).expect("it lives");
        (image, self.device.take_ledger())
    }

    /// Lets the device believe that these clusters were seen, and no others.
    fn remember(&mut self, mut seen: impl FnMut(usize) -> bool) {
        let buffers = self.device.buffers();
        let found = buffers.filter(|(_, label)| *label == "seen clusters");
        let found: Vec<BufferId> = found.map(|(id, _)| id).collect();
        for id in found {
            let words = self.device.inspect_buffer(id).expect("it lives").len() / 4;
            for word in 0..words {
                let range = 4 * word as u64..4 * word as u64 + 4;
                let filler = if seen(word) { 0xa5 } else { 0 };
                let poisoned = self.device.poison(id, range, filler);
                poisoned.expect("within the buffer");
            }
        }
    }

    fn key(&self, pixel: [u32; 2]) -> Option<Key> {
        let key = self.device.key(self.target, pixel[0], pixel[1]);
        key.expect("it lives")
    }
}

/// Draws with a cluster in them.
fn drawn(ledger: &Ledger) -> u64 {
    ledger.draws - ledger.empty_draws
}

/// A viewer among the squares: some behind it, some through its near plane, some beside the target.
fn among(draws: &mut Draws) -> View {
    let near = 0.05 + 0.2 * draws.unit();
    let perspective = glam::camera::rh::proj::directx::perspective(1.0, 1.3, near, 50.0);
    let eye = Vec3::new(draws.signed(), draws.signed(), 3.0 * draws.unit());
    let aside = 0.2 * Vec3::new(draws.signed(), draws.signed(), 0.0);
    let direction = (Vec3::NEG_Z + aside).normalize_or(Vec3::NEG_Z);
    View {
        clip_from_world: perspective
            * glam::camera::rh::view::look_to_mat4(eye, direction, Vec3::Y),
        to_light: Vec3::Z,
        light: Vec3::ONE,
        ambient: Vec3::splat(0.2),
    }
}

#[test]
fn nothing_shows_what_is_left_out() {
    let count = Cases::of(concat!(module_path!(), "::nothing_shows_what_is_left_out"));
    let (mut hidden, mut late) = (0, 0);
    for seed in 0..160 {
        count.one();
        let mut draws = Stream::new(seed, 21).draws();
        // Large ones hide; depths are equal, or nearly, or far from one another.
        let spread = [0.0, 1.0e-6, 1.0e-3, 1.0][index_usize(seed % 4)];
        let mut square = |number: u64| {
            let centre = Vec3::new(draws.signed(), draws.signed(), spread * draws.signed());
            let half = if number.is_multiple_of(3) {
                2.5
            } else {
                0.3 * draws.unit()
            };
            (centre, half)
        };
        let crown = squares(&(0..18).map(&mut square).collect::<Vec<_>>());
        let mut placement = || Placement {
            position: spread * Vec3::new(draws.signed(), draws.signed(), 2.0 * draws.signed()),
            rotation: Quat::IDENTITY,
            scale: 1.0,
        };
        let placements = [placement(), placement(), placement()];
        let samples = [Samples::One, Samples::Four][index_usize(seed / 4 % 2)];
        let rooms = index_u32(index_usize(1 + seed % 3));
        let grove = |options| Grove::new(&crown, options, &placements, rooms, samples);
        let (mut whole, mut occluded) = (grove(OPTIONS), grove(TWO_PHASE));
        for _ in 0..3 {
            let view = among(&mut draws);
            let (wanted, all) = whole.draw(&view);
            occluded.remember(|_| draws.below(2) == 0);
            let (found, first) = occluded.draw(&view);
            assert!(wanted == found, "seed {seed}, whatever was seen");
            let (found, second) = occluded.draw(&view);
            assert!(wanted == found, "seed {seed}, what was just seen");
            assert!(drawn(&second) <= drawn(&all), "each at most once");
            hidden += drawn(&all) - drawn(&second);
            late += u64::from(drawn(&first) > drawn(&second));
        }
    }
    assert!(hidden > 2000, "only {hidden} clusters were hidden");
    assert!(late > 100, "memory hardly mattered: {late}");
}

/// Where two trees stand in the same place, the first shows, whichever pass draws it.
#[test]
fn at_equal_depth_the_least_key_shows() {
    let crown = squares(&[(Vec3::ZERO, 2.0), (Vec3::new(0.0, 0.0, -1.0), 2.0)]);
    let placements = [Placement::IDENTITY; 2];
    let mut grove = Grove::new(&crown, TWO_PHASE, &placements, 2, Samples::One);
    let view = View {
        clip_from_world: glam::camera::rh::proj::directx::perspective(1.0, 1.3, 0.1, 50.0)
            * glam::camera::rh::view::look_to_mat4(Vec3::Z, Vec3::NEG_Z, Vec3::Y),
        to_light: Vec3::Z,
        light: Vec3::ONE,
        ambient: Vec3::ZERO,
    };
    for first in [[0, 1], [1, 0]] {
        grove.remember(|word| first[word / 2] == 0);
        let (_, ledger) = grove.draw(&view);
        let key = grove.key([50, 40]).expect("a square shows there");
        assert_eq!((key.instance, key.vertex), (0, 0));
        // In front two, of which one was drawn first with the one behind it; the other two are hidden
        // or equal: only the one behind is left out.
        assert_eq!((ledger.draws, drawn(&ledger)), (8, 3));
    }
    let (_, ledger) = grove.draw(&view);
    assert_eq!(drawn(&ledger), 2, "what was hidden is not drawn again");
}

/// What a frame asks of the host and the command stream is the same for any number of instances.
#[test]
fn instances_of_a_species_are_selected_and_drawn_together() {
    let crown = squares(&[(Vec3::ZERO, 0.5), (Vec3::Z, 0.5), (Vec3::X, 0.25)]);
    let view = among(&mut Stream::new(7, 22).draws());
    let placement = |number: u32| Placement {
        position: Vec3::new(number as f32 / 40.0, 0.0, -1.0),
        ..Placement::IDENTITY
    };
    let frame = |options, trees: u32, rooms| {
        let placements: Vec<Placement> = (0..trees).map(placement).collect();
        let mut grove = Grove::new(&crown, options, &placements, rooms, Samples::One);
        let (image, ledger) = grove.draw(&view);
        let compute = ledger.compute.dispatches;
        (
            image.digest(),
            [compute, ledger.command_bytes, ledger.upload.payload_bytes],
        )
    };
    for (options, dispatches) in [(OPTIONS, 1), (TWO_PHASE, 3)] {
        let (_, one) = frame(options, 1, 1);
        let (picture, together) = frame(options, 30, 30);
        assert_eq!(together, one);
        assert_eq!(one[0], dispatches);
        // Rooms for four at a time: eight times as much.
        let (same, apart) = frame(options, 30, 4);
        assert_eq!(apart[0], 8 + (dispatches - 1) / 2 * 9);
        assert!(same == picture && apart[1] > together[1]);
    }
}

/// A walk away from two trees, one partly behind the other.
#[test]
fn a_walk_looks_the_same_and_draws_less() {
    let mut scene = birch_scene();
    scene.model.mode = Mode::Device;
    let walk = |occlusion| {
        let mut scene = scene.clone();
        scene.model.occlusion = occlusion;
        let options = SessionOptions::exact(&scene).expect("known names");
        let mut session = Session::new(&scene, birches(), &options).expect("memory suffices");
        let frames = (0..scene.frames).map(|frame| session.frame(frame).expect("our own device"));
        let frames: Vec<_> = frames.collect();
        let pictures: Vec<_> = frames.iter().map(|frame| frame.image_digest).collect();
        let states: Vec<_> = frames.iter().map(|frame| frame.states.clone()).collect();
        let vertices = frames.iter().map(|frame| frame.ledger.vertices).collect();
        (pictures, states, vertices)
    };
    let (pictures, states, all): (_, _, Vec<u64>) = walk(scene::Occlusion::None);
    let (same, same_states, fewer): (_, _, Vec<u64>) = walk(scene::Occlusion::TwoPhase);
    assert_eq!(pictures, same);
    assert_eq!(states, same_states);
    // At rest nothing is drawn for having been seen from elsewhere.
    assert!(fewer[5] <= all[5], "{fewer:?} of {all:?}");
}
