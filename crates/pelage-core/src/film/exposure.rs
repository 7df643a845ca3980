//! The exposure that suits a picture.

use super::{Film, tonemap::luminance};
use crate::Result;
use crate::scene::{FilmSpec, Tonemap};
use glam::Vec3;

/// Luminance that the log-average becomes: middle grey.
const MIDDLE: f64 = 0.18;

/// Part of the pixels that may exceed the highlights.
const BEYOND: f64 = 0.01;

/// The exposure for a film before its background, stops.
///
/// The log-average luminance of all pixels with alpha above 0, without their background, becomes
/// 0.18. It is lowered where more than 1 % of these pixels would exceed the highlights: 1 without
/// tone mapping, 4 with a curve, which keeps two stops above white apart. Black and infinite pixels
/// do not count. The result lies in -32..32, the range of `film.exposure`, and is that of the
/// film's description where no pixel counts.
///
/// # Errors
/// [`crate::Error::Unsupported`] if a plane is missing.
// [Reinhard2002] sec. 3, log-average luminance and key value
pub fn automatic(film: &Film, spec: &FilmSpec) -> Result<f32> {
    let straight = |[r, g, b, a]: &[f32; 4]| f64::from(luminance(Vec3::new(*r, *g, *b)) / a);
    let mut all: Vec<f64> = film
        .premultiplied()?
        .iter()
        .filter(|pixel| pixel[3] > 0.0)
        .map(straight)
        .filter(|l| l.is_finite() && *l > 0.0)
        .collect();
    if all.is_empty() {
        return Ok(spec.exposure);
    }
    all.sort_by(f64::total_cmp);
    let mean = all.iter().map(|l| l.log2()).sum::<f64>() / all.len() as f64;
    let white = if spec.tonemap == Tonemap::None { 1.0f64 } else { 4.0 };
    let beyond = (all.len() as f64 * BEYOND) as usize;
    let highlight = all[all.len() - 1 - beyond];
    let stops = (MIDDLE.log2() - mean).min(white.log2() - highlight.log2());
    Ok(stops.clamp(-32.0, 32.0) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn exposure(pixels: &[[f32; 4]], tonemap: Tonemap) -> f32 {
        let film = Film::from_premultiplied(pixels.len() as u32, 1, pixels);
        automatic(&film, &FilmSpec { tonemap, exposure: 0.5, ..FilmSpec::default() }).expect("a whole film")
    }

    #[test]
    fn the_log_average_becomes_middle_grey() {
        let grey = |l: f32, a: f32| [l * a, l * a, l * a, a];
        // The mean of 0.09 and 0.36 over stops is 0.18; coverage and background do not count.
        let pixels = [grey(0.09, 1.0), grey(0.36, 0.25), [0.0; 4], [0.0, 0.0, 0.0, 1.0]];
        assert!(exposure(&pixels, Tonemap::None).abs() < 1e-4);
        let dark = pixels.map(|[r, g, b, a]| [r / 8.0, g / 8.0, b / 8.0, a]);
        assert!((exposure(&dark, Tonemap::None) - 3.0).abs() < 1e-4);
        assert_eq!(exposure(&[[0.0; 4]], Tonemap::None), 0.5, "no pixel counts");
    }

    #[test]
    fn highlights_are_kept() {
        let mut pixels = vec![[0.01, 0.01, 0.01, 1.0]; 90];
        pixels.resize(100, [1.0, 1.0, 1.0, 1.0]);
        // By the average it would be 18 / 10^0.2, 3.5 stops.
        assert!(exposure(&pixels, Tonemap::None).abs() < 1e-4);
        assert!((exposure(&pixels, Tonemap::Neutral) - 2.0).abs() < 1e-4);
        // A single bright pixel of a hundred may be burnt out.
        pixels = vec![[0.18, 0.18, 0.18, 1.0]; 99];
        pixels.push([1e4, 1e4, 1e4, 1.0]);
        let stops = exposure(&pixels, Tonemap::None);
        assert!((stops + (1e4f32 / 0.18).log2() / 100.0).abs() < 1e-3, "{stops}");
    }
}
