//! What can be asked for of a tree of one's own.

use std::path::PathBuf;

use clap::Args;

/// What a plant's file does not say.
#[derive(Debug, Args)]
pub(super) struct PlantFileOptions {
    /// Node, mesh or material of a plant file that is foliage; may be given several times
    #[arg(long, value_name = "NAME")]
    pub(super) foliage: Vec<String>,
    /// Seed of the individual that grows from a species
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(super) seed: u64,
}

#[derive(Debug, Args)]
pub(super) struct BuildOptions {
    /// Plant (.glb, .gltf) or species
    pub(super) file: PathBuf,
    #[command(flatten)]
    pub(super) plant: PlantFileOptions,
    /// Most levels of leaves, and of branches
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u32).range(1..=32))]
    pub(super) levels: u32,
    /// Sides of an impostor's texture, in texels
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(8..=2048))]
    pub(super) texture: u32,
    /// Greatest difference from full detail that goes unseen, as FLIP from 0 to 1: decides at which size a
    /// coarser level shows
    #[arg(long, value_name = "FLIP", default_value_t = 0.05, value_parser = tolerance)]
    pub(super) tolerance: f64,
}

#[derive(Debug, Args)]
pub(super) struct CompareArguments {
    /// Plant (.glb, .gltf) or species
    pub(super) file: PathBuf,
    #[command(flatten)]
    pub(super) plant: PlantFileOptions,
    /// Pixels of the picture's side at the nearest distance
    #[arg(long, value_name = "N", default_value_t = 512, value_parser = clap::value_parser!(u32).range(16..=2048))]
    pub(super) side: u32,
    /// Distances, each twice the one before
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u32).range(1..=8))]
    pub(super) distances: u32,
    /// Sides of a card's texture, in texels
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(8..=2048))]
    pub(super) texture: u32,
    /// Greatest difference from full detail that goes unseen, as FLIP from 0 to 1
    #[arg(long, value_name = "FLIP", default_value_t = 0.05, value_parser = tolerance)]
    pub(super) tolerance: f64,
}

fn tolerance(text: &str) -> Result<f64, String> {
    let found = text.parse::<f64>().ok();
    let found = found.filter(|number| (0.0..=1.0).contains(number));
    found.ok_or_else(|| "wanted a number from 0 to 1".to_owned())
}
