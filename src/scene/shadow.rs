//! Whether and how what is lit casts shadows.

/// The map of what the light sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shadow {
    /// Texels a side of the map.
    pub size: u32,
    /// How much nearer to the light than its own depth a point is looked up, in texels of the map as
    /// they lie in the world: more takes spots off what is lit, less lets shadows begin nearer.
    pub bias: f32,
    /// Metres a side of the square that the map covers before the eye; `None` for all that stands.
    pub extent: Option<f32>,
}
