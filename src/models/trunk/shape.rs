//! What every model of a trunk is built from.

use std::sync::Arc;

use crate::plant::{Mesh, Plant};

/// The trunk of a plant; shared by all models of it.
#[derive(Debug, Clone)]
pub struct Trunk {
    /// Has a trunk.
    plant: Arc<Plant>,
}

impl Trunk {
    /// The trunk of a plant, if it has one.
    #[must_use]
    pub fn of(plant: &Arc<Plant>) -> Option<Self> {
        plant.trunk()?;
        Some(Self {
            plant: Arc::clone(plant),
        })
    }

    /// Its full detail.
    #[must_use]
    #[expect(clippy::missing_panics_doc, reason = "no input reaches it")]
    pub fn mesh(&self) -> &Mesh {
        self.plant.trunk().expect("only a plant with one is kept")
    }
}
