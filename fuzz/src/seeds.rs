//! The seed corpus: files of our own, each made from nothing or from `scenes/`, the same every time.

mod gltf;
mod import;
mod png;

use std::path::{Path, PathBuf};

use spinney::document::Document;
use spinney::plant::gltf::export_glb;
use spinney::plant::{Silhouette, Species, grow};
use spinney::report::{Layer, LayerSamples, encode_exr};

/// The seeds of a target: names and bytes.
///
/// # Panics
///
/// When there is no such target, or `scenes/` cannot be read.
#[must_use]
pub fn seeds(target: &str) -> Vec<(String, Vec<u8>)> {
    match target {
        "arbaro" => import::arbaro(),
        "gltf" => plants(),
        "obj" => import::obj(),
        "opf" => import::opf(),
        "exr" => layers(),
        "png" => png::images(),
        "ops" => ops(),
        "scene" => scenes(),
        "species" => species(),
        "trace" => traces(),
        "wood" => woods(),
        _ => panic!("no target {target}"),
    }
}

fn named(seeds: &[(&str, &str)]) -> Vec<(String, Vec<u8>)> {
    let seed = |(name, text): &(&str, &str)| ((*name).to_owned(), text.as_bytes().to_vec());
    seeds.iter().map(seed).collect()
}

/// All scenes that are shipped, and one with every key.
fn scenes() -> Vec<(String, Vec<u8>)> {
    let mut seeds = files("scenes", &["species"]);
    seeds.extend(named(&[
        ("every_key", EVERY_KEY),
        ("empty", ""),
        ("bom", "\u{feff}schema = 1\r\n"),
    ]));
    seeds
}

/// All species that are shipped, and two small ones.
fn species() -> Vec<(String, Vec<u8>)> {
    let mut seeds = files("scenes/species", &[]);
    let every = Silhouette::ALL.map(|kind| {
        format!(
            "[[foliage]]\nsilhouette = \"{}\"\nlength = 0.1\n",
            kind.name()
        )
    });
    let head = "schema = \"spinney.species/1\"\nname = \"all\"\n";
    seeds.extend(named(&[
        ("bush", crate::species::BUSH),
        ("all", &format!("{head}{}", every[..16].concat())),
    ]));
    seeds
}

/// States of two trees over some frames.
fn ops() -> Vec<(String, Vec<u8>)> {
    named(&[
        (
            "uniform",
            "{\"frame\":0,\"trees\":[{\"tree\":0,\"uniform\":9},{\"tree\":1,\"uniform\":0}]}\n\
            {\"frame\":1,\"trees\":[{\"tree\":1,\"uniform\":55}]}\n{\"frame\":2,\"trees\":[]}\n",
        ),
        (
            "variable",
            "{\"frame\":0,\"trees\":[{\"tree\":0,\"variable\":[[0,1],[3,1]]},\
            {\"tree\":1,\"uniform\":3}]}\n\
            {\"frame\":7,\"trees\":[{\"tree\":0,\"variable\":[[0,0]]},{\"tree\":1,\"variable\":[]}]}\n",
        ),
        (
            "wrong",
            "{\"frame\":0,\"trees\":[{\"tree\":0,\"uniform\":56}]}\n{}\n[]\nnull\n{\"frame\":-1}\n",
        ),
    ])
}

/// The example that the test kit's pages show, and traces of the other operations and parts.
fn traces() -> Vec<(String, Vec<u8>)> {
    named(&[
        (
            "example",
            include_str!("../../src/testkit/trace/example.jsonl"),
        ),
        (
            "clusters",
            "{\"schema\":\"spinney.trace/1\",\"leaves\":5,\"collapses\":[[0,3],[1,2],[5,4]],\
            \"parts\":[\"visible\",\"image\"]}\n\
            {\"clusters\":[0,0],\"visible\":[0,1,2,3,4],\"image\":\"a\"}\n\
            {\"clusters\":[1,0],\"visible\":[5,4,1,2],\"image\":\"b\"}\n\
            {\"level\":3,\"visible\":[7,6],\"image\":\"c\"}\n\
            {\"split\":2,\"visible\":[1,2,4,5],\"image\":\"b\"}\n",
        ),
        (
            "host",
            "{\"schema\":\"spinney.trace/1\",\"leaves\":2,\"collapses\":[[0,1]],\
            \"parts\":[\"writes\",\"counted\",\"resident\",\"reads\"],\
            \"resources\":[{\"name\":\"a\",\"bytes\":2},{\"name\":\"b\",\"bytes\":1,\"host\":true}]}\n\
            {\"level\":1,\"writes\":[],\"counted\":{\"transfers\":0,\"bytes\":0},\
            \"resident\":[\"0000\",\"07\"],\"reads\":[[0,0,1],[1,0,1]]}\n",
        ),
    ])
}

/// A small tree in every format of wood, once known by its content and once by a first byte.
fn woods() -> Vec<(String, Vec<u8>)> {
    let tree_qsm = "radius (m)\tlength (m)\tstart_point\taxis_direction\tparent\textension\tbranch\t\
        branch_order\tposition_in_branch\tmad\tSurfCov\tadded\tUnmodRadius (m)\n\
        0.2\t2\t7.1\t-3\t1\t0\t0\t1\t0\t2\t1\t0\t1\t0\t0\t0\t0.2\n\
        0.1\t1\t7.1\t-3\t3\t0\t0\t1\t1\t0\t1\t0\t2\t0\t0\t0\t0.1\n\
        0.1\t1\t7.1\t-3\t2\t1\t0\t0\t1\t0\t2\t1\t1\t0\t0\t1\t0.1\n";
    let old = "2e-1 2 0 0 0 0 0 1 0 2 0 0.2 1 0 1\n1e-1 1 0 0 2 0 0 1 1 0 0 0.1 1 0 2\n";
    let simple_forest = "ID, parentID, startX, startY, startZ, endX, endY, endZ, radius, branchID\n\
        0, -1, 0, 0, 0, 0, 0, 1, 0.2, 0\n5, 0, 0, 0, 1, 1, 0, 2, 0.1, 1\n7, 5, 1, 0, 2, 1, 0, 2, 0, 1\n";
    let archi = "\"startX\",\"startY\",\"startZ\",\"cyl_ID\",\"parent_ID\",\"extension_ID\",\"radius_cyl\",\
        \"endX\",\"endY\",\"endZ\"\n0,0,0,1,0,2,0.2,0,0,1\n0,0,1,2,1,NA,0.1,0,1,2\n3,0,0,3,9,0,0.1,3,0,1\n";
    let treefile = "# made by hand\nheight, x,y,z,radius,parent_id,red\n\
        2, 5,5,0,0.3,-1,1, 5,5,1,0.2,0,1, 5,6,2,0.1,1,1,\n1, 8,5,0,0,-1,1, 8,5,1,0.1,0,1\n";
    let mtg = "CODE:\tFORM-A\n\nCLASSES:\nSYMBOL\tSCALE\tDECOMPOSITION\tINDEXATION\tDEFINITION\n\
        $\t0\tFREE\tFREE\tIMPLICIT\nP\t1\tFREE\tFREE\tEXPLICIT\nE\t2\tFREE\tFREE\tEXPLICIT\n\n\
        DESCRIPTION:\nLEFT\tRIGHT\tRELTYPE\tMAX\nE\tE\t+\t?\n\nFEATURES:\nNAME\tTYPE\n\nMTG:\n\
        ENTITY-CODE\t\tXX\tYY\tZZ\tTopDia\tNFe\tleaf_area\tLength\tWidth\tXEuler\n\
        /P1/E1\t\t0\t0\t0\t40\n^<E2<<E5\t\t0\t1\t90\t30\t12\n\t+E1++E3\t9\t0\t95\t9\t\t40\n\
        \t^+Leaf1\t\t\t\t\t\t\t5\t3\t60\n^<E6\n";
    let texts = [tree_qsm, simple_forest, archi, treefile, mtg];
    let names = ["tree_qsm", "simple_forest", "archi", "treefile", "mtg"];
    let mut seeds = named(&[("old", old)]);
    for ((byte, name), text) in (0_u8..).zip(names).zip(texts) {
        seeds.push((name.to_owned(), text.as_bytes().to_vec()));
        seeds.push((format!("told_{name}"), [&[byte], text.as_bytes()].concat()));
    }
    seeds
}

/// Layers in small EXR files.
fn layers() -> Vec<(String, Vec<u8>)> {
    let layer = |name: &str, samples| Layer {
        name: name.to_owned(),
        samples,
    };
    let depth = |count: u16| LayerSamples::F32((0..count).map(|n| f32::from(n) / 7.0).collect());
    let leaf = |count: u32| LayerSamples::U32((0..count).map(|n| u32::MAX - n % 5).collect());
    let files = [
        (1, 1, vec![layer("Z", depth(1))]),
        (7, 5, vec![layer("Z", depth(35)), layer("leaf", leaf(35))]),
        (
            3,
            40,
            vec![
                layer("a.B", leaf(120)),
                layer("R", depth(120)),
                layer("G", depth(120)),
            ],
        ),
    ];
    let file = |(width, height, layers): (u32, u32, Vec<Layer>)| {
        let file = encode_exr(width, height, layers).expect("tiny");
        (format!("{width}x{height}.exr"), file)
    };
    files.map(file).into()
}

/// A plant that spinney wrote, and what other programs write.
fn plants() -> Vec<(String, Vec<u8>)> {
    let document = Document {
        file: "bush.toml".to_owned(),
        text: crate::species::BUSH.to_owned(),
    };
    let species = Species::parse(&document).expect("our own");
    let own = export_glb(&grow(&species, 1).expect("our own")).expect("small");
    let mut seeds = gltf::foreign();
    seeds.push(("own_split".to_owned(), split(&own)));
    seeds.push(("own".to_owned(), own));
    seeds
}

/// Document and binary chunk of a `.glb`, with a NUL byte between.
fn split(glb: &[u8]) -> Vec<u8> {
    let length = u32::from_le_bytes(glb[12..16].try_into().expect("four bytes"));
    let end = 20 + usize::try_from(length).expect("small");
    [glb[20..end].trim_ascii_end(), b"\0", &glb[end + 8..]].concat()
}

/// The TOML files below a folder of the repository, without some folders.
fn files(folder: &str, without: &[&str]) -> Vec<(String, Vec<u8>)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("..")
        .join(folder);
    let mut paths = Vec::new();
    collect(&root, without, &mut paths);
    paths.sort();
    paths
        .iter()
        .map(|path| {
            let name = path.strip_prefix(&root).expect("found below it");
            let name = name.to_string_lossy().replace(['/', '\\'], "_");
            (name, std::fs::read(path).expect("a file"))
        })
        .collect()
}

fn collect(folder: &Path, without: &[&str], paths: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder of the repository") {
        let path = entry.expect("an entry").path();
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        if path.is_dir() && !without.contains(&name.as_str()) {
            collect(&path, without, paths);
        } else if name.ends_with(".toml") {
            paths.push(path);
        }
    }
}

/// A scene that says everything a scene can say, in several spellings of TOML.
const EVERY_KEY: &str = r##"schema = "spinney.scene/1"
name = "every"
size = [64, 0x30]
samples = 4
frames = 10
seed = 18_446_744_073
background = '#102030'
light = { direction = [0.0, 1, 0], color = [1.0, 1.0, 1.0], ambient = [0, 0, 0] }
[[tree]]
species = "a/b.toml"
seed = 7
at = [1.5, -2e1, 3.0]
turn = -90
scale = 2.5
plant_digest = "0000000000000000000000000000000000000000000000000000000000000001"
[[tree]]
file = """oak.glb"""
foliage = ["leaf", "M#0"]
[camera]
projection = "orthographic"
height = 12.0
near = 0.5
far = 200.0
[[camera.path]]
eye = [0.0, 2.0, 10.0]
target = [0.0, 2.0, 0.0]
[[camera.path]]
frame = 9
eye = [0.0, 9.0, 0.0]
target = [0.0, 0.0, 0.0]
[model]
name = "lodf"
mode = "slots"
detail = "variable"
d_min = 1
d_max = 9.5
extraction = "single"
gather = "regions"
stop_leaves = 4
level = 0.25
[device]
memory = "64 MiB"
link = "agp4x"
card = "gtx770"
[golden]
size = [32, 24]
frames = [0, 3, 9]
tolerance = 2
reason = "none"
"##;

/// The words of a target's language, for the fuzzer to put together.
///
/// # Panics
///
/// When there is no such target.
#[must_use]
pub fn words(target: &str) -> Vec<String> {
    let list = |text: &str| text.split_whitespace().map(str::to_owned).collect();
    match target {
        "gltf" => {
            let mut words: Vec<String> = list(GLTF_KEYS);
            words
                .iter_mut()
                .for_each(|word| *word = format!("\"{word}\""));
            words.extend(list(GLTF_VALUES));
            words
        }
        "arbaro" => {
            let mut words = list(ARBARO_KEYS);
            words.extend(list("<param name=' ' value=' '/> <species> <!-- <!DOCTYPE &#0; 1e39 -1 nan"));
            words
        }
        "obj" => list("v vt vn f o g usemtl mtllib s l p \\ // -1 0 1/1 1//1 1/1/1 1e39 1e-45 nan leaf"),
        "opf" => list(OPF_NAMES),
        "exr" => list(EXR_NAMES),
        "png" => list(
            "IHDR PLTE tRNS IDAT IEND gAMA sRGB iCCP cHRM pHYs tEXt zTXt iTXt fcTL fdAT acTL bKGD",
        ),
        "ops" => list(
            "\"frame\":0 \"trees\":[] {\"tree\":0} \"uniform\":1 \"variable\":[[0,1]] 4294967295 -1 1e9 null",
        ),
        "scene" => {
            let tail = |key: &spinney::scene::Key| {
                let tail = key.path.rsplit(['.', ']']).next().unwrap_or_default();
                format!("{tail} = ")
            };
            let mut words: Vec<String> = spinney::scene::KEYS.iter().map(tail).collect();
            words.extend(list(TOML_VALUES));
            words.extend(list("[[tree]] [camera] [light] [model] [device] [golden] [[camera.path]] \"lodf\" \"full\" \"vdf\" \"host\" \"stamps\" \"literal\" \"indices\" \"resident\" \"variable\" \"MiB\""));
            words.sort();
            words.dedup();
            words
        }
        "species" => {
            // The first cell of every row of the table of keys.
            let key = |line: &str| {
                let key = line.strip_prefix("| `")?.split('`').next()?;
                Some(format!("{} = ", key.rsplit('.').next()?))
            };
            let mut words: Vec<String> = Species::HELP.lines().filter_map(key).collect();
            words.extend(list(TOML_VALUES));
            words.extend(list("[crown] [clump] [wood] [stems] [leaves] [[foliage]] \"envelope\" \"#102030\" [0,0,0,0]"));
            words
        }
        "trace" => {
            let quoted = |word: &str| format!("\"{word}\"");
            let mut words: Vec<String> = TRACE_KEYS.split_whitespace().map(quoted).collect();
            words.extend(list("[0,1] {\"level\":0} {\"split\":1} {\"collapse\":1} \"00ff\" 4294967295 -1 1e9 null true"));
            words
        }
        "wood" => list(WOOD_WORDS),
        _ => panic!("no target {target}"),
    }
}

const WOOD_WORDS: &str = "radius length start_point axis_direction parent extension branch ID parentID \
    startX startY startZ endX endY endZ branchID cyl_ID parent_ID extension_ID radius_cyl axis_ID \
    x,y,z,radius,parent_id CODE: CLASSES: FEATURES: MTG: ENTITY-CODE XX YY ZZ TopDia NFe leaf_area Length \
    Width XEuler azimuth /P1 ^/E1 ^<E2 <<E9 +Leaf1 ++E4 NA NaN inf -1 1e308 1e-308 -0.0 4294967296 \" # \\t";

const EXR_NAMES: &str = "channels chlist compression dataWindow displayWindow box2i lineOrder \
    pixelAspectRatio float screenWindowCenter v2f screenWindowWidth tiles tiledesc type string \
    scanlineimage tiledimage deepscanline deeptile chunkCount int version name view multiView";

const ARBARO_KEYS: &str = "Shape Levels Scale ScaleV ZScale BaseSize Ratio RatioPower Flare Lobes LobeDepth \
    0BaseSplits 0Scale 1Length 1Taper 1SegSplits 1SplitAngle 1CurveRes 1Curve 1CurveBack 1CurveV 1DownAngle \
    1DownAngleV 1Rotate 1RotateV 1Branches 1BranchDist Leaves LeafShape LeafScale LeafScaleX LeafQuality \
    LeafStemLen LeafBend AttractionUp PruneRatio PruneWidth PruneWidthPeak PrunePowerLow sphere disc1";

const OPF_NAMES: &str = "<opf> <meshBDD> <mesh <points> <faces> <face> <textureCoords> <materialBDD> <material \
    <diffuse> <shapeBDD> <shape <meshIndex> <materialIndex> <topology <decomp <follow <branch <geometry> \
    <shapeIndex> <mat> <dUp> <dDwn> Id=\"0\" scale=\"3\" class=\"leaf\" enableScale=\"true\" <!DOCTYPE &#0; 1e39 nan";

const TRACE_KEYS: &str = "schema spinney.trace/1 leaves collapses parts resources name bytes host level \
    clusters collapse split visible writes counted transfers resident reads fresh image to at hex";

const TOML_VALUES: &str = "nan inf -inf 1e39 -0.0 1e-45 0x7fffffffffffffff 9223372036854775807 \
    4294967296 -1 \"\"\" ''' [[ ]] {} [] true 1979-05-27T07:32:00Z \\u0000 \\UFFFFFFFF \\e # \\r";

const GLTF_KEYS: &str = "accessors bufferViews buffers byteLength byteOffset byteStride bufferView \
    componentType count type normalized sparse indices values min max attributes POSITION NORMAL \
    TEXCOORD_0 TEXCOORD_1 TANGENT COLOR_0 mode material materials meshes mesh primitives nodes \
    children matrix translation rotation scale scenes scene images textures source sampler uri \
    mimeType alphaMode alphaCutoff doubleSided pbrMetallicRoughness baseColorFactor \
    baseColorTexture texCoord index extensions extensionsUsed extensionsRequired extras asset \
    version minVersion spinney skeleton trunk groups owners prototype numbers triangles hidden \
    digest leaves node name targets weights skins joints animations cameras";

const GLTF_VALUES: &str = "5120 5121 5122 5123 5125 5126 \"SCALAR\" \"VEC2\" \"VEC3\" \"VEC4\" \
    \"MAT4\" \"MASK\" \"BLEND\" \"OPAQUE\" 4294967295 4294967296 18446744073709551615 -1 1e39 1e-45 \
    null [] {} [0,0,0] \"image/png\" \"KHR_mesh_quantization\" data:;base64, AAAA";
