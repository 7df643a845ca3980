//! Running means of samples. They are kept in single precision: a file holds them exactly, and a
//! rendering resumes from it as if it had never stopped.

use super::integrator::{BASE, PixelSample};
use glam::Vec3;
use pelage_core::film::Film;
use pelage_core::film::tonemap::luminance;

/// Running means of a pixel, one for each of [`STATE`].
pub type Means = [f32; STATE.len()];

/// Names of the planes: radiance and alpha of each half of the samples, radiance by what was hit
/// first, normal, alpha times depth (cm), the square of the luminance, albedo and hairs' direction.
pub const STATE: [&str; 28] = [
    "half0.R",
    "half0.G",
    "half0.B",
    "half0.A",
    "half1.R",
    "half1.G",
    "half1.B",
    "half1.A",
    "guard.R",
    "guard.G",
    "guard.B",
    "undercoat.R",
    "undercoat.G",
    "undercoat.B",
    "base.R",
    "base.G",
    "base.B",
    "N.X",
    "N.Y",
    "N.Z",
    "depth.premultiplied",
    "luminance.square",
    "Albedo.R",
    "Albedo.G",
    "Albedo.B",
    "Tangent.X",
    "Tangent.Y",
    "Tangent.Z",
];

/// The means of all pixels and their number of samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Accumulator {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Samples per pixel, always even: both halves have the same number.
    pub samples: u32,
    /// Row by row.
    pub pixels: Vec<Means>,
}

/// Adds sample `index` to the means of a pixel.
pub fn add(means: &mut Means, index: u32, sample: &PixelSample) {
    let mut step = |k: usize, inverse: f32, value: f32| means[k] += (value - means[k]) * inverse;
    let color = sample.weight * sample.radiance;
    let alpha = sample.weight * sample.alpha;
    let half = (index & 1) as usize;
    let of_half = 1.0 / ((index >> 1) + 1) as f32;
    for (k, value) in [color.x, color.y, color.z, alpha].into_iter().enumerate() {
        step(4 * half + k, of_half, value);
    }
    let of_all = 1.0 / (index + 1) as f32;
    for layer in 0..=BASE {
        let part = if sample.layer == Some(layer) { color } else { Vec3::ZERO };
        (0..3).for_each(|c| step(8 + 3 * layer + c, of_all, part[c]));
    }
    (0..3).for_each(|c| step(17 + c, of_all, sample.weight * sample.normal[c]));
    step(20, of_all, alpha * sample.depth);
    step(21, of_all, luminance(color).powi(2));
    (0..3).for_each(|c| step(22 + c, of_all, sample.weight * sample.albedo[c]));
    (0..3).for_each(|c| step(25 + c, of_all, sample.weight * sample.tangent[c]));
}

impl Accumulator {
    /// No samples yet.
    pub fn new(width: u32, height: u32) -> Self {
        let pixels = vec![[0.0; STATE.len()]; width as usize * height as usize];
        Self { width, height, samples: 0, pixels }
    }

    /// Mean of `(h0 - h1)² / 4 / (m² + 0.01)` over pixels and channels, with the means h0, h1 of
    /// the halves and their mean m: an estimate of the relative mean squared error of m against the
    /// truth, as `pelage compare` measures it. Infinite without samples.
    // [Rousselle2011] sec. 3.1, for the relative error
    pub fn error(&self) -> f64 {
        if self.samples == 0 {
            return f64::INFINITY;
        }
        let of_pixel = |p: &Means| -> f64 {
            (0..3)
                .map(|c| {
                    let (a, b) = (f64::from(p[c]), f64::from(p[4 + c]));
                    let mean = 0.5 * (a + b);
                    0.25 * (a - b) * (a - b) / (mean * mean + 1e-2)
                })
                .sum()
        };
        self.pixels.iter().map(of_pixel).sum::<f64>() / (3 * self.pixels.len()) as f64
    }

    /// The image: `R G B A`, the planes of [`STATE`], `depth.Z`, and `variance.Y`, the variance of
    /// the mean luminance if samples were independent (those of a low-discrepancy sequence do
    /// slightly better).
    pub fn film(&self) -> Film {
        let mut film = Film { width: self.width, height: self.height, planes: Vec::new() };
        let plane = |value: &dyn Fn(&Means) -> f32| self.pixels.iter().map(value).collect::<Vec<f32>>();
        for (c, name) in ["R", "G", "B", "A"].into_iter().enumerate() {
            film.push(name, true, plane(&|p| 0.5 * (p[c] + p[4 + c])));
        }
        for (k, name) in STATE.into_iter().enumerate() {
            film.push(name, true, plane(&|p| p[k]));
        }
        film.push(
            "depth.Z",
            true,
            plane(&|p| {
                let alpha = 0.5 * (p[3] + p[7]);
                if alpha > 1e-4 { p[20] / alpha } else { f32::INFINITY }
            }),
        );
        let n = self.samples as f32;
        film.push(
            "variance.Y",
            true,
            plane(&|p| {
                let mean = luminance(Vec3::from_array([0, 1, 2].map(|c| 0.5 * (p[c] + p[4 + c]))));
                (p[21] - mean * mean).max(0.0) / (n - 1.0).max(1.0)
            }),
        );
        film
    }

    /// The means that a film from [`Accumulator::film`] holds; `None` if a plane is missing.
    pub fn from_film(film: &Film, samples: u32) -> Option<Self> {
        let mut all = Self::new(film.width, film.height);
        all.samples = samples;
        for (k, name) in STATE.into_iter().enumerate() {
            let plane = film.plane(name)?;
            all.pixels.iter_mut().zip(plane).for_each(|(p, v)| p[k] = *v);
        }
        Some(all)
    }
}
