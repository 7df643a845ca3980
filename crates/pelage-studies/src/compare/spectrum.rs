//! Detail of the luminance by octave: how much softer or noisier one image is than another.
//!
//! The power in an octave of the spectrum is the mean square of the image after a band-pass filter
//! (Parseval). Filters of small support, here differences of Gaussians an octave apart, also give
//! it for a region.

use super::{finite, perceptual::gaussian, rgb};
use pelage_core::film::Film;
use pelage_core::film::tonemap::luminance;

/// Number of octaves.
pub const OCTAVES: usize = 4;

/// Luminance of each pixel; pixels that are not finite count as black.
pub(super) fn luminances(pixels: &[[f32; 4]]) -> Vec<f64> {
    pixels.iter().map(|p| if finite(p) { f64::from(luminance(rgb(p))) } else { 0.0 }).collect()
}

/// The noise of a film that holds the means of two halves of its samples, `half0.R` to `half1.B`:
/// half of their difference has the same variance as the noise of their mean. `None` for other
/// films.
pub(super) fn noise(film: &Film, factor: f32) -> Option<Vec<f64>> {
    let half = |k: usize| -> Option<[&[f32]; 3]> {
        let plane = |c: &str| film.plane(&format!("half{k}.{c}"));
        Some([plane("R")?, plane("G")?, plane("B")?])
    };
    let (a, b) = (half(0)?, half(1)?);
    let pixel = |i: usize| [0, 1, 2].map(|c| 0.5 * factor * (a[c][i] - b[c][i]));
    let pixels: Vec<[f32; 4]> = (0..film.pixels()).map(pixel).map(|[r, g, b]| [r, g, b, 1.0]).collect();
    Some(luminances(&pixels))
}

/// The luminance in each octave, one value per pixel, finest first.
pub(super) struct Octaves(pub [Vec<f64>; OCTAVES]);

/// Octave k > 0 is the difference of Gaussians of σ 2^(k - 1) and of twice that, whose response
/// peaks at periods of about 6.5 of the smaller σ. The finest octave is the difference of the image
/// and a Gaussian of σ 1.
pub(super) fn octaves(luminance: Vec<f64>, size: [usize; 2]) -> Octaves {
    let whole = luminance.clone();
    let mut finer = luminance;
    Octaves(std::array::from_fn(|k| {
        let sigma = f64::from(1 << k);
        let coarser = gaussian(&whole, size, sigma, (3.0 * sigma).ceil() as usize);
        let band = finer.iter().zip(&coarser).map(|(a, b)| a - b).collect();
        finer = coarser;
        band
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stripes with the given period, seen in each octave.
    fn powers(period: f32) -> [f64; OCTAVES] {
        let stripes = (0..64 * 64)
            .map(|i| f64::from(0.5 + 0.2 * (std::f32::consts::TAU * (0.25 + (i % 64) as f32 / period)).sin()))
            .collect();
        octaves(stripes, [64, 64]).0.map(|band| band.iter().map(|v| v * v).sum::<f64>())
    }

    #[test]
    fn stripes_are_found_in_the_octave_of_their_period() {
        for (k, period) in [2.0, 6.0, 12.0, 24.0].into_iter().enumerate() {
            let powers = powers(period);
            let strongest = (0..OCTAVES).max_by(|a, b| powers[*a].total_cmp(&powers[*b])).unwrap();
            assert_eq!(strongest, k, "period {period}: {powers:?}");
        }
    }
}
