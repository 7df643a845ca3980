//! The camera, as the passes read it.

use crate::layout::Frame;
use glam::{Vec2, Vec3};
use pelage_core::scene::Camera;

/// The march of each sample starts at a random phase of its own.
pub const FLAG_MARCH_JITTER: u32 = 1;

/// The lists of fragments are linked in order of depth.
pub const FLAG_SORTED_LISTS: u32 = 2;

/// The frame globals of `camera` for a film of `film` samples. The tile is the whole film until the
/// caller sets another.
///
/// `lens` is the point on the lens, in lens diameters (−0.5..0.5); `jitter` is the displacement of
/// the sample grid, in samples.
pub fn frame(camera: &Camera, film: [u32; 2], lens: Vec2, jitter: Vec2, seed: u32) -> Frame {
    let eye = Vec3::from(camera.eye);
    let target = Vec3::from(camera.target);
    let forward = (target - eye).normalize_or(Vec3::NEG_Z);
    let up = Vec3::from(camera.up);
    let right = forward.cross(up).try_normalize().unwrap_or_else(|| forward.any_orthonormal_vector());
    let up = right.cross(forward);
    let tan_y = (0.5 * camera.fov.to_radians()).tan();
    let (offset, shear) = match &camera.lens {
        Some(l) => {
            let focus = l.focus.unwrap_or((target - eye).length()).max(1e-3);
            let offset = lens * l.aperture;
            (offset, offset / focus)
        }
        None => (Vec2::ZERO, Vec2::ZERO),
    };
    Frame {
        eye: (eye + offset.x * right + offset.y * up).into(),
        near: camera.near,
        right: right.into(),
        tan_x: tan_y * film[0] as f32 / film[1] as f32,
        up: up.into(),
        tan_y,
        forward: forward.into(),
        seed,
        film_size: [film[0] as f32, film[1] as f32],
        jitter: jitter.into(),
        lens_shear: shear.into(),
        tile_origin: [0, 0],
        tile_size: film,
        flags: FLAG_MARCH_JITTER,
        node_capacity: 0,
    }
}
