//! Twin of `shaders/film.wgsl`: samples to pixels.

use glam::{Vec2, Vec3};
use half::f16;
use pelage_fur::layout::Reconstruction;
use pelage_fur::octahedral;

/// Number of planes that the pass writes; the last two are the sum and the weight of the depth.
pub const PLANES: usize = 20;

/// Unpacked film sample. Radiances are premultiplied.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Radiance of the guard hairs.
    pub guard: Vec3,
    /// Radiance of the undercoat.
    pub undercoat: Vec3,
    /// Radiance of the skin.
    pub base: Vec3,
    /// Transmittance.
    pub through: f32,
    /// Opacity-weighted depth, cm; 1e30 where nothing is hit.
    pub z: f32,
    /// Normal of the skin, if it is hit.
    pub normal: Option<Vec3>,
    /// Length of the sample's list.
    pub fragments: u32,
}

/// The two half floats of a word.
pub fn halves(word: u32) -> [f32; 2] {
    [word as u16, (word >> 16) as u16].map(|h| f16::from_bits(h).to_f32())
}

/// Unpacks a sample of the buffer `samples`.
pub fn unpack(words: [u32; 8]) -> Sample {
    let [a, b, c, d] = [words[0], words[1], words[2], words[3]].map(halves);
    let [base_b, through] = halves(words[4]);
    let snorm = |h: u32| f32::from(h as u16 as i16) / 32767.0;
    Sample {
        guard: Vec3::new(a[0], a[1], b[0]),
        undercoat: Vec3::new(b[1], c[0], c[1]),
        base: Vec3::new(d[0], d[1], base_b),
        through,
        z: f32::from_bits(words[5]),
        normal: (words[6] != 0)
            .then(|| octahedral::decode(Vec2::new(snorm(words[6]), snorm(words[6] >> 16)))),
        fragments: words[7],
    }
}

/// The planes of a pixel, filtered from the samples around it, in double precision. `size`: samples
/// of the tile.
pub fn pixel(r: &Reconstruction, size: [u32; 2], samples: &[Sample], pixel: [u32; 2]) -> [f64; PLANES] {
    let weight = |k: u32| f64::from(r.weights[k as usize / 4][k as usize % 4]);
    let corner = [0, 1].map(|k| r.origin[k] + (pixel[k] * r.grid) as i32 - r.reach);
    let mut sums = [0f64; PLANES];
    for (y, x) in (0..r.taps).flat_map(|y| (0..r.taps).map(move |x| (y, x))) {
        let w = weight(x) * weight(y);
        let at = |k: usize, offset: u32| (corner[k] + offset as i32).clamp(0, size[k] as i32 - 1) as u32;
        let s = &samples[(at(1, y) * size[0] + at(0, x)) as usize];
        let all = s.guard + s.undercoat + s.base;
        let normal = s.normal.unwrap_or(Vec3::ZERO);
        let seen = if s.z < 1e30 { 1.0 - s.through } else { 0.0 };
        let values = [
            all.x,
            all.y,
            all.z,
            1.0 - s.through,
            s.guard.x,
            s.guard.y,
            s.guard.z,
            s.undercoat.x,
            s.undercoat.y,
            s.undercoat.z,
            s.base.x,
            s.base.y,
            s.base.z,
            normal.x,
            normal.y,
            normal.z,
            s.through,
            s.fragments as f32,
            seen * s.z.min(1e20),
            seen,
        ];
        sums.iter_mut().zip(values).for_each(|(sum, v)| *sum += w * f64::from(v));
    }
    sums.map(|s| s * f64::from(r.scale))
}
