//! What can be asked for, by `clap`.

use std::ops::Range;
use std::path::PathBuf;

use clap::{Args, CommandFactory as _, Parser, Subcommand, ValueEnum};

use super::tree_arguments::{BuildOptions, CompareArguments, PlantFileOptions};
use crate::gpu::{Card, Link};
use crate::limits::DEVICE_BYTES;
use crate::run::Shard;

/// Renders trees at any level of detail on a GPU that exists only in software, and counts every
/// byte over its bus.
#[derive(Debug, Parser)]
#[command(version, disable_help_subcommand = true, max_term_width = 100)]
pub(super) struct Arguments {
    #[command(flatten)]
    pub(super) shared: Shared,
    #[command(subcommand)]
    pub(super) command: Command,
}

/// Flags of every command.
#[derive(Debug, Args)]
pub(super) struct Shared {
    /// Folder or file to write, default `out/<scene>`
    #[arg(short, long, global = true, value_name = "PATH")]
    pub(super) out: Option<PathBuf>,
    /// Threads to use, default all; results never depend on it
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) threads: Option<u16>,
    /// Link for modelled times, in place of the scene's: agp1x … agp8x, pcie1x16 … pcie5x16
    #[arg(long, global = true, value_name = "NAME", value_parser = link)]
    pub(super) link: Option<Link>,
    /// Card for modelled times, in place of the scene's: geforce6800, geforce6800gt, fx5200, gtx770
    #[arg(long, global = true, value_name = "NAME", value_parser = card)]
    pub(super) card: Option<Card>,
    #[command(flatten)]
    pub(super) models: Models,
    /// Print machine-readable JSON
    #[arg(long, global = true)]
    pub(super) json: bool,
    /// Print nothing but results and errors
    #[arg(long, global = true)]
    pub(super) quiet: bool,
    /// Colour in the terminal
    #[arg(long, global = true, value_enum, default_value_t = Color::Auto)]
    pub(super) color: Color,
}

/// Where built models are kept: for the commands that show a scene's plants.
#[derive(Debug, Args)]
pub(super) struct Models {
    /// Folder of built models, default `spinney` in the user's cache; results never depend on it
    #[arg(long, global = true, value_name = "DIR", conflicts_with = "no_cache")]
    pub(super) cache: Option<PathBuf>,
    /// Build all models anew and keep none
    #[arg(long, global = true)]
    pub(super) no_cache: bool,
}

/// When to colour.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Color {
    /// On a terminal, unless `NO_COLOR` is set
    Auto,
    /// Always
    Always,
    /// Never
    Never,
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    /// Render a scene's frames, counting traffic
    Run(RunOptions),
    /// Walk the axis of detail from 0 to 1 for several models
    Sweep(SweepOptions),
    /// Draw levels as they are asked for, a line each on standard input
    ///
    /// A line is a level from 0, full detail, to 1, and may name a frame of the camera's path, such as
    /// `0.25` or `0.25 12`; or `model LABEL`, as of `sweep --models` or that of cards such as
    /// `impostors-direct`, which begins anew at full detail. Every line is answered by one of JSON: what the
    /// change of detail and drawing took, as a frame in `ledger.json`; first comes one that tells what was
    /// sent before. A line that says nothing known is answered by an `error`. With `-o FILE.png`, or
    /// `FILE.rgba` for bare rows of R, G, B, A from the top, FILE is replaced before each answer.
    Step(StepOptions),
    /// Measure how each plant's foliage moves when the camera moves sideways, model by model
    Parallax(ParallaxOptions),
    /// Hold what stands in for leaves against them: looks at three scales, bytes, frame times
    StandIns(StandInArguments),
    /// Branches as polygons and lines, at a list of errors
    Branches(BranchArguments),
    /// Paint a plant at its levels: figures, strokes, modelled times, storage, and how still the paint lies
    Paint(PaintArguments),
    /// Join the folders of all shards of a run or sweep
    Merge(MergeOptions),
    /// Storage table: original, VDF, LoDF, by the papers' accounting and by true sizes
    Storage(StorageOptions),
    /// Tell what a scene, species, plant or image holds
    Inspect(InspectOptions),
    /// Generate a plant from a species file
    Grow(GrowOptions),
    /// Make levels of detail of an own tree, for other programs
    Build(BuildOptions),
    /// Hold every scheme against the others on an own tree: bytes, error, times, and which to take
    Compare(CompareArguments),
    /// Compare scenes with what they showed when somebody last looked
    Golden(GoldenOptions),
    /// Compare two images or two run folders
    Diff(DiffOptions),
    /// Tell which leaf a pixel of a run shows and why, or where two runs part
    Explain(ExplainOptions),
    /// Check a recorded trace of a level-of-detail structure against the laws
    CheckTrace(CheckTraceOptions),
    /// Run the shipped broken models; fails unless each is caught
    Selftest,
    /// Explain the commands, the keys of scene or species files, or the limits
    Help(HelpOptions),
}

/// How frames are drawn.
#[derive(Debug, Args)]
pub(super) struct Drawing {
    /// Pixels of a frame, such as 640x480, in place of the scene's
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Option<(u32, u32)>,
    /// Samples a pixel, 1 or 4, in place of the scene's
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4))]
    pub(super) samples: Option<u32>,
    /// Frames to draw, such as 0..10; earlier ones are selected and committed, not drawn
    #[arg(long, value_name = "A..B", value_parser = frames)]
    pub(super) frames: Option<Range<u32>>,
    /// `exact` rasterizes everything and models the card's time, `visible` is faster
    #[arg(long, value_enum)]
    pub(super) counters: Option<CounterChoice>,
    /// Draw every N-th frame or step from the I-th on; all are selected and committed, and
    /// `spinney merge` joins the shards
    #[arg(long, value_name = "I/N", value_parser = shard)]
    pub(super) shard: Option<Shard>,
}

/// Which counters are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum CounterChoice {
    /// Architectural counters only
    Visible,
    /// Everything is rasterized and counted
    Exact,
}

#[derive(Debug, Args)]
pub(super) struct RunOptions {
    /// Scene file
    pub(super) scene: PathBuf,
    #[command(flatten)]
    pub(super) drawing: Drawing,
    /// Also write each frame's data layers as EXR
    #[arg(long)]
    pub(super) layers: bool,
    /// Most payload bytes that changes of detail upload in a frame, in place of the scene's; neither
    /// the view nor what is there before the first frame counts
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=DEVICE_BYTES))]
    pub(super) budget_bytes: Option<u64>,
    /// By which share of the range of distances, 0 to 0.5, detail must be off before it changes, in place
    /// of the scene's
    #[arg(long, value_name = "X", value_parser = hysteresis)]
    pub(super) hysteresis: Option<f32>,
    /// Also tell which pixels switches of detail alone change; draws each frame thrice
    #[arg(long)]
    pub(super) popping: bool,
    /// Also write what each frame draws, for other renderers, into a folder of its own: triangles and
    /// textures as glTF, the camera as JSON
    #[arg(long, value_name = "DIR")]
    pub(super) export_frame: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(super) struct SweepOptions {
    /// Scene file
    pub(super) scene: PathBuf,
    #[command(flatten)]
    pub(super) drawing: Drawing,
    /// Models to walk, such as lodf-slots,lodf-stamps; default all that fit
    #[arg(long, value_name = "A,B,C", value_delimiter = ',')]
    pub(super) models: Vec<String>,
    /// Steps from full detail to the coarsest
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(super) steps: u32,
    /// Also tell what the levels do to the picture: covered pixels, silhouettes, FLIP, SSIM
    #[arg(long)]
    pub(super) quality: bool,
    /// Levels to look at beyond full detail, evenly chosen from the steps
    #[arg(long, value_name = "N", requires = "quality", default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(super) quality_steps: u32,
    /// Bytes alone, of each plant of the scene by itself, on the papers' agp8x and on pcie5x16, or on
    /// that of --link; draws nothing, so it is quick
    #[arg(long, conflicts_with_all = ["quality", "size", "samples", "frames", "counters", "shard"])]
    pub(super) bytes: bool,
}

#[derive(Debug, Args)]
pub(super) struct StepOptions {
    /// Scene file
    pub(super) scene: PathBuf,
    /// Pixels of a picture, such as 640x480, in place of the scene's
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Option<(u32, u32)>,
    /// Samples a pixel, 1 or 4, in place of the scene's
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4))]
    pub(super) samples: Option<u32>,
    /// `exact` rasterizes everything and models the card's time, `visible` is faster
    #[arg(long, value_enum)]
    pub(super) counters: Option<CounterChoice>,
}

#[derive(Debug, Args)]
pub(super) struct ParallaxOptions {
    /// Scene file
    pub(super) scene: PathBuf,
    /// Models to measure, such as lodf-stamps@50,lodf-stamps@90: the number says how far towards its
    /// coarsest level, in hundredths
    #[arg(long, value_name = "A,B,C", value_delimiter = ',')]
    pub(super) models: Vec<String>,
    /// Pixels of a side of the pictures
    #[arg(long, value_name = "N", default_value_t = 512, value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub(super) side: u32,
    /// Steps that the camera moves sideways, over 45 degrees of the tree
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=32))]
    pub(super) steps: u32,
}

#[derive(Debug, Args)]
pub(super) struct StandInArguments {
    /// Scene file; its first plant is looked at, foliage alone, on a screen of its size and angle
    pub(super) scene: PathBuf,
    /// Pixels of the screen, such as 640x480, in place of the scene's
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Option<(u32, u32)>,
    /// Cards to hold against leaves, such as impostors-direct; lodf-host tells what leaves take that lie in
    /// host memory
    #[arg(
        long,
        value_name = "A,B,C",
        value_delimiter = ',',
        default_value = "impostors-direct,lodf-host"
    )]
    pub(super) models: Vec<String>,
    /// Numbers of planes in which leaves are flattened and impostors stand
    #[arg(long, value_name = "N,N", value_delimiter = ',', default_value = "4,8,16,32,64,128", value_parser = clap::value_parser!(u32).range(1..=i64::from(crate::limits::CARDS)))]
    pub(super) planes: Vec<u32>,
    /// What is looked at
    #[arg(
        long,
        value_enum,
        value_name = "A,B,C",
        value_delimiter = ',',
        default_value = "looks,switches,textures"
    )]
    pub(super) parts: Vec<StandInPart>,
}

#[derive(Debug, Args)]
pub(super) struct BranchArguments {
    /// Scene file; branches are drawn as polygons and lines, whatever its `model.trunk`
    pub(super) scene: PathBuf,
    /// Pixels of a picture, such as 640x480, in place of the scene's
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Option<(u32, u32)>,
    /// Errors in metres, ascending
    #[arg(
        long,
        value_name = "M,M",
        value_delimiter = ',',
        default_value = "0.00092,0.0387,0.108,0.188,0.39",
        value_parser = error_in_metres
    )]
    pub(super) errors: Vec<f32>,
    /// What is looked at [default: transparency where the scene has a table [grove], else levels,modes]
    #[arg(long, value_enum, value_name = "A,B,C", value_delimiter = ',')]
    pub(super) parts: Vec<BranchPart>,
}

/// What `branches` looks at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum BranchPart {
    /// How each error looks, and pruning to as many primitives
    Levels,
    /// The same of a winding branch in the first plant's bark
    Helix,
    /// What each mode keeps and sends on a way through the errors and back
    Modes,
    /// How much each frame of the path differs from the one before
    Steps,
    /// Every model along the path: detail, continuity, bytes, modelled time, shadows
    Methods,
    /// Ways to draw the lines of a forest of patches, held against every fragment in its place
    Transparency,
}

/// What `stand-ins` looks at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum StandInPart {
    /// Cards against leaves, near and far, and what a frame takes
    Looks,
    /// What going over from one level of impostors to the next does to the picture
    Switches,
    /// Bytes of direct and indirect textures of impostors, at equal FLIP
    Textures,
}

#[derive(Debug, Args)]
pub(super) struct PaintArguments {
    /// Scene file; its first plant is painted as its table `painting` says
    pub(super) scene: PathBuf,
    /// Pixels of the screen, such as 640x480, in place of the scene's
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(super) size: Option<(u32, u32)>,
    /// Steps that the camera goes around the tree, of each size; 0 leaves the measure of shimmer out
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(0..=64))]
    pub(super) steps: u32,
}

#[derive(Debug, Args)]
pub(super) struct MergeOptions {
    /// Folders that were written with --shard: all of one scene, flags and count
    #[arg(required = true, value_name = "DIR")]
    pub(super) folders: Vec<PathBuf>,
}

#[derive(Debug, Args)]
pub(super) struct StorageOptions {
    /// Scene file
    pub(super) scene: PathBuf,
}

#[derive(Debug, Args)]
pub(super) struct InspectOptions {
    /// Scene, species, plant of any format, or image (.png)
    pub(super) file: PathBuf,
    #[command(flatten)]
    pub(super) plant: PlantFileOptions,
}

#[derive(Debug, Args)]
pub(super) struct GrowOptions {
    /// Species file: *.toml, a grammar *.rls, or Arbaro's *.xml
    pub(super) species: PathBuf,
    /// Seed of the individual
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(super) seed: u64,
}

#[derive(Debug, Args)]
pub(super) struct GoldenOptions {
    #[command(subcommand)]
    pub(super) command: GoldenCommand,
}

#[derive(Debug, Subcommand)]
pub(super) enum GoldenCommand {
    /// Compare pictures and ledgers with their references
    Check(GoldenCheckOptions),
    /// Replace references by what scenes show now
    Bless(GoldenBlessOptions),
    /// Print a line of digests for each scene: the same on every machine
    Digests(GoldenDigestsOptions),
}

/// Which scenes, and where their references are.
#[derive(Debug, Args)]
pub(super) struct GoldenFolders {
    /// Folder of scenes, searched at any depth
    #[arg(default_value = "scenes")]
    pub(super) folder: PathBuf,
    /// Folder of references
    #[arg(long, value_name = "DIR", default_value = "golden")]
    pub(super) golden: PathBuf,
    /// Only scenes with this in their path below the folder
    #[arg(long, value_name = "TEXT")]
    pub(super) only: Option<String>,
}

#[derive(Debug, Args)]
pub(super) struct GoldenCheckOptions {
    #[command(flatten)]
    pub(super) folders: GoldenFolders,
    /// Also print what differs so that it is shown beside the code
    #[arg(long, value_enum)]
    pub(super) annotate: Option<Annotate>,
    /// Also write what was compared as JUnit XML
    #[arg(long, value_name = "FILE")]
    pub(super) junit: Option<PathBuf>,
}

/// Who shows annotations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Annotate {
    /// GitHub Actions
    Github,
}

#[derive(Debug, Args)]
pub(super) struct GoldenBlessOptions {
    #[command(flatten)]
    pub(super) folders: GoldenFolders,
    /// Remove references that no scene keeps
    #[arg(long)]
    pub(super) remove_unused: bool,
}

#[derive(Debug, Args)]
pub(super) struct GoldenDigestsOptions {
    /// Folder of scenes
    #[arg(default_value = "scenes")]
    pub(super) folder: PathBuf,
}

#[derive(Debug, Args)]
pub(super) struct DiffOptions {
    /// What is expected: an image (.png, .exr) or a run folder
    pub(super) expected: PathBuf,
    /// What there is, of the same sort
    pub(super) actual: PathBuf,
    /// The largest difference of a pixel of a PNG, of 255, that counts as none
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(super) tolerance: u8,
}

#[derive(Debug, Args)]
pub(super) struct ExplainOptions {
    /// Folder of a run; or of two, to be told where they part
    #[arg(required = true, num_args = 1..=2, value_name = "RUN")]
    pub(super) runs: Vec<PathBuf>,
    /// Column and row of a pixel, such as 31,20, from the top left
    #[arg(long, value_name = "X,Y", value_parser = pixel)]
    pub(super) pixel: Option<(u32, u32)>,
    /// Frame of the pixel, default the run's first
    #[arg(long, value_name = "N")]
    pub(super) frame: Option<u32>,
}

#[derive(Debug, Args)]
pub(super) struct CheckTraceOptions {
    /// Trace (JSON lines, `spinney.trace/1`), or - for standard input
    pub(super) file: PathBuf,
}

#[derive(Debug, Args)]
pub(super) struct HelpOptions {
    /// What to explain
    #[arg(value_enum)]
    pub(super) topic: Option<Topic>,
}

/// What `help` explains beside the commands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Topic {
    /// The keys of scene files
    Scene,
    /// The keys of species files
    Species,
    /// How much files and scenes may ask for
    Limits,
}

/// What `spinney --help` prints.
pub(super) fn long_help() -> String {
    Arguments::command().render_long_help().to_string()
}

fn link(name: &str) -> Result<Link, String> {
    Link::named(name).ok_or_else(|| known(Link::ALL.iter().map(|link| link.name())))
}

fn card(name: &str) -> Result<Card, String> {
    Card::named(name).ok_or_else(|| known(Card::ALL.iter().map(|card| card.name())))
}

fn known<'a>(names: impl Iterator<Item = &'a str>) -> String {
    format!("wanted one of {}", names.collect::<Vec<_>>().join(", "))
}

fn error_in_metres(text: &str) -> Result<f32, String> {
    let metres = text.parse::<f32>().ok();
    metres
        .filter(|metres| (0.0..=16.0).contains(metres))
        .ok_or_else(|| "wanted metres from 0 to 16, such as 0.0387".to_owned())
}

fn size(text: &str) -> Result<(u32, u32), String> {
    let wrong = || "wanted width x height in pixels, such as 640x480".to_owned();
    let (width, height) = text.split_once('x').ok_or_else(wrong)?;
    Ok((
        number(width).ok_or_else(wrong)?,
        number(height).ok_or_else(wrong)?,
    ))
}

fn pixel(text: &str) -> Result<(u32, u32), String> {
    let wrong = || "wanted column,row in pixels, such as 31,20".to_owned();
    let (x, y) = text.split_once(',').ok_or_else(wrong)?;
    Ok((number(x).ok_or_else(wrong)?, number(y).ok_or_else(wrong)?))
}

fn frames(text: &str) -> Result<Range<u32>, String> {
    let wrong = || "wanted first..end, such as 0..10, with end after first".to_owned();
    let (first, end) = text.split_once("..").ok_or_else(wrong)?;
    let range = number(first).ok_or_else(wrong)?..number(end).ok_or_else(wrong)?;
    if range.is_empty() {
        Err(wrong())
    } else {
        Ok(range)
    }
}

fn hysteresis(text: &str) -> Result<f32, String> {
    // As the key of scenes.
    let found = text.parse().ok();
    let found = found.filter(|share| (0.0..=0.5).contains(share));
    found.ok_or_else(|| "wanted a number from 0 to 0.5".to_owned())
}

fn shard(text: &str) -> Result<Shard, String> {
    let wrong = || "wanted index/count, such as 0/4, with the index below the count".to_owned();
    let (index, count) = text.split_once('/').ok_or_else(wrong)?;
    let shard = Shard {
        index: number(index).ok_or_else(wrong)?,
        count: number(count).ok_or_else(wrong)?,
    };
    if shard.index < shard.count {
        Ok(shard)
    } else {
        Err(wrong())
    }
}

fn number(digits: &str) -> Option<u32> {
    digits.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_or_refused() {
        Arguments::command().debug_assert();
        assert_eq!(size("640x480"), Ok((640, 480)));
        assert!(size("640").is_err() && size("ax1").is_err() && size("-1x4").is_err());
        assert_eq!(pixel("31,20"), Ok((31, 20)));
        assert!(pixel("31").is_err() && pixel("31,").is_err() && pixel("-1,4").is_err());
        assert_eq!(frames("2..5"), Ok(2..5));
        assert!(frames("5..5").is_err() && frames("5").is_err());
        assert_eq!(shard("1/4"), Ok(Shard { index: 1, count: 4 }));
        assert!(shard("4/4").is_err() && shard("0/0").is_err());
        assert_eq!(hysteresis("0.05"), Ok(0.05));
        assert!(
            ["0.6", "-1", "NaN", "x"]
                .into_iter()
                .all(|text| hysteresis(text).is_err())
        );
        assert!(link("isa").is_err());
    }
}
