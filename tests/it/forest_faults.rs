//! Faults of forests, each of which one [law](crate::forest_laws) must catch.

use spinney::models::{Kind, TreeState, TrunkKind};
use spinney::scene::{TrunkMode, TrunkName};
use spinney::testkit::laws::{conservation, image_equality, residency};
use spinney::testkit::{
    Change, Counted, DeviceModel, ForestStage, Law, Picture, Reads, Resource, Tally,
};

use crate::forest_laws::{
    FINEST, Models, TREES, catches_up, dearest, frame_within, partitions, scene, scene_of, vector,
    wanted, world,
};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Fault {
    /// Two trees of one species get each other's states.
    Exchanged,
    /// The last tree's trunk stays as it is.
    TrunkForgotten,
    /// A byte of the last tree's changes behind the bus's back.
    BehindTheBus,
    /// The last transfer is not counted.
    NotCounted,
    /// Reads of vertices of leaves are not told, as if nothing there mattered.
    Unread,
}

struct Faulty<'w> {
    inner: ForestStage<'w>,
    fault: Fault,
}

impl DeviceModel<Vec<TreeState>> for Faulty<'_> {
    fn commit(&mut self, to: &Vec<TreeState>) {
        let mut states = to.clone();
        match self.fault {
            Fault::Exchanged => states.swap(0, 2),
            Fault::TrunkForgotten => {
                let stands = self.inner.session().states();
                states[TREES - 1].trunk = stands[TREES - 1].trunk;
            }
            _ => {}
        }
        self.inner.commit(&states);
        if self.fault == Fault::BehindTheBus {
            let resources = self.inner.resources();
            let of_trees = |held: &Resource<'_>| held.name == "leaf records";
            let last = resources.iter().rposition(of_trees);
            let last = last.expect("slots keep records");
            let byte = !resources[last].bytes[5];
            self.inner.overwrite(last, 5, &[byte]);
        }
    }

    fn resources(&self) -> Vec<Resource<'_>> {
        self.inner.resources()
    }

    fn reads(&mut self) -> Reads {
        let mut reads = self.inner.reads();
        if self.fault == Fault::Unread {
            let resources = self.inner.resources();
            let ranges = reads.ranges.iter_mut();
            for (_, range) in
                ranges.filter(|(number, _)| resources[*number].name == "leaf vertices")
            {
                *range = 0..0;
            }
        }
        reads
    }

    fn overwrite(&mut self, resource: usize, at: usize, bytes: &[u8]) {
        self.inner.overwrite(resource, at, bytes);
    }

    fn log(&self) -> Option<Vec<Change<'_>>> {
        self.inner.log()
    }

    fn counted(&mut self) -> Option<Counted> {
        let mut counted = self.inner.counted()?;
        counted.transfers -= u64::from(self.fault == Fault::NotCounted);
        Some(counted)
    }

    fn picture(&mut self) -> Option<Picture> {
        self.inner.picture()
    }
}

/// Of twenty forests that go from full detail to random states, how many break the law that is
/// there for a fault.
fn caught(fault: Option<Fault>, law: Law) -> u32 {
    let mut caught = 0;
    for seed in 0..20 {
        let models = Models {
            kind: Kind::LodfSlots,
            trunk: TrunkKind {
                name: TrunkName::LodStripsCut,
                mode: TrunkMode::Device,
            },
            seed,
        };
        let (scene, world) = (scene(), world(seed));
        let place = (&scene, &world);
        let to = vector(&world, [1, 2, 3, 4].map(|tree| 100 * seed + tree));
        let faulty = |states: &[TreeState]| -> Box<dyn DeviceModel<Vec<TreeState>> + '_> {
            let inner = models.anew(place, states, 0);
            match fault {
                Some(fault) => Box::new(Faulty { inner, fault }),
                None => Box::new(inner),
            }
        };
        let mut walked = faulty(&FINEST);
        walked.commit(&to);
        let mut fresh = models.anew(place, &to, 0);
        let broken = match law {
            Law::Residency => residency(&mut *walked, &mut fresh),
            Law::Conservation => conservation(&mut *walked),
            _ => image_equality(&mut fresh, &mut *faulty(&to), None),
        };
        caught += u32::from(broken.is_err());
    }
    caught
}

#[test]
fn each_fault_is_caught_by_its_law() {
    for (fault, law, least) in [
        (Fault::Exchanged, Law::Residency, 18),
        (Fault::TrunkForgotten, Law::Residency, 18),
        (Fault::BehindTheBus, Law::Conservation, 20),
        (Fault::NotCounted, Law::Conservation, 20),
        (Fault::Unread, Law::ImageEquality, 15),
    ] {
        assert_eq!(caught(None, law), 0, "{law} of sound forests");
        let found = caught(Some(fault), law);
        assert!(found >= least, "{fault:?}: {found} of 20 by {law}");
    }
}

/// The papers' list, in one tree of four.
#[test]
fn partition_catches_one_tree_that_shows_wrong_leaves() {
    let mut wrong = 0;
    for seed in 0..60 {
        let world = world(seed);
        let states = vector(&world, [1, 2, 3, 4].map(|tree| 100 * seed + tree));
        let mut tally = Tally::default();
        assert!(partitions(Kind::LodfSlots, &world, &states, &mut tally).is_ok());
        wrong += u32::from(partitions(Kind::LodfLiteral, &world, &states, &mut tally).is_err());
    }
    assert!(wrong > 10, "only {wrong} vectors were caught");
}

/// A session that knows of no budget, or of one in which nothing fits.
#[test]
fn budgets_that_are_not_kept_and_walks_that_never_end_are_seen() {
    let (mut exceeded, mut stuck) = (0, 0);
    for seed in 0..20 {
        let models = Models {
            kind: Kind::LodfCluster,
            trunk: TrunkKind::FULL,
            seed,
        };
        let world = world(seed);
        let [from, to] = [0, 4].map(|frame| wanted(models, &world, frame));
        let budget = dearest(models, &world, &from, &to);
        let scene = scene_of(seed, None);
        let mut careless = models.anew((&scene, &world), &from, 0);
        exceeded += u32::from(frame_within(budget, &mut careless, 4).is_none());
        let scene = scene_of(seed, Some(3));
        let mut starved = models.anew((&scene, &world), &from, 0);
        stuck += u32::from(!catches_up(&mut starved, 3, 4));
    }
    assert!(exceeded >= 15 && stuck >= 15, "{exceeded}, {stuck}");
}
