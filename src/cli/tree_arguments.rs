//! What can be asked for of a tree of one's own.

use std::path::PathBuf;

use clap::Args;
use clap::builder::PossibleValuesParser;

use crate::plant::import::{Format, ImportOptions, Reading, Unit, UpAxis};

/// How a plant's file is to be read where it does not say it, or says it wrongly.
#[derive(Debug, Args)]
pub(super) struct PlantFileOptions {
    /// Format of a plant file [default: by its content, then its ending]
    #[arg(long, value_name = "FORMAT", value_parser = PossibleValuesParser::new(Format::NAMES))]
    pub(super) format: Option<String>,
    /// Axis of a plant file that points up [default: the format's own, or a guess]
    #[arg(long, value_name = "AXIS", value_parser = PossibleValuesParser::new(UpAxis::NAMES))]
    pub(super) up: Option<String>,
    /// Unit of a plant file's lengths [default: the format's own, or a guess]
    #[arg(long, value_name = "UNIT", value_parser = PossibleValuesParser::new(Unit::NAMES))]
    pub(super) unit: Option<String>,
    /// Group, object, node, mesh or material of a plant file that is foliage; may be given several times
    #[arg(long, value_name = "NAME")]
    pub(super) foliage: Vec<String>,
    /// Seed of the individual, or of leaves that a file only counts
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(super) seed: u64,
}

impl PlantFileOptions {
    /// What an importer is told.
    pub(super) fn import_options(&self) -> ImportOptions {
        let named = |name: &Option<String>| name.clone().unwrap_or_default();
        ImportOptions {
            reading: Reading {
                format: Format::from_name(&named(&self.format)),
                up: UpAxis::from_name(&named(&self.up)),
                unit: Unit::from_name(&named(&self.unit)),
            },
            foliage: self.foliage.clone(),
            seed: self.seed,
        }
    }
}

#[derive(Debug, Args)]
pub(super) struct BuildOptions {
    /// Plant of any format, or species
    pub(super) file: PathBuf,
    #[command(flatten)]
    pub(super) plant: PlantFileOptions,
    /// Most levels of leaves, and of branches
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u32).range(1..=32))]
    pub(super) levels: u32,
    /// Sides of an impostor's texture, in texels
    #[arg(long, value_name = "N", default_value_t = 256, value_parser = clap::value_parser!(u32).range(8..=2048))]
    pub(super) texture: u32,
    /// Greatest difference from full detail that goes unseen, as FLIP from 0 to 1, the mean where anything
    /// shows: decides at which size a coarser level shows
    #[arg(long, value_name = "FLIP", default_value_t = 0.15, value_parser = tolerance)]
    pub(super) tolerance: f64,
}

#[derive(Debug, Args)]
pub(super) struct CompareArguments {
    /// Plant of any format, or species
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
    /// Greatest difference from full detail that goes unseen, as FLIP from 0 to 1, the mean where anything shows
    #[arg(long, value_name = "FLIP", default_value_t = 0.15, value_parser = tolerance)]
    pub(super) tolerance: f64,
}

fn tolerance(text: &str) -> Result<f64, String> {
    let found = text.parse::<f64>().ok();
    let found = found.filter(|number| (0.0..=1.0).contains(number));
    found.ok_or_else(|| "wanted a number from 0 to 1".to_owned())
}
