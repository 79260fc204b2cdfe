//! The keys of a scene file: one table that reading, defaults, messages and help are made from.

use crate::limits;
use crate::plant::import::{Format, Unit, UpAxis};

use super::{
    BranchAlpha, BranchFrames, BranchLines, BranchRemoval, BranchShares, CardDepth, CardMode,
    CardOptions, CardOutline, CardSides, CriterionName, DetailKind, Extraction, Gather, GroveBlend,
    GroveOrder, GrovePacking, ImageSize, Layout, Mode, ModelName, NeedleMerging, Occlusion,
    PaintLook, PaintMark, RecordWidth, Simplifier, SpriteScale, Transparency, TrunkMode, TrunkName,
    VertexFormat,
};

/// One key of a scene file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Key {
    /// The tables that lead to it, and its name: `camera.path[].eye`; `[]` stands for each of
    /// several tables.
    pub path: &'static str,
    /// Which values it takes.
    pub kind: Kind,
    /// The unit of the values, or their space; empty where they have none.
    pub unit: &'static str,
    /// What holds where the key is absent.
    pub absent: Absent,
    /// What it means.
    pub meaning: &'static str,
}

/// Which values a key takes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// A table with keys of its own.
    Table,
    /// One to so many tables with keys of their own.
    Tables {
        /// The most tables.
        most: usize,
    },
    /// A text of 1 to [`limits::TEXT_CHARACTERS`] characters, none of them a control character.
    Text,
    /// A text of letters, digits, `.`, `_` and `-`, at most 64, that begins with none of these
    /// three.
    Name,
    /// A path relative to the scene file, with `/` between its parts.
    Path,
    /// A path as of [`Kind::Path`], or a list of them.
    Paths {
        /// The most paths.
        most: usize,
    },
    /// One of these texts.
    Choice(&'static [&'static str]),
    /// A list of texts.
    Texts,
    /// One of these integers.
    OneOf(&'static [u64]),
    /// An integer.
    Integer {
        /// The least value.
        min: u64,
        /// The greatest value.
        max: u64,
    },
    /// Ascending integers, at least one and at most so many.
    Ascending {
        /// The greatest value.
        max: u64,
        /// The most values.
        most: usize,
    },
    /// Descending integers from 1, at least one and at most so many.
    Descending {
        /// The greatest value.
        max: u64,
        /// The most values.
        most: usize,
    },
    /// Width and height, at most so much a side.
    Size {
        /// The largest side.
        side: u32,
    },
    /// A finite number.
    Number {
        /// The least value.
        min: f32,
        /// The greatest value.
        max: f32,
    },
    /// Three finite numbers.
    Triple {
        /// The least value of each.
        min: f32,
        /// The greatest value of each.
        max: f32,
    },
    /// Two finite numbers, the first not above the second.
    Range {
        /// The least value of each.
        min: f32,
        /// The greatest value of each.
        max: f32,
    },
    /// `[x0, z0, x1, z1]`: finite numbers, `x0` below `x1` and `z0` below `z1`.
    Area {
        /// The greatest value of each, and the least with its sign turned.
        max: f32,
    },
    /// A colour `"#rrggbb"`.
    Color,
    /// A whole number of bytes with a unit.
    Bytes {
        /// The most bytes: whole GiB.
        most: u64,
    },
    /// 64 hexadecimal digits.
    Digest,
    /// A list of texts of 64 hexadecimal digits.
    Digests {
        /// The most texts.
        most: usize,
    },
}

impl Kind {
    /// What would be right, as words that continue "wanted …".
    #[must_use]
    pub fn wanted(&self) -> String {
        match *self {
            Self::Table => "a table".to_owned(),
            Self::Tables { most } => format!("1 to {most} tables"),
            Self::Text => format!("a text of 1 to {} characters", limits::TEXT_CHARACTERS),
            Self::Name => {
                "a text of 1 to 64 letters, digits, `.`, `_`, `-` that begins with a letter or digit"
                    .to_owned()
            }
            Self::Path => {
                "a path relative to the scene file, with `/` between its parts".to_owned()
            }
            Self::Paths { most } => format!(
                "a path relative to the scene file, with `/` between its parts, or a list of at \
                 most {most}"
            ),
            Self::Choice(names) => {
                let names: Vec<String> = names.iter().map(|name| format!("\"{name}\"")).collect();
                alternatives(&names)
            }
            Self::Texts => format!("a list of at most {} texts", limits::FOLIAGE_NAMES),
            Self::OneOf(values) => {
                let values: Vec<String> = values.iter().map(u64::to_string).collect();
                alternatives(&values)
            }
            Self::Integer { min, max } => format!("an integer from {min} to {max}"),
            Self::Ascending { max, most } => {
                format!("1 to {most} ascending integers from 0 to {max}")
            }
            Self::Descending { max, most } => {
                format!("1 to {most} descending integers from {max} to 1")
            }
            Self::Size { side } if side == ImageSize::MAX_SIDE => format!(
                "[width, height] from 1 to {side}, at most {} pixels",
                ImageSize::MAX_PIXELS
            ),
            Self::Size { side } => format!("[width, height] from 1 to {side}"),
            Self::Number { min, max } => format!("a number from {min} to {max}"),
            Self::Triple { min, max } => format!("three numbers from {min} to {max}"),
            Self::Range { min, max } => {
                format!("[least, greatest], numbers from {min} to {max}, not descending")
            }
            Self::Area { max } => format!(
                "[x0, z0, x1, z1], numbers from -{max} to {max}, x0 below x1 and z0 below z1"
            ),
            Self::Color => "a colour \"#rrggbb\"".to_owned(),
            Self::Bytes { most } => format!(
                "a size such as \"256 MiB\", in B, KiB, MiB or GiB, at most {} GiB",
                most >> 30
            ),
            Self::Digest => "64 hexadecimal digits".to_owned(),
            Self::Digests { most } => {
                format!("a list of at most {most} texts of 64 hexadecimal digits")
            }
        }
    }
}

/// `a`, `a or b`, `a, b or c`.
fn alternatives(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [only] => only.clone(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

/// What holds where a key is absent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Absent {
    /// The key must be there.
    Required,
    /// This value, written as in a file.
    Value(&'static str),
    /// What these words say.
    Rule(&'static str),
}

impl Absent {
    fn shown(&self) -> String {
        match *self {
            Self::Required => "required".to_owned(),
            Self::Value(value) => format!("default {value}"),
            Self::Rule(rule) => format!("default: {rule}"),
        }
    }
}

/// The last frame that a key may name, in the type of integers of scenes.
const FRAME_MAX: u64 = limits::SCENE_FRAMES as u64;
const METRES: f32 = 100_000.0;

/// Every key of a scene file, in the order of help and of [`to_toml`](super::to_toml).
#[rustfmt::skip]
pub const KEYS: &[Key] = &[
    key("schema", Kind::Choice(&[super::SCHEMA]), "", Absent::Required,
        "The kind and version of the file."),
    key("name", Kind::Name, "", Absent::Rule("the file's name without its ending"),
        "The name in reports and of the output folder."),
    key("size", Kind::Size { side: ImageSize::MAX_SIDE }, "pixels", Absent::Value("[640, 480]"),
        "Width and height of a frame."),
    key("samples", Kind::OneOf(&[1, 4]), "samples a pixel", Absent::Value("1"),
        "How often each pixel is sampled."),
    key("frames", Kind::Integer { min: 1, max: FRAME_MAX }, "frames", Absent::Value("1"),
        "How many frames are rendered, from frame 0."),
    key("seed", Kind::Integer { min: 0, max: u64::MAX }, "", Absent::Value("1"),
        "Where all random numbers come from."),
    key("background", Kind::Color, "sRGB", Absent::Value("\"#c8d8e8\""),
        "The colour behind everything."),

    key("tree", Kind::Tables { most: limits::SCENE_TREES }, "", Absent::Rule("none: then a forest"),
        "The trees, a [[tree]] each; each has either `species` or `file`."),
    key("tree[].species", Kind::Path, "", Absent::Rule("none: then `file`"),
        "The species file that the tree grows from: parameters, *.toml or Arbaro's *.xml, or a grammar, *.rls."),
    key("tree[].file", Kind::Path, "", Absent::Rule("none: then `species`"),
        "The file that holds the tree: glTF, OBJ, a scanned tree's cylinders, MTG, OPF or OPS."),
    key("tree[].foliage", Kind::Texts, "", Absent::Rule("the importer decides"),
        "With `file`: the names of groups, objects, nodes, meshes or materials that are foliage."),
    key("tree[].format", Kind::Choice(Format::NAMES), "", Absent::Rule("by the file's content, then its ending"),
        "With `file`: its format."),
    key("tree[].up", Kind::Choice(UpAxis::NAMES), "", Absent::Rule("the format's own, or a guess"),
        "With `file`: the axis that points up."),
    key("tree[].unit", Kind::Choice(Unit::NAMES), "", Absent::Rule("the format's own, or a guess"),
        "With `file`: the unit of its lengths."),
    key("tree[].seed", Kind::Integer { min: 0, max: u64::MAX }, "", Absent::Rule("the scene's"),
        "The seed that the tree grows from, or that leaves are placed by which `file` only counts."),
    key("tree[].at", Kind::Triple { min: -METRES, max: METRES }, "m, world", Absent::Value("[0, 0, 0]"),
        "Where the base of the trunk stands."),
    key("tree[].turn", Kind::Number { min: -360.0, max: 360.0 }, "degrees about +Y", Absent::Value("0"),
        "How far it is turned, counter-clockwise seen from above."),
    key("tree[].scale", Kind::Number { min: 0.001, max: 1000.0 }, "", Absent::Value("1"),
        "The factor on its size."),
    key("tree[].plant_digest", Kind::Digest, "", Absent::Rule("any plant will do"),
        "The digest that the plant must have; a run writes it to scene.resolved.toml."),

    key("forest", Kind::Tables { most: limits::SCENE_FORESTS }, "", Absent::Rule("none: then a tree"),
        "Many trees, a [[forest]] each; they follow the single trees, and each plant is grown once."),
    key("forest[].species", Kind::Paths { most: limits::FOREST_SPECIES }, "", Absent::Required,
        "The species files that the trees grow from."),
    key("forest[].plant_seed", Kind::Integer { min: 0, max: u64::MAX }, "", Absent::Rule("the scene's"),
        "The seed that the plants grow from."),
    key("forest[].count", Kind::Integer { min: 1, max: limits::SCENE_TREES as u64 }, "trees", Absent::Required,
        "How many trees of each species there are."),
    key("forest[].seed", Kind::Integer { min: 0, max: u64::MAX }, "", Absent::Rule("the scene's"),
        "Where places, turns and scales come from."),
    key("forest[].layout", Kind::Choice(Layout::NAMES), "", Absent::Value("\"scattered\""),
        "By chance, species after species; in rows of squares, the species in turn; or in patches of a tree of each species."),
    key("forest[].area", Kind::Area { max: METRES }, "m, world", Absent::Required,
        "Where the trees stand, within the terrain if there is one."),
    key("forest[].spacing", Kind::Number { min: 0.01, max: METRES }, "m", Absent::Value("2"),
        "The least distance between two trunks of the forest; the side of a grid's squares. In patches half of it is kept."),
    key("forest[].scale", Kind::Range { min: 0.001, max: 1000.0 }, "", Absent::Value("[1, 1]"),
        "The least and the greatest factor on a tree's size."),
    key("forest[].plant_digests", Kind::Digests { most: limits::FOREST_SPECIES }, "", Absent::Rule("any plants will do"),
        "The digests that the plants must have, one a species; a run writes them to scene.resolved.toml."),

    key("terrain", Kind::Table, "", Absent::Rule("no ground, and forests stand at height 0"),
        "The ground: a square around the origin. Single trees stand where their `at` says."),
    key("terrain.size", Kind::Number { min: 1.0, max: METRES }, "m", Absent::Value("200"),
        "The side of the square."),
    key("terrain.cells", Kind::Integer { min: 1, max: limits::TERRAIN_CELLS }, "cells", Absent::Value("128"),
        "Cells a side, of two triangles each."),
    key("terrain.amplitude", Kind::Number { min: 0.0, max: 10_000.0 }, "m", Absent::Value("4"),
        "The height of the longest waves; together all stay within twice as much."),
    key("terrain.wavelength", Kind::Number { min: 0.01, max: METRES }, "m", Absent::Value("60"),
        "The length of the longest waves."),
    key("terrain.octaves", Kind::Integer { min: 1, max: 8 }, "", Absent::Value("4"),
        "How many waves are added, each half as long and half as high as the one before."),
    key("terrain.seed", Kind::Integer { min: 0, max: u64::MAX }, "", Absent::Rule("the scene's"),
        "Where the waves come from."),
    key("terrain.color", Kind::Color, "sRGB", Absent::Value("\"#6b7a48\""),
        "The colour of level ground."),
    key("terrain.steep_color", Kind::Color, "sRGB", Absent::Rule("`color`"),
        "The colour of ground that rises one to one or steeper; between, both mix."),

    key("camera", Kind::Table, "", Absent::Required,
        "Where from and how the trees are seen."),
    key("camera.projection", Kind::Choice(&["perspective", "orthographic"]), "", Absent::Value("\"perspective\""),
        "Whether what is far is small."),
    key("camera.vertical_field_of_view", Kind::Number { min: 0.1, max: 170.0 }, "degrees", Absent::Value("45"),
        "With perspective: the angle between the image's upper and lower edge."),
    key("camera.height", Kind::Number { min: 0.001, max: METRES }, "m", Absent::Rule("required with orthographic"),
        "With orthographic: what fits between the image's upper and lower edge."),
    key("camera.near", Kind::Number { min: 0.001, max: METRES }, "m", Absent::Value("0.1"),
        "Nothing nearer is drawn."),
    key("camera.far", Kind::Number { min: 0.001, max: 1_000_000.0 }, "m", Absent::Value("1000"),
        "Nothing farther is drawn; more than `near`."),
    key("camera.path", Kind::Tables { most: limits::CAMERA_KEYS }, "", Absent::Required,
        "Keys { frame, eye, target } with ascending frames, at least one; linear between them."),
    key("camera.path[].frame", Kind::Integer { min: 0, max: FRAME_MAX }, "frame", Absent::Value("0"),
        "The frame at which the camera is there."),
    key("camera.path[].eye", Kind::Triple { min: -METRES, max: METRES }, "m, world", Absent::Required,
        "Where the camera stands."),
    key("camera.path[].target", Kind::Triple { min: -METRES, max: METRES }, "m, world", Absent::Required,
        "What it looks at; another point than `eye`."),

    key("light", Kind::Table, "", Absent::Value("{}"),
        "What lights the trees."),
    key("light.direction", Kind::Triple { min: -METRES, max: METRES }, "world", Absent::Value("[0.4, 1, 0.6]"),
        "From the scene towards the light, of any length but 0."),
    key("light.color", Kind::Triple { min: 0.0, max: 100.0 }, "linear RGB", Absent::Value("[0.85, 0.82, 0.75]"),
        "The direct light."),
    key("light.ambient", Kind::Triple { min: 0.0, max: 100.0 }, "linear RGB", Absent::Value("[0.25, 0.28, 0.32]"),
        "The light from everywhere."),

    key("shadow", Kind::Table, "", Absent::Rule("no shadows"),
        "What is lit casts shadows: one more pass draws what the light sees. Not in mode device."),
    key("shadow.size", Kind::Integer { min: 16, max: limits::TEXTURE_SIDE as u64 }, "texels", Absent::Value("2048"),
        "The side of the map of depths, 4 bytes a texel."),
    key("shadow.bias", Kind::Number { min: 0.0, max: 64.0 }, "texels in the world", Absent::Value("4"),
        "How much nearer to the light a point is looked up, so that nothing shades itself."),
    key("shadow.extent", Kind::Number { min: 0.1, max: METRES }, "m", Absent::Rule("all that stands"),
        "The side of the square before the eye that the map covers; what lies beside it is lit."),

    key("model", Kind::Table, "", Absent::Value("{}"),
        "The level-of-detail system and its options."),
    key("model.name", Kind::Choice(ModelName::NAMES), "", Absent::Value("\"lodf\""),
        "The level-of-detail system."),
    key("model.mode", Kind::Choice(Mode::NAMES), "",
        Absent::Rule("lodf cluster, vdf host, full, flattened and bare resident, impostors direct, billboard axial, sprites nearest, crossed fixed, octahedral hemisphere, strokes ranges"),
        "What is resident on the device, and so what a change of detail sends."),
    key("model.detail", Kind::Choice(DetailKind::NAMES), "", Absent::Value("\"uniform\""),
        "One level for the whole foliage, or one for each cluster."),
    key("model.d_min", Kind::Number { min: 0.0, max: METRES }, "m", Absent::Value("5"),
        "Up to this distance all leaves are drawn."),
    key("model.d_max", Kind::Number { min: 0.0, max: METRES }, "m", Absent::Value("50"),
        "From this distance on the fewest leaves are drawn; more than `d_min`."),
    key("model.extraction", Kind::Choice(Extraction::NAMES), "", Absent::Value("\"batched\""),
        "One collapse or split after another, or all between two levels at once."),
    key("model.gather", Kind::Choice(Gather::NAMES), "", Absent::Value("\"single\""),
        "Scattered slots as single writes, or as one write of many regions."),
    key("model.records", Kind::Choice(RecordWidth::NAMES), "", Absent::Value("\"wide\""),
        "Leaf records with vertex numbers of 4 bytes, or of 2 within the cluster."),
    key("model.vertices", Kind::Choice(VertexFormat::NAMES), "", Absent::Value("\"float\""),
        "Vertices of 12 bytes, or of 8 on a grid in the crown's box."),
    key("model.occlusion", Kind::Choice(Occlusion::NAMES), "", Absent::Value("\"none\""),
        "In mode device: clusters that are hidden by what was seen in the frame before are left out."),
    key("model.simplifier", Kind::Choice(Simplifier::NAMES), "", Absent::Value("\"leaf-collapse\""),
        "Two leaves become one with corners of both, or one goes and the other grows by its area."),
    key("model.stop_leaves", Kind::Integer { min: 1, max: 16_000_000 }, "leaves", Absent::Rule("the species'"),
        "Simplification stops at so many leaves."),
    key("model.level", Kind::Number { min: 0.0, max: 1.0 }, "", Absent::Rule("by distance"),
        "A fixed level in place of distance: 0 all leaves, 1 the fewest."),
    key("model.criterion", Kind::Choice(CriterionName::NAMES), "", Absent::Value("\"paper\""),
        "With variable detail: which clusters get the tree's leaves; \"paper\" is by `d_min`, `d_max`."),
    key("model.leaf_budget", Kind::Integer { min: 1, max: 16_000_000 }, "leaves a tree", Absent::Rule("by distance"),
        "Exactly so many leaves, from one a cluster to all, spread as `criterion` says."),
    key("model.leaf_share", Kind::Number { min: 0.0, max: 1.0 }, "", Absent::Rule("by distance"),
        "The same as a share of all leaves."),
    key("model.pixel_error", Kind::Number { min: 0.001, max: 10_000.0 }, "pixels", Absent::Rule("by distance"),
        "The fewest leaves none of which lies farther from its originals than this."),
    key("model.hysteresis", Kind::Number { min: 0.0, max: 0.5 }, "", Absent::Value("0"),
        "Detail stays until what is wanted has moved by this share of the range."),
    key("model.budget_bytes", Kind::Integer { min: 1, max: limits::DEVICE_BYTES }, "bytes a frame", Absent::Rule("no limit"),
        "Changes of detail upload at most so much payload in a frame, not counting the first's."),
    key("model.trunk", Kind::Choice(TrunkName::NAMES), "", Absent::Value("\"full\""),
        "The level-of-detail system for trunks."),
    key("model.trunk_mode", Kind::Choice(TrunkMode::NAMES), "", Absent::Rule("the system's first"),
        "Where the triangles of trunks lie: resident, or fetched by each draw; of branches what is."),
    key("model.trunk_level", Kind::Number { min: 0.0, max: 1.0 }, "", Absent::Rule("as far as the foliage"),
        "A fixed level of trunks: 0 all triangles, 1 the fewest."),
    key("model.trunk_triangles", Kind::Integer { min: 0, max: limits::TRUNK_TRIANGLES as u64 }, "triangles", Absent::Rule("a twentieth"),
        "Simplification of trunks stops at so many triangles."),

    key("cards", Kind::Table, "", Absent::Value("{}"),
        "What stands in for leaves where the model draws cards."),
    key("cards.count", Kind::Integer { min: 1, max: limits::CARDS as u64 }, "impostors", Absent::Rule("the first of `levels`, or 32"),
        "How many impostors stand for a crown at the finest level."),
    key("cards.levels", Kind::Descending { max: limits::CARDS as u64, most: limits::CARD_LEVELS }, "impostors", Absent::Rule("`count`, half and a quarter of it"),
        "How many there are at each level; detail falls from the first at `d_min` to the last at `d_max`."),
    key("cards.texture", Kind::OneOf(&[8, 16, 32, 64, 128, 256, 512, 1024, 2048]), "texels", Absent::Value("512"),
        "The sides of an impostor's texture."),
    key("cards.orientation_weight", Kind::Number { min: 0.0, max: 1000.0 }, "mean square radii", Absent::Value("0.03"),
        "What a leaf's turn out of its plane weighs against its distance from it."),
    key("cards.plane_seeds", Kind::Integer { min: 1, max: 64 }, "", Absent::Value("4"),
        "How many first choices of planes are tried; the best is kept."),
    key("cards.depth", Kind::Choice(CardDepth::NAMES), "", Absent::Value("\"paper\""),
        "The depth of the impostor's plane, or of each texel's leaf."),
    key("cards.transparency", Kind::Choice(Transparency::NAMES), "", Absent::Value("\"test\""),
        "What texels do that a leaf covers in part; \"coverage\" wants 4 samples a pixel."),
    key("cards.outline", Kind::Choice(CardOutline::NAMES), "", Absent::Value("\"quad\""),
        "The rectangle around the leaves, or at most 8 corners around what is opaque."),
    key("cards.sides", Kind::Choice(CardSides::NAMES), "", Absent::Value("\"both\""),
        "Textures of front and back, or of the front for both."),
    key("cards.map", Kind::OneOf(&[8, 16, 32, 64, 128, 256, 512]), "texels", Absent::Value("64"),
        "In mode indirect: the sides of the map that says where leaves lie."),
    key("cards.layers", Kind::Integer { min: 1, max: CardOptions::MOST_LAYERS as u64 }, "leaves", Absent::Value("8"),
        "In mode indirect: how many leaves a texel of the map may have at the most."),
    key("cards.sprites", Kind::Integer { min: 1, max: 256 }, "", Absent::Value("32"),
        "In mode indirect: how many turned pictures of a leaf there are."),
    key("cards.sprite_texture", Kind::OneOf(&[8, 16, 32, 64, 128, 256]), "texels", Absent::Value("64"),
        "In mode indirect: their sides."),
    key("cards.scale", Kind::Choice(SpriteScale::NAMES), "", Absent::Value("\"global\""),
        "In mode indirect: leaves of one size, or each of its own."),
    key("cards.from", Kind::Number { min: 0.0, max: METRES }, "m", Absent::Rule("leaves show at every distance"),
        "Beside a model of leaves: trees whose crown's centre is farther away show impostors, at the finest level."),
    key("cards.to", Kind::Number { min: 0.0, max: METRES }, "m", Absent::Rule("four times `from`"),
        "Where impostors that stand beside leaves come to their coarsest level."),
    key("cards.mode", Kind::Choice(CardMode::NAMES), "", Absent::Rule("\"direct\""),
        "Of impostors that stand beside leaves: a texture each, or a map of leaves each and pictures of one leaf."),

    key("branches", Kind::Table, "", Absent::Value("{}"),
        "How wood and needles are drawn where `model.trunk` is \"branches\"."),
    key("branches.error", Kind::Number { min: 0.0, max: 16.0 }, "m", Absent::Rule("by distance"),
        "A fixed error, in metres of the plant."),
    key("branches.pixel_error", Kind::Number { min: 0.001, max: 100.0 }, "pixels", Absent::Value("0.5"),
        "What the error spans at the tree's nearest point, and by what lines are opaque."),
    key("branches.finest", Kind::Number { min: 0.00025, max: 16.0 }, "m", Absent::Value("0.0005"),
        "No error is less."),
    key("branches.coarsest", Kind::Number { min: 0.00025, max: 16.0 }, "m", Absent::Value("0.22"),
        "The error of the coarsest of the levels in mode levels, and of `model.trunk_level` 1."),
    key("branches.shares", Kind::Choice(BranchShares::NAMES), "", Absent::Value("\"sound\""),
        "The parts of the error add up to it, or each is all of it."),
    key("branches.frames", Kind::Choice(BranchFrames::NAMES), "", Absent::Value("\"double-reflection\""),
        "How frames go from node to node; the paper projects."),
    key("branches.torsion", Kind::Number { min: 0.0, max: 180.0 }, "degrees", Absent::Value("60"),
        "How far both ends of a merge may lean from it together."),
    key("branches.needles", Kind::Choice(NeedleMerging::NAMES), "", Absent::Value("\"sound\""),
        "Needles merge with what is near and keep their area, or as in the paper."),
    key("branches.most_edges", Kind::Integer { min: 3, max: 128 }, "edges", Absent::Value("64"),
        "The most edges of a circle."),
    key("branches.line_alpha", Kind::Choice(BranchAlpha::NAMES), "", Absent::Value("\"coverage\""),
        "Lines are as opaque as they cover pixels, as they would where the error spans `pixel_error`, or as in the paper."),
    key("branches.line_normals", Kind::Choice(BranchLines::NAMES), "", Absent::Value("\"round\""),
        "Lines are lit as cylinders, by one normal, or are three with a normal each."),
    key("branches.removal", Kind::Choice(BranchRemoval::NAMES), "", Absent::Value("\"distance\""),
        "Branches go by how far they reach, or by volume while nothing else is simplified."),

    key("painting", Kind::Table, "", Absent::Value("{}"),
        "How trees are painted where the model draws strokes."),
    key("painting.look", Kind::Choice(PaintLook::NAMES), "", Absent::Value("\"oil\""),
        "Opaque dabs on canvas, or translucent ones on rough paper."),
    key("painting.distances", Kind::Ascending { max: 100_000, most: limits::PAINT_ROWS }, "% of a leaf", Absent::Rule("100, 250 and 600"),
        "Of each row after the first: how far leaves may lie apart that become one stroke."),
    key("painting.strokes", Kind::Descending { max: 16_000_000, most: limits::PAINT_ROWS }, "strokes", Absent::Rule("as `distances` say"),
        "Of each row after the first: how many strokes it has; the distances are searched."),
    key("painting.angles", Kind::Ascending { max: 90, most: limits::PAINT_ROWS }, "degrees", Absent::Value("[45, 60, 90]"),
        "Of each row after the first: how far leaves may be turned that become one stroke."),
    key("painting.hulls", Kind::Integer { min: 1, max: 1024 }, "", Absent::Value("35"),
        "Nested hulls that part the leaves into shells; where fewer can be peeled, all are used."),
    key("painting.core_percent", Kind::Integer { min: 0, max: 100 }, "%", Absent::Value("10"),
        "The innermost hull is the smallest that holds so much of the leaves."),
    key("painting.at_once", Kind::Integer { min: 2, max: 64 }, "strokes", Absent::Value("4"),
        "At most so many strokes become one from a row to the next."),
    key("painting.inward", Kind::Number { min: 0.0, max: 100.0 }, "", Absent::Value("1"),
        "How much larger thresholds are in the innermost shell, as a share of their own."),
    key("painting.branch_least", Kind::Integer { min: 1, max: 16 }, "strokes", Absent::Value("3"),
        "What a branch has at its coarsest level."),
    key("painting.branch_step", Kind::Integer { min: 0, max: 16 }, "strokes", Absent::Value("1"),
        "How many each finer level has more; branches on the last branching level have none."),
    key("painting.full_distance", Kind::Number { min: 0.001, max: METRES }, "m", Absent::Value("12"),
        "Up to here all strokes are wanted; then leaves' fall with the square of the distance."),
    key("painting.least_pixels", Kind::Number { min: 0.0, max: 10_000.0 }, "pixels", Absent::Value("1.5"),
        "Branches that are seen shorter are left out."),
    key("painting.leaf_scale", Kind::Number { min: 0.01, max: 100.0 }, "", Absent::Value("1.9"),
        "How much larger a dab is than the leaf that it stands for."),
    key("painting.branch_scale", Kind::Number { min: 0.01, max: 100.0 }, "", Absent::Value("1.6"),
        "How much wider a dab is than its branch."),
    key("painting.grain", Kind::Number { min: 0.0, max: 1.0 }, "", Absent::Value("0.6"),
        "How much of the canvas or paper shows through the paint."),
    key("painting.seed", Kind::Integer { min: 0, max: u64::MAX }, "", Absent::Rule("the scene's"),
        "What brushes and hues are drawn from."),
    key("painting.mark", Kind::Choice(PaintMark::NAMES), "", Absent::Value("\"none\""),
        "Strokes that stand for several leaves in red, as figures have them."),

    key("grove", Kind::Table, "", Absent::Rule("forests of patches are drawn tree by tree"),
        "Draws the wood and needles of forests whose `layout` is \"patches\" by instancing: all trees of a patch at once."),
    key("grove.levels", Kind::Integer { min: 1, max: 8 }, "levels", Absent::Value("8"),
        "How many levels a patch has, from `branches.finest` to `branches.coarsest`."),
    key("grove.packing", Kind::Choice(GrovePacking::NAMES), "", Absent::Value("\"patches\""),
        "A draw has all trees of a patch, or one of them."),
    key("grove.levels_a_pass", Kind::Integer { min: 1, max: 8 }, "levels", Absent::Value("1"),
        "Lines are drawn one level at a time, from far to near, or several at a time, from near to far."),
    key("grove.order", Kind::Choice(GroveOrder::NAMES), "", Absent::Value("\"host\""),
        "Patches of a level are sorted from far to near on the host, on the device, or not."),
    key("grove.blend", Kind::Choice(GroveBlend::NAMES), "", Absent::Value("\"writes-depth\""),
        "Lines write depth as in the paper, or only test it, or every fragment is sorted; or a way that needs no order."),
    key("grove.layers", Kind::Integer { min: 1, max: 32 }, "layers", Absent::Rule("8 of what is \"peeled\""),
        "How many layers are peeled, each by a pass over all lines."),

    key("device", Kind::Table, "", Absent::Value("{}"),
        "The simulated device."),
    key("device.memory", Kind::Bytes { most: limits::DEVICE_BYTES }, "bytes", Absent::Value("\"256 MiB\""),
        "What fits on the device."),
    key("device.link", Kind::Text, "", Absent::Value("\"pcie1x16\""),
        "The bus between host and device."),
    key("device.card", Kind::Text, "", Absent::Value("\"geforce6800\""),
        "The profile that models GPU time."),

    key("golden", Kind::Table, "", Absent::Rule("nothing is compared"),
        "What `spinney golden` compares with a stored reference."),
    key("golden.size", Kind::Size { side: limits::GOLDEN_SIDE }, "pixels", Absent::Value("[160, 120]"),
        "Width and height of the reference images."),
    key("golden.frames", Kind::Ascending { max: FRAME_MAX - 1, most: limits::GOLDEN_FRAMES }, "frames", Absent::Value("[0]"),
        "The frames that are compared, each below the scene's `frames`."),
    key("golden.tolerance", Kind::Integer { min: 0, max: 255 }, "of 255 a channel", Absent::Value("0"),
        "The largest difference that passes."),
    key("golden.reason", Kind::Text, "", Absent::Rule("required with a tolerance above 0"),
        "Why the tolerance is right."),
];

const fn key(
    path: &'static str,
    kind: Kind,
    unit: &'static str,
    absent: Absent,
    meaning: &'static str,
) -> Key {
    Key {
        path,
        kind,
        unit,
        absent,
        meaning,
    }
}

/// The keys as plain text, for `spinney help scene`.
#[must_use]
pub fn key_help() -> String {
    let mut help = String::new();
    for key in KEYS {
        let unit = match key.unit {
            "" => String::new(),
            unit => format!(" ({unit})"),
        };
        help += &format!("{}\n    {}\n", key.path, key.meaning);
        let values = format!("{}{unit}; {}", key.kind.wanted(), key.absent.shown());
        let mut width = 0;
        for word in values.split(' ') {
            let length = 1 + word.chars().count();
            if width == 0 || width + length > HELP_WIDTH {
                help += if width == 0 { "    " } else { "\n    " };
                width = 3;
            } else {
                help.push(' ');
            }
            help += word;
            width += length;
        }
        help.push('\n');
    }
    help
}

/// Characters of a line of help, where words allow it.
const HELP_WIDTH: usize = 140;
