//! Twin of `shaders/film.wgsl`: samples to pixels.

use glam::{Vec2, Vec3};
use half::f16;
use pelage_fur::layout::{Frame, Reconstruction};
use pelage_fur::octahedral;
use pelage_fur::view::sample_ray;

/// Number of planes that the pass writes, see [`crate::planes::PLANES`].
pub const PLANES: usize = 32;

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
    /// Features, if the sample has them.
    pub features: Option<Features>,
}

/// Features of a sample: sums over what is visible, weighted by opacity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Features {
    /// Albedo of hairs and skin.
    pub albedo: Vec3,
    /// Normals of ribbons that face the camera, and of the skin.
    pub normal: Vec3,
    /// Directions of the hairs.
    pub tangent: Vec3,
    /// Coverage of guard hairs, undercoat, and skin or object.
    pub coverage: Vec3,
    /// 0 for the skin, else 1 + number of the object.
    pub object: u32,
}

/// The two half floats of a word.
pub fn halves(word: u32) -> [f32; 2] {
    [word as u16, (word >> 16) as u16].map(|h| f16::from_bits(h).to_f32())
}

/// Unpacks a sample of the buffer `samples`: 8 words, with features 16.
pub fn unpack(words: &[u32]) -> Sample {
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
        features: (words.len() >= 16).then(|| features(&words[8..])),
    }
}

/// Unpacks the last 8 words of a sample with features.
fn features(words: &[u32]) -> Features {
    let [a, b, c, d] = [words[0], words[1], words[2], words[3]].map(halves);
    Features {
        albedo: Vec3::new(a[0], a[1], b[0]),
        normal: Vec3::new(b[1], c[0], c[1]),
        tangent: Vec3::new(d[0], d[1], halves(words[4])[0]),
        coverage: Vec3::from([words[5], words[6], words[7]].map(f32::from_bits)),
        object: words[4] >> 16,
    }
}

/// The samples that a pixel is filtered from, with their weights.
fn around<'a>(
    frame: &'a Frame,
    r: &'a Reconstruction,
    pixel: [u32; 2],
) -> impl Iterator<Item = ([u32; 2], f64)> + use<'a> {
    let weight = |k: u32| f64::from(r.weights[k as usize / 4][k as usize % 4]);
    let corner = [0, 1].map(|k| r.origin[k] + (pixel[k] * r.grid) as i32 - r.reach);
    let at = move |k: usize, offset: u32| {
        (corner[k] + offset as i32).clamp(0, frame.tile_size[k] as i32 - 1) as u32
    };
    let taps = (0..r.taps).flat_map(|y| (0..r.taps).map(move |x| (x, y)));
    taps.map(move |(x, y)| ([at(0, x), at(1, y)], weight(x) * weight(y)))
}

/// Coverage of an object in a pixel (0: the skin), from samples with features.
pub fn object_coverage(
    frame: &Frame,
    r: &Reconstruction,
    samples: &[Sample],
    pixel: [u32; 2],
    object: u32,
) -> f64 {
    let of = |(xy, w): ([u32; 2], f64)| {
        let features = samples[(xy[1] * frame.tile_size[0] + xy[0]) as usize].features;
        features.filter(|f| f.object == object).map_or(0.0, |f| w * f64::from(f.coverage.z))
    };
    around(frame, r, pixel).map(of).sum::<f64>() * f64::from(r.scale)
}

/// The planes of a pixel, filtered from the samples around it, in double precision. `frame`: that
/// of the tile.
pub fn pixel(frame: &Frame, r: &Reconstruction, samples: &[Sample], pixel: [u32; 2]) -> [f64; PLANES] {
    let mut sums = [0f64; PLANES];
    for (xy, w) in around(frame, r, pixel) {
        let s = &samples[(xy[1] * frame.tile_size[0] + xy[0]) as usize];
        let all = s.guard + s.undercoat + s.base;
        let f = s.features.unwrap_or(Features {
            albedo: Vec3::ZERO,
            normal: s.normal.unwrap_or(Vec3::ZERO),
            tangent: Vec3::ZERO,
            coverage: Vec3::ZERO,
            object: 0,
        });
        let seen = if s.z < 1e30 { 1.0 - s.through } else { 0.0 };
        let z = s.z.min(1e20);
        let position = seen * (Vec3::from(frame.eye) + z * sample_ray(frame, xy));
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
            f.normal.x,
            f.normal.y,
            f.normal.z,
            s.through,
            s.fragments as f32,
            seen * z,
            seen,
            position.x,
            position.y,
            position.z,
            f.albedo.x,
            f.albedo.y,
            f.albedo.z,
            f.tangent.x,
            f.tangent.y,
            f.tangent.z,
            f.coverage.x,
            f.coverage.y,
            f.coverage.z,
        ];
        sums.iter_mut().zip(values).for_each(|(sum, v)| *sum += w * f64::from(v));
    }
    sums.map(|s| s * f64::from(r.scale))
}
