//! Twin of `shaders/shared/random.wgsl`: random numbers as integer hashes of stable ids.

use glam::{Vec2, Vec3};

/// The integer hash "lowbias32".
// [Wellons2018]
#[inline]
pub fn hash(value: u32) -> u32 {
    let mut x = value;
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// Hash of an ordered pair.
#[inline]
pub fn hash2(a: u32, b: u32) -> u32 {
    hash(a ^ hash(b.wrapping_add(0x9e37_79b9)))
}

/// Uniform in [0, 1) with 24 bits.
#[inline]
pub fn unit_float(h: u32) -> f32 {
    (h >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// The `k`-th uniform number of a seed, in [0, 1).
#[inline]
pub fn random(seed: u32, k: u32) -> f32 {
    unit_float(hash2(seed, k))
}

/// Steps of the R2 sequence: the fractional parts of their multiples are evenly distributed over
/// the unit square, whatever their number.
// [Roberts2018]
pub const R2_STEPS: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_3];

/// The `k`-th point of the R2 sequence from `start`, in the unit square.
// [Roberts2018]
pub fn r2(start: Vec2, k: u32) -> Vec2 {
    let point = start + k as f32 * Vec2::from(R2_STEPS.map(|step| step as f32));
    point - point.floor()
}

/// Maps a point of the unit square to barycentric coordinates of a triangle, preserving even
/// distributions.
// [Turk1990]
pub fn even_barycentric(u: Vec2) -> Vec3 {
    let r = u.x.sqrt();
    Vec3::new(1.0 - r, r * (1.0 - u.y), r * u.y)
}

/// A direction uniform on the unit sphere, from the numbers `k` and `k + 1` of the seed.
#[inline]
pub fn random_direction(seed: u32, k: u32) -> Vec3 {
    let z = 1.0 - 2.0 * random(seed, k);
    let phi = std::f32::consts::TAU * random(seed, k.wrapping_add(1));
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(r * phi.cos(), r * phi.sin(), z)
}
