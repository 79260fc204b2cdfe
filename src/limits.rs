//! Limits: how much of anything a file, a scene or a program may ask for, all in one place.
//!
//! ```text
//! bytes ──▶ document, plant, report: readers ──▶ scene, plant ──▶ run: world ──▶ gpu ──▶ report
//!            file bytes, nesting, counts          counts, sides    leaves         bytes     bytes
//! ```
//!
//! **Invariant.** What is read, grown, built or written is bounded by these numbers, and refused
//! with the number found and the limit before it takes more. They are far above what trees need, and
//! low enough that no file makes a machine with 16 GiB swap.
//!
#![doc = include_str!("limits.md")]

/// A limit, for tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limit {
    /// The constant's name.
    pub name: &'static str,
    /// The most that is taken.
    pub most: u64,
    /// Of what.
    pub unit: &'static str,
    /// What is limited, and why to so much.
    pub why: &'static str,
}

/// Constants and the table of them all.
macro_rules! limits {
    ($($(#[doc = $why:literal])+ $name:ident: $number:ty = $most:literal, $unit:literal;)+) => {
        $($(#[doc = $why])+ ///
        #[doc = concat!("Unit: ", $unit, ".")]
        pub const $name: $number = $most;)+

        /// Every limit, from what is read to what is written.
        pub const LIMITS: &[Limit] = &[$(Limit {
            name: stringify!($name),
            most: $most,
            unit: $unit,
            why: concat!($($why),+),
        }),+];
    };
}

limits! {
    /// A scene or species file: 20,000 trees and 10,000 keys of the camera's path take half of it.
    TEXT_BYTES: u64 = 16_777_216, "bytes";
    /// Tables and lists within each other in TOML, as its parser has it, so that no stack overflows.
    TOML_NESTING: usize = 80, "levels";
    /// Objects and lists within each other in JSON, as its parser has it.
    JSON_NESTING: usize = 127, "levels";
    /// A plant file, and all buffers of one document together; also what is written, so that it can
    /// be read again.
    PLANT_FILE_BYTES: u64 = 1_073_741_824, "bytes";
    /// A PNG file that is read as a picture.
    PICTURE_FILE_BYTES: u64 = 536_870_912, "bytes";
    /// A `ledger.json` that is compared.
    LEDGER_BYTES: u64 = 536_870_912, "bytes";
    /// A text of a run's folder that `explain` reads: of `ledger.csv`, some 100 bytes a transfer.
    RUN_TEXT_BYTES: u64 = 536_870_912, "bytes";
    /// A line of `ops.jsonl`: some ten bytes a cluster that changes.
    OPS_LINE_BYTES: usize = 268_435_456, "bytes";
    /// A line of a recorded trace of a level-of-detail structure.
    TRACE_LINE_BYTES: usize = 33_554_432, "bytes";
    /// Leaves at full detail of a recorded trace: its header names every collapse in a line.
    TRACE_LEAVES: u32 = 524_288, "leaves";
    /// Resources of a recorded trace.
    TRACE_RESOURCES: usize = 256, "resources";
    /// Resources of a recorded trace together: a line may tell them twice, in hexadecimal.
    TRACE_RESOURCE_BYTES: u64 = 4_194_304, "bytes";
    /// Entries of any list in a step of a recorded trace.
    TRACE_ENTRIES: usize = 1_048_576, "entries";
    /// States of a recorded trace that are remembered, to be compared when they come again.
    TRACE_STATES: usize = 65_536, "states";
    /// Steps of a recorded trace times leaves, old and new: what a check looks at, in minutes.
    TRACE_WORK: u64 = 68_719_476_736, "leaves";

    /// A line of the file by which shards are joined.
    SHARD_LINE_BYTES: usize = 268_435_456, "bytes";
    /// Folders that are joined.
    SHARDS: usize = 4096, "folders";
    /// Kinds of causes that are read from files: they are kept as long as the program runs.
    READ_CAUSES: usize = 256, "kinds";
    /// Such a kind.
    READ_CAUSE_BYTES: usize = 64, "bytes";

    /// A text in a scene: a name or a path.
    TEXT_CHARACTERS: usize = 400, "characters";
    /// Names of foliage that a tree of a scene lists.
    FOLIAGE_NAMES: usize = 10_000, "names";
    /// Trees of a scene; what they show together is limited by `STANDING_LEAVES`.
    SCENE_TREES: usize = 20_000, "trees";
    /// Forests of a scene; their trees count among `SCENE_TREES`.
    SCENE_FORESTS: usize = 64, "forests";
    /// Species of a forest: each is a plant of its own.
    FOREST_SPECIES: usize = 64, "species";
    /// Impostors that stand for the leaves of a crown, each with textures of its own.
    CARDS: u32 = 1024, "impostors";
    /// Levels of detail of impostors.
    CARD_LEVELS: usize = 8, "levels";
    /// Rows of leaf strokes after the first, which has one a leaf.
    PAINT_ROWS: usize = 8, "rows";
    /// Cells a side of a scene's ground, of two triangles each.
    TERRAIN_CELLS: u64 = 1024, "cells";
    /// Keys of the camera's path.
    CAMERA_KEYS: usize = 10_000, "keys";
    /// Frames of a scene: most of an hour at 30 a second.
    SCENE_FRAMES: u32 = 100_000, "frames";
    /// Frames that are compared with references, each a file.
    GOLDEN_FRAMES: usize = 64, "frames";
    /// Width or height of a reference: references are kept beside the code.
    GOLDEN_SIDE: u32 = 160, "pixels";
    /// A reference file: a repository holds hundreds of them.
    GOLDEN_BYTES: u64 = 32_768, "bytes";

    /// Width or height of a frame, and of any render target.
    IMAGE_SIDE: u32 = 16_384, "pixels";
    /// Pixels of a frame: room for 7680 × 4320. A pixel takes up to 36 bytes a sample.
    IMAGE_PIXELS: u32 = 33_554_432, "pixels";
    /// Width or height of a picture that is read or written: contact sheets are long.
    PICTURE_SIDE: u32 = 65_535, "pixels";
    /// Pixels of a picture: 256 MiB of them.
    PICTURE_PIXELS: u32 = 67_108_864, "pixels";
    /// Samples of all channels of an image file that is compared: 1 GiB.
    CHANNEL_SAMPLES: u64 = 268_435_456, "samples";
    /// Width or height of a texture, as of cards of the time.
    TEXTURE_SIDE: u32 = 8192, "texels";
    /// Texels of all images of a plant file together: 1 GiB.
    PLANT_TEXELS: u64 = 268_435_456, "texels";

    /// Objects in the JSON of a plant file: some 500 bytes of memory each.
    JSON_OBJECTS: u64 = 524_288, "objects";
    /// Values of any kind in the JSON of a plant file.
    JSON_VALUES: u64 = 16_777_216, "values";
    /// Elements, texts and comments in the XML of a plant file: some 80 bytes of memory each.
    XML_NODES: u32 = 16_777_216, "nodes";
    /// Primitives that a plant file places, counting each placement of a mesh.
    PLACED_PRIMITIVES: usize = 1_048_576, "primitives";
    /// Triangle corners that a foreign plant file places, counting each placement of a mesh: some 80
    /// bytes of memory each. What spinney wrote is bounded by its bytes alone.
    PLACED_CORNERS: u64 = 33_554_432, "corners";
    /// Groups of cards, and groups of other leaves, that one material of a plant file may get; rarer
    /// ones are joined.
    MATERIAL_GROUPS: usize = 64, "groups";
    /// Foliage groups of a plant file that is written: some 20 objects of JSON each.
    WRITTEN_GROUPS: usize = 16_384, "groups";

    /// Cylinders or nodes of wood that a plant file holds: up to a kilobyte of memory each, with their mesh.
    WOOD_SEGMENTS: usize = 2_000_000, "segments";
    /// Columns of a table of cylinders or of a tree graph.
    TABLE_COLUMNS: usize = 10_000, "columns";
    /// Entities that one sign of a tree graph skips, each of them a segment.
    SKIPPED_ENTITIES: u64 = 10_000, "entities";

    /// Kinds of foliage of a species: each is a material and a group of its own.
    SPECIES_KINDS: usize = 16, "kinds";
    /// Leaves that a species leaves out by number.
    OMITTED_LEAVES: usize = 65_536, "leaves";
    /// Points of one stem with its clones while a plant grows.
    STEM_POINTS: usize = 1_000_000, "points";
    /// Points of a plant while it grows, discarded attempts included: about ten seconds.
    GROWTH_POINTS: usize = 50_000_000, "points";
    /// Branches that a plant grows.
    GROWN_BRANCHES: usize = 1_000_000, "branches";
    /// Skeleton nodes that a plant grows.
    GROWN_NODES: usize = 4_000_000, "nodes";
    /// Leaves that a plant grows, and leaves or trunk triangles that a species asks for.
    GROWN_LEAVES: usize = 4_000_000, "leaves";
    /// Triangles of a trunk that grows without their number being asked for.
    TRUNK_TRIANGLES: usize = 16_000_000, "triangles";
    /// How often a module of a grammar is rewritten.
    RL_STEPS: u32 = 1000, "steps";
    /// Brackets of a grammar that are open at once while it grows.
    RL_DEPTH: usize = 65_536, "brackets";
    /// Expressions within each other in a grammar, so that no stack overflows.
    RL_NESTING: usize = 64, "levels";
    /// Modules of a grammar and operations in their numbers while it grows: about a second.
    RL_WORK: u64 = 33_554_432, "operations";
    /// Leaves of one plant, wherever it comes from.
    PLANT_LEAVES: usize = 16_000_000, "leaves";
    /// Vertices of one mesh or of a foliage.
    PLANT_VERTICES: usize = 128_000_000, "vertices";
    /// Faces of all leaves of several faces of one plant: 36 bytes each on the device.
    PLANT_FACES: usize = 32_000_000, "faces";

    /// Bytes of all plant and species files that a run keeps copies of.
    COPIED_BYTES: u64 = 2_147_483_648, "bytes";
    /// Leaves of all different plants that are kept for the next scene: some hundred bytes each.
    KEPT_LEAVES: usize = 1_048_576, "leaves";
    /// Bytes of all built models that a cache keeps: 28 a collapse.
    CACHE_BYTES: u64 = 1_073_741_824, "bytes";
    /// Built models that a cache keeps.
    CACHE_FILES: usize = 4096, "files";
    /// Leaves of all different plants of a scene together.
    WORLD_LEAVES: u64 = 16_000_000, "leaves";
    /// Trunk triangles, and faces of leaves of several faces, of all different plants of a scene
    /// together.
    WORLD_TRIANGLES: u64 = 32_000_000, "triangles";
    /// Leaves of all trees of a scene together, each plant counted as often as it stands, and every two
    /// faces of leaves of several faces as a leaf.
    STANDING_LEAVES: u64 = 1_000_000_000, "leaves";
    /// Buffers in host memory of the simulated machine, all together. Device memory is limited by
    /// `device.memory` of the scene, and by `DEVICE_BYTES`.
    HOST_BYTES: u64 = 4_294_967_296, "bytes";
    /// Device memory that a scene may ask for: what the simulator then takes is a few times as much.
    DEVICE_BYTES: u64 = 4_294_967_296, "bytes";

    /// The list of files in a folder that is written: 100,000 frames with layers take a twentieth.
    MARKER_BYTES: u64 = 67_108_864, "bytes";
    /// Folders within each other in a folder that is written.
    FOLDER_DEPTH: usize = 16, "levels";
    /// Pictures of a page.
    PAGE_IMAGES: usize = 24, "pictures";
    /// A page with its pictures.
    PAGE_BYTES: usize = 8_000_000, "bytes";
}

/// The limits as plain text, for `spinney help limits`.
#[must_use]
pub fn limit_help() -> String {
    LIMITS.iter().fold(String::new(), |help, limit| {
        let Limit {
            name,
            most,
            unit,
            why,
        } = limit;
        help + &format!("{}\n    {most} {unit}\n   {why}\n", name.to_lowercase())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn documentation_tells_what_the_table_says() {
        let mut table =
            "| limit | most | unit | of what, and why |\n|---|---:|---|---|\n".to_owned();
        for limit in LIMITS {
            let (name, most) = (limit.name, limit.most);
            table += &format!("| [`{name}`] | {most} | {} |{} |\n", limit.unit, limit.why);
        }
        // To renew: write the left side to limits.md.
        assert_eq!(table, include_str!("limits.md"));
    }
}
