//! Metrics over a region, their names, and their limits.

use super::{OCTAVES, Pair, RELATIVE_FLOOR, finite, rgb, spectrum::Octaves};
use pelage_core::film::tonemap::luminance;
use serde::Serialize;

/// Differences over the pixels of a region. Colours are exposed, linear, premultiplied `R G B`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Metrics {
    /// Pixels of the region that are finite in both images.
    pub pixels: u64,
    /// Root of the mean squared difference over pixels and channels.
    pub rmse: f64,
    /// Mean of `(I - R)² / (R² + 0.01)` over pixels and channels.
    // [Rousselle2011]
    pub relative_mse: f64,
    /// Peak signal-to-noise ratio of the sRGB-encoded luminance for a peak of 1, dB; infinite for
    /// equal images.
    pub psnr: f64,
    /// Mean structural similarity of the sRGB-encoded luminance: window 11 x 11, Gaussian of σ 1.5,
    /// K1 = 0.01, K2 = 0.03; 1 for equal images.
    // [Wang2004] eq. 13
    pub ssim: f64,
    /// Mean FLIP error of the sRGB-encoded colours at 67 pixels per degree, 0..1.
    // [Andersson2020]
    pub flip: f64,
    /// Mean of the largest FLIP error over a range of exposures that the reference sets, 0..1.
    // [Andersson2021]
    pub hdr_flip: f64,
    /// Mean luminance of the image divided by that of the reference.
    pub luminance_ratio: f64,
    /// Mean of the image divided by that of the reference, for each of R, G and B.
    pub color_ratio: [f64; 3],
    /// Power of the luminance's detail in the image divided by that in the reference, each relative
    /// to the square of its own mean luminance, in octaves: periods of about 3, 6, 13 and 26
    /// pixels. Below 1 the image is too soft, above it too crisp or noisy. Noise is subtracted if a
    /// film holds the means of two halves of its samples, like a path traced reference; otherwise
    /// it counts as detail. Not a number where the noise exceeds the power.
    pub detail_ratio: [f64; OCTAVES],
    /// Mean absolute difference of alpha.
    pub alpha_difference: f64,
    /// Largest absolute difference of a channel.
    pub max_abs: f64,
}

/// Per-pixel values that are averaged over regions.
pub(super) struct Maps {
    /// Squared difference of the encoded luminance.
    pub squares: Vec<f64>,
    pub ssim: Vec<f64>,
    pub flip: Vec<f32>,
    pub hdr_flip: Vec<f32>,
    /// Of the image and of the reference.
    pub detail: [Octaves; 2],
    /// Noise of each, if known.
    pub noise: [Option<Octaves>; 2],
}

impl Metrics {
    pub(super) fn new(pair: &Pair, maps: &Maps, mask: &[bool]) -> Self {
        let mut squares = 0.0;
        let (mut relative, mut max_abs, mut alpha) = (0.0, 0.0f64, 0.0);
        let (mut light, mut color) = ([0.0; 2], [[0.0; 2]; 3]);
        let (mut ssim, mut flip, mut hdr_flip, mut encoded) = (0.0, 0.0, 0.0, 0.0);
        let mut detail = [[0.0; 2]; OCTAVES];
        let (mut counted, mut all) = (0u64, 0u64);
        for i in (0..mask.len()).filter(|i| mask[*i]) {
            let (p, q) = (&pair.image[i], &pair.reference[i]);
            all += 1;
            ssim += maps.ssim[i];
            flip += f64::from(maps.flip[i]);
            hdr_flip += f64::from(maps.hdr_flip[i]);
            if !(finite(p) && finite(q)) {
                continue;
            }
            counted += 1;
            encoded += maps.squares[i];
            for c in 0..3 {
                let (i, r) = (f64::from(p[c]), f64::from(q[c]));
                let square = (i - r) * (i - r);
                squares += square;
                relative += square / (r * r + RELATIVE_FLOOR);
                max_abs = max_abs.max((i - r).abs());
                color[c][0] += i;
                color[c][1] += r;
            }
            alpha += (f64::from(p[3]) - f64::from(q[3])).abs();
            light[0] += f64::from(luminance(rgb(p)));
            light[1] += f64::from(luminance(rgb(q)));
            for (octave, power) in detail.iter_mut().enumerate() {
                for ((power, detail), noise) in power.iter_mut().zip(&maps.detail).zip(&maps.noise) {
                    *power += detail.0[octave][i].powi(2);
                    *power -= noise.as_ref().map_or(0.0, |noise| noise.0[octave][i].powi(2));
                }
            }
        }
        let values = 3.0 * counted as f64;
        // Also 1 if both sums are zero, but not if there was nothing to add up.
        let ratio = |[image, reference]: [f64; 2]| match (counted, image == reference) {
            (0, _) => f64::NAN,
            (_, true) => 1.0,
            _ => image / reference,
        };
        // Noise that exceeds the power leaves nothing to compare.
        let detailed = |power: [f64; 2]| {
            if power.iter().any(|p| *p < 0.0) { f64::NAN } else { ratio(power) }
        };
        Self {
            pixels: counted,
            rmse: (squares / values).sqrt(),
            relative_mse: relative / values,
            psnr: -10.0 * (encoded / counted as f64).log10(),
            ssim: ssim / all as f64,
            flip: flip / all as f64,
            hdr_flip: hdr_flip / all as f64,
            luminance_ratio: ratio(light),
            color_ratio: color.map(ratio),
            detail_ratio: detail.map(|power| detailed(power) / ratio(light.map(|v| v * v))),
            alpha_difference: alpha / counted as f64,
            max_abs,
        }
    }

    /// The metrics past their limits, one line each.
    pub(super) fn exceeds(&self, limits: &Thresholds) -> Vec<String> {
        let mut lines = Vec::new();
        for metric in &METRICS {
            let Some(limit) = (metric.limit)(limits) else { continue };
            for (part, value) in (metric.values)(self).into_iter().enumerate() {
                let name = metric.part_name(part);
                let worst = match metric.sense {
                    Sense::Ratio => (value - 1.0).abs(),
                    _ => value,
                };
                let value_text = if value.is_nan() { "undefined".to_owned() } else { format!("{value:.6}") };
                let past = value.is_nan()
                    || if metric.sense == Sense::AtLeast { worst < limit } else { worst > limit };
                if past {
                    lines.push(match metric.sense {
                        Sense::AtMost => format!("{name} is {value_text}, more than {limit}"),
                        Sense::AtLeast => format!("{name} is {value_text}, less than {limit}"),
                        Sense::Ratio => format!("{name} is {value_text}, away from 1 by more than {limit}"),
                    });
                }
            }
        }
        lines
    }
}

/// Limits for [`Comparison::exceeds`](super::Comparison::exceeds); `None`: no limit.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Thresholds {
    /// Largest [`Metrics::rmse`].
    pub rmse: Option<f64>,
    /// Largest [`Metrics::relative_mse`].
    pub relative_mse: Option<f64>,
    /// Smallest [`Metrics::psnr`], dB.
    pub psnr: Option<f64>,
    /// Smallest [`Metrics::ssim`].
    pub ssim: Option<f64>,
    /// Largest [`Metrics::flip`].
    pub flip: Option<f64>,
    /// Largest [`Metrics::hdr_flip`].
    pub hdr_flip: Option<f64>,
    /// Largest distance of [`Metrics::luminance_ratio`] from 1.
    pub luminance_ratio: Option<f64>,
    /// Largest distance of a channel of [`Metrics::color_ratio`] from 1.
    pub color_ratio: Option<f64>,
    /// Largest distance of an octave of [`Metrics::detail_ratio`] from 1.
    pub detail_ratio: Option<f64>,
    /// Largest [`Metrics::alpha_difference`].
    pub alpha_difference: Option<f64>,
    /// Largest [`Metrics::max_abs`].
    pub max_abs: Option<f64>,
}

/// The meaning of a metric's limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sense {
    /// Zero for equal images; the limit is the largest value.
    AtMost,
    /// Large for equal images; the limit is the smallest value.
    AtLeast,
    /// One for equal images; the limit is the largest distance from 1.
    Ratio,
}

/// How a metric is printed and limited.
pub struct Metric {
    /// Printed name.
    pub name: &'static str,
    /// Names of its values if there is more than one.
    pub parts: &'static [&'static str],
    /// Meaning of its limit.
    pub sense: Sense,
    /// Its values: one, or one for each of [`Metric::parts`].
    pub values: fn(&Metrics) -> Vec<f64>,
    /// Its limit.
    pub limit: fn(&Thresholds) -> Option<f64>,
}

impl Metric {
    /// The name of value `part`.
    pub fn part_name(&self, part: usize) -> String {
        match self.parts.get(part) {
            Some(name) => format!("{} {name}", self.name),
            None => self.name.to_owned(),
        }
    }
}

macro_rules! metric {
    ($name:literal, $field:ident, $sense:ident) => {
        Metric {
            name: $name,
            parts: &[],
            sense: Sense::$sense,
            values: |m| vec![m.$field],
            limit: |t| t.$field,
        }
    };
    ($name:literal, $field:ident, $sense:ident, $parts:expr) => {
        Metric {
            name: $name,
            parts: &$parts,
            sense: Sense::$sense,
            values: |m| m.$field.to_vec(),
            limit: |t| t.$field,
        }
    };
}

/// All metrics in printing order.
pub static METRICS: [Metric; 11] = [
    metric!("RMSE", rmse, AtMost),
    metric!("relative MSE", relative_mse, AtMost),
    metric!("PSNR, dB", psnr, AtLeast),
    metric!("SSIM", ssim, AtLeast),
    metric!("FLIP", flip, AtMost),
    metric!("HDR-FLIP", hdr_flip, AtMost),
    metric!("luminance ratio", luminance_ratio, Ratio),
    metric!("colour ratio", color_ratio, Ratio, ["R", "G", "B"]),
    metric!("detail ratio", detail_ratio, Ratio, ["3 px", "6 px", "13 px", "26 px"]),
    metric!("alpha difference", alpha_difference, AtMost),
    metric!("largest difference", max_abs, AtMost),
];
