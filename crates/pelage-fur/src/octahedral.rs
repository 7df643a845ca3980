//! Twin of `shaders/shared/octahedral.wgsl`: unit vectors in the octahedral map, -1..1 in both coordinates.

use glam::{Vec2, Vec3};

/// Signs with 0 counted as positive.
fn sign(v: f32) -> f32 {
    if v >= 0.0 { 1.0 } else { -1.0 }
}

/// The map's point of a unit vector.
pub fn encode(v: Vec3) -> Vec2 {
    let p = Vec2::new(v.x, v.y) / (v.x.abs() + v.y.abs() + v.z.abs());
    if v.z >= 0.0 { p } else { Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y)) }
}

/// The unit vector of a point of the map.
pub fn decode(e: Vec2) -> Vec3 {
    let z = 1.0 - e.x.abs() - e.y.abs();
    let fold = (-z).max(0.0);
    Vec3::new(e.x - sign(e.x) * fold, e.y - sign(e.y) * fold, z).normalize()
}
