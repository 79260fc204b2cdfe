//! What went wrong, and which exit code says so.

use crate::document::DocumentError;
use crate::explain::ExplainError;
use crate::golden::GoldenError;
use crate::gpu::GpuError;
use crate::plant::GrowError;
use crate::plant::gltf::ExportError;
use crate::plant::import::ImportError;
use crate::report::ReportError;
use crate::run::RunError;
use crate::scene::SceneError;

/// Whether a stated budget was exceeded.
fn is_budget(error: &RunError) -> bool {
    matches!(
        error,
        RunError::Gpu(GpuError::OutOfMemory { .. } | GpuError::OutOfHostMemory { .. })
            | RunError::TooMany { .. }
    )
}

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
pub(super) enum CliError {
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Document(#[from] DocumentError),
    #[error(transparent)]
    Import(#[from] ImportError),
    #[error(transparent)]
    Export(#[from] ExportError),
    #[error("{file}: {source}")]
    Grow { file: String, source: GrowError },
    #[error(transparent)]
    Run(#[from] RunError),
    #[error(transparent)]
    Explain(#[from] ExplainError),
    #[error(transparent)]
    Golden(#[from] GoldenError),
    #[error(transparent)]
    Report(#[from] ReportError),
    #[error("{0}")]
    Usage(String),
    #[error("{place}: {problem}")]
    Write { place: String, problem: String },
}

impl CliError {
    /// The exit code.
    pub(super) fn code(&self) -> u8 {
        match self {
            Self::Run(error) if is_budget(error) => 3,
            Self::Explain(ExplainError::Run(error)) if is_budget(error) => 3,
            Self::Golden(GoldenError::Run { source, .. }) if is_budget(source) => 3,
            Self::Report(error) if error.is_write() => 4,
            Self::Golden(error) if error.is_write() => 4,
            Self::Write { .. } => 4,
            Self::Scene(_)
            | Self::Document(_)
            | Self::Import(_)
            | Self::Export(_)
            | Self::Grow { .. }
            | Self::Run(_)
            | Self::Explain(_)
            | Self::Golden(_)
            | Self::Report(_)
            | Self::Usage(_) => 2,
        }
    }
}
