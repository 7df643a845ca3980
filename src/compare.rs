//! How much two pictures differ.

use crate::{
    Error, Result,
    film::{
        Film,
        tonemap::{luminance, srgb_decode, srgb_encode},
    },
};
use glam::Vec3;
use rayon::prelude::*;
use serde::Serialize;

/// Differences of an image from a reference. Colours are linear, premultiplied `R G B`; pixels that are infinite or
/// not a number in either image are counted and left out (FLIP and SSIM see them as black).
///
/// In JSON an infinite or undefined number becomes `null`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Comparison {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Pixels of the image that are infinite or not a number.
    pub non_finite_image: u64,
    /// Pixels of the reference that are infinite or not a number.
    pub non_finite_reference: u64,
    /// Root of the mean squared difference over pixels and channels.
    pub rmse: f64,
    /// Mean of `(I - R)² / (R² + 0.01)` over pixels and channels.
    // [Rousselle2011]
    pub relative_mse: f64,
    /// Peak signal-to-noise ratio for a peak of 1, dB; infinite for equal images.
    pub psnr: f64,
    /// Mean structural similarity of the sRGB-encoded luminance: window 11 x 11, Gaussian of σ 1.5, K1 = 0.01,
    /// K2 = 0.03; 1 for equal images.
    // [Wang2004] eq. 13
    pub ssim: f64,
    /// Mean FLIP error of the sRGB-encoded colours at 67 pixels per degree, 0..1.
    // [Andersson2020]
    pub flip: f64,
    /// Mean luminance of the image divided by that of the reference.
    pub luminance_ratio: f64,
    /// Mean absolute difference of alpha.
    pub alpha_difference: f64,
    /// Largest absolute difference of a channel.
    pub max_abs: f64,
}

/// Limits for [`Comparison::exceeds`]; what is `None` is not looked at.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Thresholds {
    /// Largest [`Comparison::rmse`].
    pub rmse: Option<f64>,
    /// Largest [`Comparison::relative_mse`].
    pub relative_mse: Option<f64>,
    /// Smallest [`Comparison::psnr`], dB.
    pub psnr: Option<f64>,
    /// Smallest [`Comparison::ssim`].
    pub ssim: Option<f64>,
    /// Largest [`Comparison::flip`].
    pub flip: Option<f64>,
    /// Largest distance of [`Comparison::luminance_ratio`] from 1.
    pub luminance_ratio: Option<f64>,
    /// Largest [`Comparison::alpha_difference`].
    pub alpha_difference: Option<f64>,
    /// Largest [`Comparison::max_abs`].
    pub max_abs: Option<f64>,
}

/// How [`error_image`] shows differences.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ErrorImage {
    /// The FLIP error in the magma colour map: black 0, white 1.
    Flip,
    /// Absolute difference of each channel times a factor.
    Difference(f32),
}

impl Comparison {
    /// What exceeds its limit, in one line each; `None` if nothing does. Pixels that are not finite always do, and
    /// so does a metric that is not a number.
    pub fn exceeds(&self, limits: &Thresholds) -> Option<String> {
        let mut lines = Vec::new();
        let mut at_most = |name: &str, value: f64, limit: Option<f64>| {
            if let Some(limit) = limit.filter(|limit| value.is_nan() || value > *limit) {
                lines.push(format!("{name} is {value:.6}, more than {limit}"));
            }
        };
        at_most("RMSE", self.rmse, limits.rmse);
        at_most("relative MSE", self.relative_mse, limits.relative_mse);
        at_most("FLIP", self.flip, limits.flip);
        at_most(
            "distance of the luminance ratio from 1",
            (self.luminance_ratio - 1.0).abs(),
            limits.luminance_ratio,
        );
        at_most("alpha difference", self.alpha_difference, limits.alpha_difference);
        at_most("largest difference", self.max_abs, limits.max_abs);
        for (name, value, limit) in [("PSNR", self.psnr, limits.psnr), ("SSIM", self.ssim, limits.ssim)] {
            if let Some(limit) = limit.filter(|limit| value.is_nan() || value < *limit) {
                lines.push(format!("{name} is {value:.6}, less than {limit}"));
            }
        }
        for (name, count) in [("image", self.non_finite_image), ("reference", self.non_finite_reference)] {
            if count > 0 {
                lines.push(format!("{count} pixels of the {name} are infinite or not a number"));
            }
        }
        (!lines.is_empty()).then(|| lines.join("\n"))
    }
}

impl std::fmt::Display for Comparison {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "size              {} x {}", self.width, self.height)?;
        writeln!(f, "RMSE              {:.6}", self.rmse)?;
        writeln!(f, "relative MSE      {:.6}", self.relative_mse)?;
        writeln!(f, "PSNR              {:.3} dB", self.psnr)?;
        writeln!(f, "SSIM              {:.6}", self.ssim)?;
        writeln!(f, "FLIP              {:.6}", self.flip)?;
        writeln!(f, "luminance ratio   {:.6}", self.luminance_ratio)?;
        writeln!(f, "alpha difference  {:.6}", self.alpha_difference)?;
        writeln!(f, "max difference    {:.6}", self.max_abs)?;
        write!(
            f,
            "not finite        {} image, {} reference",
            self.non_finite_image, self.non_finite_reference
        )
    }
}

/// Compares an image with a reference of the same size.
///
/// # Errors
/// [`Error::Check`] if the sizes differ (with both), or if a film lacks a plane of `R G B A`.
pub fn compare(image: &Film, reference: &Film) -> Result<Comparison> {
    let (a, b) = both(image, reference)?;
    let finite = |p: &[f32; 4]| p.iter().all(|v| v.is_finite());
    let (mut squares, mut relative, mut max_abs, mut alpha) = (0f64, 0f64, 0f64, 0f64);
    let (mut light, mut reference_light) = (0f64, 0f64);
    let mut counted = 0u64;
    for (p, q) in a.iter().zip(&b).filter(|(p, q)| finite(p) && finite(q)) {
        counted += 1;
        for c in 0..3 {
            let (i, r) = (f64::from(p[c]), f64::from(q[c]));
            let square = (i - r) * (i - r);
            squares += square;
            relative += square / (r * r + 1e-2);
            max_abs = max_abs.max((i - r).abs());
        }
        alpha += (f64::from(p[3]) - f64::from(q[3])).abs();
        light += f64::from(luminance(rgb(p)));
        reference_light += f64::from(luminance(rgb(q)));
    }
    let values = 3.0 * counted as f64;
    let mse = squares / values;
    let size = [image.width as usize, image.height as usize];
    let flip = flip_map(&a, &b, size)?;
    Ok(Comparison {
        width: image.width,
        height: image.height,
        non_finite_image: a.iter().filter(|p| !finite(p)).count() as u64,
        non_finite_reference: b.iter().filter(|p| !finite(p)).count() as u64,
        rmse: mse.sqrt(),
        relative_mse: relative / values,
        psnr: -10.0 * mse.log10(),
        ssim: ssim(&encoded_luminance(&a), &encoded_luminance(&b), size),
        flip: flip.iter().map(|v| f64::from(*v)).sum::<f64>() / flip.len() as f64,
        luminance_ratio: if light == reference_light { 1.0 } else { light / reference_light },
        alpha_difference: alpha / counted as f64,
        max_abs,
    })
}

/// A picture of the differences, opaque; write it with tone mapping `none` and exposure 0.
///
/// # Errors
/// As [`compare`].
pub fn error_image(image: &Film, reference: &Film, kind: ErrorImage) -> Result<Film> {
    let (a, b) = both(image, reference)?;
    let pixels: Vec<[f32; 4]> = match kind {
        ErrorImage::Flip => {
            let lut = nv_flip::magma_lut().to_vec();
            flip_map(&a, &b, [image.width as usize, image.height as usize])?
                .iter()
                .map(|error| {
                    let entry = 3 * (error.clamp(0.0, 1.0) * 255.0).round() as usize;
                    let [r, g, b] = [0, 1, 2]
                        .map(|c| srgb_decode(lut.get(entry + c).copied().map_or(0.0, f32::from) / 255.0));
                    [r, g, b, 1.0]
                })
                .collect()
        }
        ErrorImage::Difference(factor) => a
            .iter()
            .zip(&b)
            .map(|(p, q)| {
                let [r, g, b] = [0, 1, 2].map(|c| (p[c] - q[c]).abs() * factor);
                [r, g, b, 1.0]
            })
            .collect(),
    };
    Ok(Film::from_premultiplied(image.width, image.height, &pixels))
}

type Pixels = Vec<[f32; 4]>;

fn both(image: &Film, reference: &Film) -> Result<(Pixels, Pixels)> {
    if (image.width, image.height) != (reference.width, reference.height) {
        return Err(Error::Check(format!(
            "the image is {} x {} pixels, the reference {} x {}: only images of the same size can be compared",
            image.width, image.height, reference.width, reference.height
        )));
    }
    Ok((image.premultiplied()?, reference.premultiplied()?))
}

fn rgb(pixel: &[f32; 4]) -> Vec3 {
    Vec3::new(pixel[0], pixel[1], pixel[2])
}

fn encoded_luminance(pixels: &[[f32; 4]]) -> Vec<f64> {
    pixels.iter().map(|p| f64::from(srgb_encode(luminance(rgb(p))))).collect()
}

/// FLIP error of each pixel.
fn flip_map(image: &[[f32; 4]], reference: &[[f32; 4]], size: [usize; 2]) -> Result<Vec<f32>> {
    // The library counts bytes in 32 bits.
    if image.len() > (u32::MAX / 4) as usize {
        return Err(Error::Check(format!("{} x {} pixels are too many for FLIP", size[0], size[1])));
    }
    let bytes = |pixels: &[[f32; 4]]| -> Vec<u8> {
        pixels
            .iter()
            .flat_map(|p| [p[0], p[1], p[2]].map(|v| (srgb_encode(v) * 255.0).round() as u8))
            .collect()
    };
    let [width, height] = size.map(|n| n as u32);
    let of = |pixels| nv_flip::FlipImageRgb8::with_data(width, height, &bytes(pixels));
    Ok(nv_flip::flip(of(reference), of(image), nv_flip::DEFAULT_PIXELS_PER_DEGREE).to_vec())
}

/// Mean SSIM over all pixels; windows at the border are cut and their weights scaled to 1.
// [Wang2004] eq. 13
fn ssim(a: &[f64], b: &[f64], size: [usize; 2]) -> f64 {
    const C1: f64 = 0.01 * 0.01;
    const C2: f64 = 0.03 * 0.03;
    let product = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).collect::<Vec<_>>();
    let [mean_a, mean_b] = [a, b].map(|v| windowed(v, size));
    let [aa, bb, ab] = [product(a, a), product(b, b), product(a, b)].map(|v| windowed(&v, size));
    let sum: f64 = (0..a.len())
        .map(|i| {
            let (ma, mb) = (mean_a[i], mean_b[i]);
            let (va, vb, cov) = (aa[i] - ma * ma, bb[i] - mb * mb, ab[i] - ma * mb);
            (2.0 * ma * mb + C1) * (2.0 * cov + C2) / ((ma * ma + mb * mb + C1) * (va + vb + C2))
        })
        .sum();
    sum / a.len() as f64
}

/// Gaussian mean over 11 x 11 pixels, σ 1.5.
fn windowed(values: &[f64], [width, height]: [usize; 2]) -> Vec<f64> {
    const HALF: usize = 5;
    let kernel: [f64; HALF + 1] = std::array::from_fn(|i| (-((i * i) as f64) / (2.0 * 1.5 * 1.5)).exp());
    let mean = |at: usize, length: usize, value: &dyn Fn(usize) -> f64| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for i in at.saturating_sub(HALF)..(at + HALF + 1).min(length) {
            let weight = kernel[i.abs_diff(at)];
            sum += weight * value(i);
            weights += weight;
        }
        sum / weights
    };
    let mut across = vec![0.0; values.len()];
    across.par_chunks_mut(width).zip(values.par_chunks(width)).for_each(|(out, row)| {
        out.iter_mut().enumerate().for_each(|(x, out)| *out = mean(x, width, &|i| row[i]));
    });
    let mut down = vec![0.0; values.len()];
    down.par_chunks_mut(width).enumerate().for_each(|(y, out)| {
        out.iter_mut().enumerate().for_each(|(x, out)| *out = mean(y, height, &|i| across[i * width + x]));
    });
    down
}
