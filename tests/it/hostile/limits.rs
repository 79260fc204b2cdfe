//! Limits, each just met and just exceeded; those of small things stand beside what they limit.

use std::path::Path;

use spinney::document::{Document, ReadError, read_file};
use spinney::gpu::{
    BufferDescriptor, Card, Device, DeviceDescriptor, GpuError, Link, Residency, Usage,
};
use spinney::limits;
use spinney::plant::import::{ImportOptions, import, import_bytes};
use spinney::plant::{Foliage, LeafGroup, Material, Plant, Prototype, Species};
use spinney::raster::{Counters, Options, TileSize};
use spinney::report::Picture;
use spinney::run::{RunError, Silent, World};
use spinney::scene::{Scene, SceneFile};

use super::{SCENE, SPECIES, folder, refused};

/// A file of so many zeros that takes no room on the disk.
fn zeros(path: &Path, bytes: u64) {
    let file = std::fs::File::create(path).expect("writable");
    file.set_len(bytes).expect("a sparse file");
}

#[test]
fn files_are_read_up_to_their_limit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    zeros(&path, 8);
    assert_eq!(read_file(&path, 8).unwrap().len(), 8);
    let error = read_file(&path, 7).unwrap_err();
    assert_eq!(error, ReadError::TooLarge { found: 8, limit: 7 });
    assert_eq!(error.to_string(), "8 bytes exceed the limit of 7");
    let exceed = |limit: u64| format!("{} bytes exceed the limit of {limit}", limit + 1);
    zeros(&path, limits::TEXT_BYTES);
    assert!(Document::read(&path).is_ok());
    zeros(&path, limits::TEXT_BYTES + 1);
    let said = Document::read(&path).unwrap_err().to_string();
    assert!(said.ends_with(&exceed(limits::TEXT_BYTES)), "{said}");
    zeros(&path, limits::PICTURE_FILE_BYTES + 1);
    let said = Picture::read(&path).unwrap_err().to_string();
    assert!(
        said.ends_with(&exceed(limits::PICTURE_FILE_BYTES)),
        "{said}"
    );
    zeros(&path, limits::PLANT_FILE_BYTES + 1);
    let said = import(&path, &ImportOptions::default()).unwrap_err();
    assert!(
        said.to_string().contains(&exceed(limits::PLANT_FILE_BYTES)),
        "{said}"
    );
    // What the system makes up as it is read says that it has no bytes.
    if let Ok(bytes) = read_file(Path::new("/proc/self/maps"), 1 << 20) {
        assert!(!bytes.is_empty());
        assert!(read_file(Path::new("/proc/self/maps"), 16).is_err());
    }
}

fn scene(text: &str) -> Result<Scene, String> {
    let document = Document {
        file: "a.toml".to_owned(),
        text: text.to_owned(),
    };
    let file = SceneFile::parse(document);
    file.map(|file| file.scene)
        .map_err(|error| error.to_string())
}

fn species(text: &str) -> Result<Species, String> {
    let document = Document {
        file: "a.toml".to_owned(),
        text: text.to_owned(),
    };
    Species::parse(&document).map_err(|error| error.to_string())
}

#[test]
fn counts_of_a_scene_are_limited() {
    let trees = |count: usize| {
        let tree = "{ species = \"shrub.toml\" }";
        SCENE.replace(tree, &vec![tree; count].join(","))
    };
    let frames = |count: u32| SCENE.replace("frames = 6", &format!("frames = {count}"));
    let keys = |count: usize| {
        let key = |frame| format!("{{ frame = {frame}, eye = [0, 1, 5], target = [0, 1, 0] }}");
        let keys: Vec<String> = (0..count).map(key).collect();
        format!(
            "schema = \"spinney.scene/1\"\ntree = [{{ species = \"a.toml\" }}]\n[camera]\n\
             path = [{}]\n",
            keys.join(",")
        )
    };
    let names = |count: usize| {
        let tree = format!(
            "{{ file = \"a.glb\", foliage = [{}] }}",
            vec!["\"a\""; count].join(",")
        );
        SCENE.replace("{ species = \"shrub.toml\" }", &tree)
    };
    let path = |count: usize| SCENE.replace("shrub.toml", &"a".repeat(count));
    let memory = |text: &str| format!("{SCENE}[device]\nmemory = \"{text}\"\n");
    for (met, exceeded, numbers) in [
        (
            trees(limits::SCENE_TREES),
            trees(limits::SCENE_TREES + 1),
            "found 20001 tables, wanted 1 to 20000",
        ),
        (
            frames(limits::SCENE_FRAMES),
            frames(limits::SCENE_FRAMES + 1),
            "found 100001, wanted an integer from 1 to 100000",
        ),
        (
            keys(limits::CAMERA_KEYS),
            keys(limits::CAMERA_KEYS + 1),
            "found 10001 tables, wanted 1 to 10000",
        ),
        (
            names(limits::FOLIAGE_NAMES),
            names(limits::FOLIAGE_NAMES + 1),
            "wanted a list of at most 10000 texts",
        ),
        (
            path(limits::TEXT_CHARACTERS),
            path(limits::TEXT_CHARACTERS + 1),
            "wanted a path",
        ),
        (
            memory("4 GiB"),
            memory("4294967297 B"),
            "found \"4294967297 B\", wanted a size such as \"256 MiB\", in B, KiB, MiB or GiB, at most 4 GiB",
        ),
    ] {
        assert!(
            scene(&met).is_ok(),
            "{numbers}: {:?}",
            scene(&met).map(drop)
        );
        let said = scene(&exceeded).unwrap_err();
        assert!(said.contains(numbers), "{said}");
    }
}

#[test]
fn sizes_of_a_scene_are_limited() {
    let folder = folder();
    for (size, parts) in [
        ("16385x1", "wanted sides of 1 to 16384"),
        ("16384x16384", "at most 33554432 pixels"),
        ("4294967295x4294967295", "at most 33554432 pixels"),
    ] {
        let (code, said) = refused(folder.path(), &["run", "scene.toml", "--size", size]);
        assert_eq!(code, 2, "{said}");
        assert!(said.contains(size) && said.contains(parts), "{said}");
    }
    // 256 MiB hold the picture's samples, and then nothing else.
    let (code, said) = refused(folder.path(), &["run", "scene.toml", "--size", "8192x4096"]);
    assert_eq!(code, 3, "{said}");
    assert!(said.contains("but 0 of 268435456 are free"), "{said}");
}

#[test]
fn nesting_overflows_no_stack() {
    let lists = |depth: usize| format!("a = {}{}", "[".repeat(depth), "]".repeat(depth));
    let tables = |depth: usize| format!("a = {}{}", "{a=".repeat(depth), "}".repeat(depth));
    let keys = |depth: usize| format!("{}a = 1", "a.".repeat(depth));
    let heads = |depth: usize| format!("[{}a]", "a.".repeat(depth));
    let mixed = format!(
        "{}1{}",
        format!("a = {{{}", "a.".repeat(78)).repeat(79),
        "}".repeat(79)
    );
    let met = scene(&lists(limits::TOML_NESTING)).unwrap_err();
    assert!(met.contains("unknown key `a`"), "{met}");
    let exceeded = scene(&lists(limits::TOML_NESTING + 1)).unwrap_err();
    assert!(exceeded.contains("recursion depth"), "{exceeded}");
    for depth in [1000, 1_000_000] {
        for text in [lists(depth), tables(depth), keys(depth), heads(depth)] {
            assert!(scene(&text).is_err() && species(&text).is_err());
        }
    }
    assert!(scene(&mixed).is_err() && species(&mixed).is_err());
    let json = |depth: usize| {
        // The document itself is a level.
        let (open, close) = ("[".repeat(depth - 1), "]".repeat(depth - 1));
        format!("{{\"asset\":{{\"version\":\"2.0\"}},\"extras\":{open}{close}}}")
    };
    let read =
        |text: &str| import_bytes("a.gltf", text.as_bytes(), None, &ImportOptions::default());
    assert!(read(&json(limits::JSON_NESTING)).is_ok());
    let said = read(&json(limits::JSON_NESTING + 1))
        .unwrap_err()
        .to_string();
    assert!(said.contains("recursion limit"), "{said}");
    assert!(read(&json(1_000_000)).is_err());
}

#[test]
fn counts_of_a_species_are_limited() {
    let kinds = |count: usize| {
        let head = SPECIES.split("[[foliage]]").next().unwrap();
        format!(
            "{head}{}",
            "[[foliage]]\nsilhouette = \"round\"\n".repeat(count)
        )
    };
    assert!(species(&kinds(limits::SPECIES_KINDS)).is_ok());
    let said = species(&kinds(limits::SPECIES_KINDS + 1)).unwrap_err();
    assert!(
        said.contains("17 tables [[foliage]], wanted 1..=16"),
        "{said}"
    );
    let leaves =
        |count: usize| SPECIES.replace("leaf_count = 200", &format!("leaf_count = {count}"));
    assert!(species(&leaves(limits::GROWN_LEAVES)).is_ok());
    let said = species(&leaves(limits::GROWN_LEAVES + 1)).unwrap_err();
    assert!(
        said.contains("leaf_count is 4000001, wanted 1..=4000000"),
        "{said}"
    );
}

#[test]
fn leaves_of_a_plant_are_limited() {
    let plant = |leaves: usize| {
        let group = LeafGroup {
            name: "points".to_owned(),
            prototype: Prototype::Needle { diameter: 0.001 },
            material: Material::plain("leaf", [0.5; 3]),
            positions: Vec::new(),
            owners: vec![spinney::plant::NO_BRANCH; leaves],
        };
        Plant::new(
            "many",
            None,
            None,
            Foliage {
                groups: vec![group],
            },
        )
        .map(drop)
    };
    let said = plant(limits::PLANT_LEAVES + 1).unwrap_err().to_string();
    assert!(
        said.contains("16000001 leaves exceed the limit of 16000000"),
        "{said}"
    );
    // As many as may be are refused for another reason: they have no vertices.
    let said = plant(limits::PLANT_LEAVES).unwrap_err().to_string();
    assert!(!said.contains("exceed"), "{said}");
}

#[test]
fn counts_of_a_file_of_wood_are_limited() {
    let read = |text: &str| {
        let imported = import_bytes("a.txt", text.as_bytes(), None, &ImportOptions::default());
        imported
            .map(|imported| imported.report.found("entities"))
            .map_err(|error| error.to_string())
    };
    let table = |columns: usize| {
        let (names, zeros) = (",x".repeat(columns - 9), ",0".repeat(columns - 9));
        format!(
            "ID,parentID,startX,startY,startZ,endX,endY,endZ,radius{names}\n0,-1,0,0,0,0,0,1,0.1{zeros}\n"
        )
    };
    assert!(read(&table(limits::TABLE_COLUMNS)).is_ok());
    let said = read(&table(limits::TABLE_COLUMNS + 1)).unwrap_err();
    assert!(
        said.contains("10001 columns exceed the limit of 10000"),
        "{said}"
    );
    let graph = |tabs: usize, last: u64| {
        let tabs = "\t".repeat(tabs);
        format!(
            "CODE:\tFORM-A\nMTG:\nENTITY-CODE{tabs}XX\tYY\tZZ\n/E1{tabs}0\t0\t0\n^<<E{last}{tabs}0\t0\t9\n"
        )
    };
    // Of the last one's number, the first and the last are not between.
    assert_eq!(read(&graph(1, limits::SKIPPED_ENTITIES + 2)), Ok(10_002));
    let said = read(&graph(1, limits::SKIPPED_ENTITIES + 3)).unwrap_err();
    assert!(
        said.contains("10001 entities between two of a line exceed the limit of 10000"),
        "{said}"
    );
    assert_eq!(read(&graph(limits::TABLE_COLUMNS - 3, 2)), Ok(2));
    let said = read(&graph(limits::TABLE_COLUMNS - 2, 2)).unwrap_err();
    assert!(
        said.contains("10001 columns exceed the limit of 10000"),
        "{said}"
    );
}

#[test]
fn buffers_in_host_memory_are_limited() {
    let mut device = Device::new(DeviceDescriptor {
        memory_bytes: 1 << 20,
        link: Link::ALL[0],
        card: Card::ALL[0],
        raster: Options {
            tile: TileSize::Side64,
            counters: Counters::Visible,
        },
    });
    let mut create = |size| {
        device.create_buffer(&BufferDescriptor {
            label: "leaves",
            size,
            usage: Usage::VERTEX,
            residency: Residency::Host,
        })
    };
    assert!(create(1000).is_ok());
    let error = create(limits::HOST_BYTES - 999).unwrap_err();
    let wanted = GpuError::OutOfHostMemory {
        label: "leaves".to_owned(),
        asked: limits::HOST_BYTES - 999,
        free: limits::HOST_BYTES - 1000,
        budget: limits::HOST_BYTES,
    };
    assert_eq!(error, wanted);
}

#[test]
fn trees_of_a_scene_are_limited_together() {
    let folder = folder();
    // Ten thousand shrubs of two hundred thousand leaves: twice as many as may stand.
    let species = SPECIES
        .replace("leaf_count = 200", "leaf_count = 200_000")
        .replace("stop_leaves = 5", "stop_leaves = 200_000");
    std::fs::write(folder.path().join("shrub.toml"), species).unwrap();
    let tree = "{ species = \"shrub.toml\" }";
    let met = limits::STANDING_LEAVES / 200_000;
    let build = |trees: u64| {
        let many = vec![tree; usize::try_from(trees).unwrap()].join(",");
        let scene = scene(&SCENE.replace(tree, &many)).unwrap();
        World::build(&scene, folder.path(), &Silent)
    };
    assert!(build(met).is_ok());
    let error = build(met + 1).unwrap_err();
    let RunError::TooMany {
        tree: 5000,
        found,
        limit,
        ..
    } = error
    else {
        panic!("{error}");
    };
    assert_eq!((found, limit), (1_000_200_000, limits::STANDING_LEAVES));
    assert_eq!(
        error.to_string(),
        "leaves of trees: 1000200000 up to tree 5000 exceed the limit of 1000000000"
    );
}
