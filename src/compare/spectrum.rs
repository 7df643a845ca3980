//! Detail of the luminance by its size: how much softer or noisier one picture is than another.
//!
//! The power in an octave of the spectrum is the mean square of the picture after a band-pass (Parseval); filters that are small
//! in the picture, differences of Gaussians an octave apart, also tell it for a region.

use super::{finite, perceptual::gaussian, rgb};
use crate::film::tonemap::luminance;

/// Octaves that are told apart.
pub const OCTAVES: usize = 4;

/// The luminance in each octave, one value a pixel, finest first.
pub(super) struct Octaves(pub [Vec<f64>; OCTAVES]);

/// Octave k > 0 holds what a Gaussian of σ 2^(k - 1) keeps and one of twice that width does not, most of all periods of 6.5 such σ;
/// the finest holds all that σ 1 does not keep. Pixels that are not finite count as black.
pub(super) fn octaves(pixels: &[[f32; 4]], size: [usize; 2]) -> Octaves {
    let mut finer: Vec<f64> =
        pixels.iter().map(|p| if finite(p) { f64::from(luminance(rgb(p))) } else { 0.0 }).collect();
    let whole = finer.clone();
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
        let pixels: Vec<[f32; 4]> = (0..64 * 64)
            .map(|i| [0.5 + 0.2 * (std::f32::consts::TAU * (0.25 + (i % 64) as f32 / period)).sin(); 4])
            .collect();
        octaves(&pixels, [64, 64]).0.map(|band| band.iter().map(|v| v * v).sum::<f64>())
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
