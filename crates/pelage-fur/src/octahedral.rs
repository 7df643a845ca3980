//! Twin of `shaders/shared/octahedral.wgsl`: unit vectors in the octahedral map, −1..1 in both
//! coordinates.
// [Meyer2010]

use glam::{Vec2, Vec3};

/// Sign of `v`; 0 counts as positive.
fn sign(v: f32) -> f32 {
    if v >= 0.0 { 1.0 } else { -1.0 }
}

/// Maps a unit vector to the octahedral map.
pub fn encode(v: Vec3) -> Vec2 {
    let p = Vec2::new(v.x, v.y) / (v.x.abs() + v.y.abs() + v.z.abs());
    if v.z >= 0.0 { p } else { Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y)) }
}

/// Maps a point of the octahedral map to its unit vector.
pub fn decode(e: Vec2) -> Vec3 {
    let z = 1.0 - e.x.abs() - e.y.abs();
    let fold = (-z).max(0.0);
    Vec3::new(e.x - sign(e.x) * fold, e.y - sign(e.y) * fold, z).normalize()
}

/// Unpacks a direction from one word: two signed normalised 16-bit numbers.
pub fn unpack(word: u32) -> Vec3 {
    let snorm = |half: u32| (f32::from(half as u16 as i16) / 32767.0).max(-1.0);
    decode(Vec2::new(snorm(word), snorm(word >> 16)))
}
