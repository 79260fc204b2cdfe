//! What a scene builds and shows, as five digests and one over them.

use std::fmt;

use crate::math::{Digest, Digester};
use crate::models::Crown;
use crate::run::Frame;

/// The digests of a scene: equal on every machine, or something is not determined.
///
/// Each is BLAKE3 over a domain, then:
///
/// | part | domain | what follows |
/// |---|---|---|
/// | `plants` | `golden.plants/1` | the digest of every plant, in the order of the scene |
/// | `collapses` | `golden.collapses/1` | the digest of every plant's collapses |
/// | `models` | `golden.models/1` | the bytes that the scene's model of every plant keeps on the host |
/// | `images` | `golden.images/1` | the digest of every frame's picture |
/// | `ledgers` | `golden.ledgers/1` | every frame's ledger as a table |
///
/// Digests are added as they are; bytes and texts with their length before them, as a
/// [`Digester`] does.
///
/// Prints as a line: `SCENE ALL plants=… collapses=… models=… images=… ledgers=…`, [`all`](Self::all)
/// in full, the parts as their first 16 hexadecimal digits.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneDigests {
    /// The scene's path below the folder of scenes, without its ending.
    pub scene: String,
    /// Of what is grown or imported.
    pub plants: Digest,
    /// Of what simplification does with it.
    pub collapses: Digest,
    /// Of what the model makes of both.
    pub models: Digest,
    /// Of what is seen.
    pub images: Digest,
    /// Of what it cost.
    pub ledgers: Digest,
}

impl SceneDigests {
    /// The names of the parts, in order.
    pub const PARTS: [&'static str; 5] = ["plants", "collapses", "models", "images", "ledgers"];

    /// The parts, in order.
    #[must_use]
    pub fn parts(&self) -> [Digest; 5] {
        [
            self.plants,
            self.collapses,
            self.models,
            self.images,
            self.ledgers,
        ]
    }

    /// The digest over all parts: BLAKE3 over the domain `golden.scene/1`, then the parts in order.
    #[must_use]
    pub fn all(&self) -> Digest {
        let mut digester = Digester::new("golden.scene/1");
        for part in self.parts() {
            digester.raw(&part.0);
        }
        digester.finish()
    }
}

impl fmt::Display for SceneDigests {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} {}", self.scene, self.all())?;
        for (name, part) in Self::PARTS.iter().zip(self.parts()) {
            let part = part.to_string();
            write!(out, " {name}={}", part.get(..16).unwrap_or_default())?;
        }
        Ok(())
    }
}

/// A line a scene, as in `digests.txt`.
#[must_use]
pub fn digest_text(digests: &[SceneDigests]) -> String {
    digests
        .iter()
        .map(|digests| format!("{digests}\n"))
        .collect()
}

/// Collects the digests of a scene.
#[derive(Debug)]
pub(super) struct DigestParts {
    plants: Digester,
    collapses: Digester,
    models: Digester,
    images: Digester,
    ledgers: Digester,
}

impl DigestParts {
    pub(super) fn new() -> Self {
        Self {
            plants: Digester::new("golden.plants/1"),
            collapses: Digester::new("golden.collapses/1"),
            models: Digester::new("golden.models/1"),
            images: Digester::new("golden.images/1"),
            ledgers: Digester::new("golden.ledgers/1"),
        }
    }

    /// Adds a crown and what its model keeps on the host.
    pub(super) fn crown(&mut self, crown: &Crown, host_bytes: &[u8]) {
        self.plants.raw(&crown.plant().digest().0);
        self.collapses.raw(&crown.sequence().digest().0);
        self.models.bytes(host_bytes);
    }

    /// Adds a frame and its table.
    pub(super) fn frame(&mut self, frame: &Frame, table: &str) {
        self.images.raw(&frame.image_digest.0);
        self.ledgers.text(table);
    }

    pub(super) fn finish(&self, scene: &str) -> SceneDigests {
        SceneDigests {
            scene: scene.to_owned(),
            plants: self.plants.finish(),
            collapses: self.collapses.finish(),
            models: self.models.finish(),
            images: self.images.finish(),
            ledgers: self.ledgers.finish(),
        }
    }
}
