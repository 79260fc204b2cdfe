//! Where primitives lie: their vertices begin with a position, and a matrix an instance places them.

use spinney::gpu::{Bindings, Transform, Words};
use spinney::math::{Mat4, Vec3};

use crate::leaves::{INSTANCE_SLOT, VIEW_SLOT};

/// The box around the vertices of corners, which have so many words each and begin with a position.
pub(crate) fn bounds(corners: &[u32], vertices: Words<'_>, words: usize) -> [Vec3; 2] {
    let mut bounds = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    for &corner in corners {
        let point = Vec3::from_array(vertices.f32s(words * corner as usize));
        bounds = [bounds[0].min(point), bounds[1].max(point)];
    }
    bounds
}

/// From the space of an instance to clip space, by the matrices of [`VIEW_SLOT`] and [`INSTANCE_SLOT`].
pub(crate) fn transform(bindings: &Bindings<'_>, instance: u32) -> Transform {
    let storage = |slot: u32| bindings.storage(slot as usize);
    let clip_from_world = Mat4::from_cols_array(&storage(VIEW_SLOT).f32s(0));
    let place = storage(INSTANCE_SLOT).f32s(16 * instance as usize);
    Transform::of_product(clip_from_world, Mat4::from_cols_array(&place))
}
