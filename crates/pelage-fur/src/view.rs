//! Twin of `shaders/shared/frame.wgsl`: world, film and ray.

use crate::layout::Frame;
use glam::{Vec2, Vec3};

/// Ray through the centre of sample `xy` of the tile. Its forward component is 1, so that the ray
/// parameter is the depth, cm.
pub fn sample_ray(frame: &Frame, xy: [u32; 2]) -> Vec3 {
    let at = |k: usize| (frame.tile_origin[k] + xy[k] as i32) as f32;
    let s = Vec2::new(at(0), at(1)) + 0.5 + Vec2::from(frame.jitter);
    ray_through(frame, s)
}

/// Ray through point `s` of the displaced sample grid, in samples of the film.
pub fn ray_through(frame: &Frame, s: Vec2) -> Vec3 {
    let ndc = Vec2::new(2.0, -2.0) * s / Vec2::from(frame.film_size) + Vec2::new(-1.0, 1.0);
    let slope = ndc * Vec2::new(frame.tan_x, frame.tan_y) - Vec2::from(frame.lens_shear);
    Vec3::from(frame.forward) + slope.x * Vec3::from(frame.right) + slope.y * Vec3::from(frame.up)
}

/// Projects `p` (world, cm) to the film: xy in samples (centres at half-integers), z the depth in
/// cm.
pub fn film_from_world(frame: &Frame, p: Vec3) -> Vec3 {
    let v = p - Vec3::from(frame.eye);
    let z = v.dot(Vec3::from(frame.forward));
    let across = Vec2::new(v.dot(Vec3::from(frame.right)), v.dot(Vec3::from(frame.up)));
    let ndc = (across / z + Vec2::from(frame.lens_shear)) / Vec2::new(frame.tan_x, frame.tan_y);
    let xy = (ndc * Vec2::new(0.5, -0.5) + 0.5) * Vec2::from(frame.film_size) - Vec2::from(frame.jitter);
    xy.extend(z)
}

/// Samples per cm at a depth of 1 cm.
pub fn samples_per_slope(frame: &Frame) -> f32 {
    0.5 * frame.film_size[1] / frame.tan_y
}
