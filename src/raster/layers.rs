//! Fragments that wait until all of their run are there, to be blended by depth.

use std::cmp::Reverse;

use super::shade::over;
use crate::math::Vec4;

/// A fragment at a sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layer {
    /// The sample's place in its block.
    pub(super) index: u32,
    /// The bits of its depth.
    pub(super) depth: u32,
    /// Its linear colour, with straight alpha.
    pub(super) colour: Vec4,
}

/// Blends fragments over what is there, at every sample the farthest first; none is left.
pub(super) fn blend_sorted(layers: &mut Vec<Layer>, colours: &mut [Vec4]) {
    // Stable, so that equally deep ones stay in the order of submission.
    layers.sort_by_key(|layer| (layer.index, Reverse(layer.depth)));
    for layer in layers.drain(..) {
        let there = &mut colours[layer.index as usize];
        *there = over(layer.colour, *there);
    }
}
