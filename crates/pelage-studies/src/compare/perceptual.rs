//! SSIM, FLIP and HDR-FLIP of each pixel.

use super::rgb;
use pelage_core::film::tonemap::{luminance, srgb_encode, tone_map};
use pelage_core::scene::Tonemap;
use pelage_core::{Error, Result};
use rayon::prelude::*;

/// Largest number of exposures of HDR-FLIP.
const MOST_EXPOSURES: f64 = 24.0;

/// FLIP error of each pixel, on sRGB-encoded colours of 8 bits.
pub(super) fn flip(image: &[[f32; 4]], reference: &[[f32; 4]], size: [usize; 2]) -> Result<Vec<f32>> {
    flip_of(image, reference, size, &|p| [p[0], p[1], p[2]])
}

/// FLIP error of each pixel; `display` maps pixels to display-linear colours.
fn flip_of(
    image: &[[f32; 4]],
    reference: &[[f32; 4]],
    size: [usize; 2],
    display: &dyn Fn(&[f32; 4]) -> [f32; 3],
) -> Result<Vec<f32>> {
    // nv_flip counts bytes in 32 bits.
    if image.len() > (u32::MAX / 4) as usize {
        return Err(Error::Unsupported(format!("{} x {} pixels are too many for FLIP", size[0], size[1])));
    }
    let [width, height] = size.map(|n| n as u32);
    let of = |pixels: &[[f32; 4]]| {
        let bytes: Vec<u8> =
            pixels.iter().flat_map(|p| display(p).map(|v| (srgb_encode(v) * 255.0).round() as u8)).collect();
        nv_flip::FlipImageRgb8::with_data(width, height, &bytes)
    };
    Ok(nv_flip::flip(of(reference), of(image), nv_flip::DEFAULT_PIXELS_PER_DEGREE).to_vec())
}

/// Result of [`hdr_flip`].
pub(super) struct HdrFlip {
    /// Error of each pixel, the largest over the exposures.
    pub map: Vec<f32>,
    /// First and last exposure, stops.
    pub exposures: [f64; 2],
}

/// FLIP over a range of exposures about a stop apart: from the exposure that maps the reference's
/// brightest pixel to just below white, with the ACES tone mapper, to the one that does so for its
/// median.
///
/// DEVIATION: the median is that of the pixels that are not black. Fur without a background is
/// mostly black, and the median of all pixels would need infinite exposure.
///
/// DEVIATION: colours have 8 bits after tone mapping, as nv_flip expects.
// [Andersson2021] sec. 3
pub(super) fn hdr_flip(image: &[[f32; 4]], reference: &[[f32; 4]], size: [usize; 2]) -> Result<HdrFlip> {
    let exposures = exposure_range(reference);
    let [start, stop] = exposures;
    let count = (stop - start).ceil().clamp(2.0, MOST_EXPOSURES) as usize;
    let mut map = vec![0.0f32; image.len()];
    for k in 0..count {
        let stops = start + (stop - start) * k as f64 / (count - 1) as f64;
        let factor = stops.exp2() as f32;
        let errors = flip_of(image, reference, size, &|p| aces(rgb(p) * factor).to_array())?;
        map.iter_mut().zip(errors).for_each(|(most, error)| *most = most.max(error));
    }
    Ok(HdrFlip { map, exposures })
}

/// The tone mapper of HDR-FLIP, with its pre-exposure.
// [Narkowicz2015]
fn aces(rgb: glam::Vec3) -> glam::Vec3 {
    tone_map(Tonemap::Aces, 0.6 * rgb)
}

/// First and last exposure of HDR-FLIP, stops.
// [Andersson2021] eq. 3, 4
fn exposure_range(reference: &[[f32; 4]]) -> [f64; 2] {
    const WHITE: f64 = 0.85;
    let mut luminances: Vec<f64> = reference
        .iter()
        .map(|p| f64::from(luminance(rgb(p))))
        .filter(|y| y.is_finite() && *y > 0.0)
        .collect();
    luminances.sort_by(f64::total_cmp);
    let Some(brightest) = luminances.last() else { return [0.0, 0.0] };
    let median = luminances[luminances.len() / 2];
    // The brighter x with (a x² + b x) / (c x² + d x + e) = WHITE.
    let [a, b, c, d, e] = [0.36 * 2.51, 0.6 * 0.03, 0.36 * 2.43, 0.6 * 0.59, 0.14];
    let [a, b, c] = [a - WHITE * c, b - WHITE * d, -WHITE * e];
    let x = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
    [(x / brightest).log2(), (x / median).log2()]
}

/// SSIM of each pixel; windows are clipped at the border and their weights normalised.
// [Wang2004] eq. 13
pub(super) fn ssim(a: &[f64], b: &[f64], size: [usize; 2]) -> Vec<f64> {
    const C1: f64 = 0.01 * 0.01;
    const C2: f64 = 0.03 * 0.03;
    let windowed = |v: &[f64]| gaussian(v, size, 1.5, 5);
    let product = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).collect::<Vec<_>>();
    let [mean_a, mean_b] = [a, b].map(windowed);
    let [aa, bb, ab] = [product(a, a), product(b, b), product(a, b)].map(|v| windowed(&v));
    let one = |i: usize| {
        let (ma, mb) = (mean_a[i], mean_b[i]);
        let (va, vb, cov) = (aa[i] - ma * ma, bb[i] - mb * mb, ab[i] - ma * mb);
        (2.0 * ma * mb + C1) * (2.0 * cov + C2) / ((ma * ma + mb * mb + C1) * (va + vb + C2))
    };
    (0..a.len()).map(one).collect()
}

/// Gaussian mean over a square of `2 half + 1` pixels, clipped at the border.
pub(super) fn gaussian(values: &[f64], [width, height]: [usize; 2], sigma: f64, half: usize) -> Vec<f64> {
    let kernel: Vec<f64> = (0..=half).map(|i| (-((i * i) as f64) / (2.0 * sigma * sigma)).exp()).collect();
    let mean = |at: usize, length: usize, value: &dyn Fn(usize) -> f64| {
        let (mut sum, mut weights) = (0.0, 0.0);
        for i in at.saturating_sub(half)..(at + half + 1).min(length) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_range_of_exposures_shows_the_brightest_and_the_median_just_below_white() {
        let pixels: Vec<[f32; 4]> =
            (0..11).map(|i| [0.01 * 3f32.powi(i); 3]).map(|[r, g, b]| [r, g, b, 1.0]).collect();
        let [start, stop] = exposure_range(&pixels);
        for (stops, pixel) in [(start, pixels[10]), (stop, pixels[5])] {
            let shown = aces(rgb(&pixel) * stops.exp2() as f32);
            assert!((shown.y - 0.85).abs() < 1e-4, "{shown} at {stops} stops");
        }
        let black = vec![[0.0, 0.0, 0.0, 1.0]; 40];
        assert_eq!(exposure_range(&[black.clone(), pixels].concat()), [start, stop]);
        assert_eq!(exposure_range(&black), [0.0, 0.0]);
    }
}
