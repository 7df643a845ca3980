//! Twin of `shaders/shared/strands.wgsl`: strand vertices as four words, xyz in cm and two halves
//! (radius in units of 0.01 cm, opacity).

use glam::{Vec3, Vec4};
use half::f16;

/// Position of a strand vertex, cm.
pub fn position(v: [f32; 4]) -> Vec3 {
    Vec4::from(v).truncate()
}

/// Radius of a strand vertex, cm.
pub fn radius(v: [f32; 4]) -> f32 {
    f16::from_bits(v[3].to_bits() as u16).to_f32() * 0.01
}

/// Opacity of a strand vertex, 0..1.
pub fn opacity(v: [f32; 4]) -> f32 {
    f16::from_bits((v[3].to_bits() >> 16) as u16).to_f32()
}

/// Packs a strand vertex: position and radius in cm, opacity in 0..1.
pub fn vertex(p: Vec3, radius: f32, opacity: f32) -> [f32; 4] {
    let halves = [radius * 100.0, opacity].map(|x| u32::from(f16::from_f32(x).to_bits()));
    p.extend(f32::from_bits(halves[0] | (halves[1] << 16))).to_array()
}

/// Unit tangent at vertex `k` of a strand: along the line between its two neighbours.
pub fn tangent(strand: &[[f32; 4]], k: usize) -> Vec3 {
    let before = position(strand[k.saturating_sub(1)]);
    let after = position(strand[(k + 1).min(strand.len() - 1)]);
    let d = after - before;
    d / d.dot(d).max(1e-20).sqrt()
}
