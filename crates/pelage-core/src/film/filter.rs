//! Reconstruction filters: how samples become pixels.
//!
//! All filters are separable, so a pixel is gathered with one vector of weights, used along x and
//! along y: `pixel = sum_j sum_i w[j] w[i] sample[j][i]`. The weights add up to one, so no division
//! follows.

use crate::scene::Filter;
use crate::{Error, Result};

/// The filter's usual radius, pixels.
pub fn usual_radius(filter: Filter) -> f32 {
    match filter {
        Filter::Box => 0.5,
        Filter::Triangle => 1.0,
        Filter::Gaussian => 1.5,
        Filter::Mitchell => 2.0,
    }
}

/// Weight of a sample at (x, y) pixels from the pixel's centre, not normalised; zero outside the
/// square of half width `radius`.
///
/// * box: 1.
/// * triangle: `(r - |x|) (r - |y|)`.
/// * gaussian: `g(x) g(y)`, `g(x) = exp(-x²/2σ²) - exp(-r²/2σ²)`, σ = 0.5 pixels at the usual
///   radius of 1.5 and in proportion at others.
// [Pharr2023] sec. 8.8
/// * mitchell: B = C = 1/3, stretched to the radius; it has negative lobes.
// [MitchellNetravali1988] eq. 8
pub fn weight(filter: Filter, radius: f32, x: f32, y: f32) -> f32 {
    (weight_1d(filter, f64::from(radius), f64::from(x)) * weight_1d(filter, f64::from(radius), f64::from(y)))
        as f32
}

/// Weight along one axis at `x` pixels from the centre, not normalised: the factor of [`weight`].
pub fn weight_1d(filter: Filter, radius: f64, x: f64) -> f64 {
    let x = x.abs();
    if x >= radius {
        return 0.0;
    }
    match filter {
        Filter::Box => 1.0,
        Filter::Triangle => radius - x,
        Filter::Gaussian => {
            let sigma = radius / 3.0;
            let gaussian = |d: f64| (-d * d / (2.0 * sigma * sigma)).exp();
            gaussian(x) - gaussian(radius)
        }
        Filter::Mitchell => {
            const B: f64 = 1.0 / 3.0;
            const C: f64 = 1.0 / 3.0;
            let t = 2.0 * x / radius;
            let value = if t < 1.0 {
                (12.0 - 9.0 * B - 6.0 * C) * t.powi(3)
                    + (-18.0 + 12.0 * B + 6.0 * C) * t.powi(2)
                    + (6.0 - 2.0 * B)
            } else {
                (-B - 6.0 * C) * t.powi(3)
                    + (6.0 * B + 30.0 * C) * t.powi(2)
                    + (-12.0 * B - 48.0 * C) * t
                    + (8.0 * B + 24.0 * C)
            };
            value / 6.0
        }
    }
}

/// Weights along one axis for a grid of `k` samples per pixel and axis: `(margin, weights)`.
///
/// Sample `j` of a pixel (`0..k`) lies at `(j + 0.5) / k - 0.5` pixels from its centre. `margin`
/// samples of the neighbours count on each side, so `weights` has `k + 2 margin` values and
/// `weights[i]` belongs to sample `i - margin`: in a film-wide row of samples, pixel `p` gathers
/// `p k - margin .. (p + 1) k + margin`.
///
/// The weights are symmetric multiples of 2^-22 that add up to exactly 1, in f32 and in any order
/// of summation, so that a constant image stays exactly constant where no neighbour is missing.
///
/// # Errors
/// [`Error::Usage`] if `k` is not 1..=64 or `radius` (pixels) is not in (0, 16].
pub fn sample_weights(filter: Filter, radius: f32, k: u32) -> Result<(u32, Vec<f32>)> {
    if !(1..=64).contains(&k) {
        return Err(Error::Usage(format!("found {k} samples along a pixel's side, expected 1 to 64")));
    }
    if !(radius > 0.0 && radius <= 16.0) {
        return Err(Error::Usage(format!(
            "found film.filter_radius = {radius}, expected more than 0 and at most 16 pixels"
        )));
    }
    let (radius, k_real) = (f64::from(radius), f64::from(k));
    // Samples with (j + 0.5) / k - 0.5 < radius, beyond the pixel's own k.
    let margin = (((radius + 0.5) * k_real - 0.5).ceil() - k_real).max(0.0) as u32;
    let count = (k + 2 * margin) as usize;
    let offset = |i: usize| (i as f64 - f64::from(margin) + 0.5) / k_real - 0.5;
    let mut raw: Vec<f64> = (0..count).map(|i| weight_1d(filter, radius, offset(i))).collect();
    if raw.iter().sum::<f64>() <= 0.0 {
        // The radius is so small that no sample falls within it: the innermost ones count.
        raw.fill(0.0);
        raw[(count - 1) / 2] = 1.0;
        raw[count / 2] = 1.0;
    }
    Ok((margin, normalised(&raw)))
}

/// Scales symmetric weights to integers that add up to 2^22, then to floats. No weight changes by
/// more than two units.
fn normalised(raw: &[f64]) -> Vec<f32> {
    const ONE: i64 = 1 << 22;
    let (count, sum) = (raw.len(), raw.iter().sum::<f64>());
    let mut parts: Vec<i64> = raw.iter().map(|w| (w / sum * ONE as f64).round() as i64).collect();
    // The remainder is at most half a unit per weight: it is distributed from the middle outwards,
    // in pairs, one unit each.
    let mut rest = ONE - parts.iter().sum::<i64>();
    let unit = rest.signum();
    if rest % 2 != 0 {
        parts[count / 2] += unit;
        rest -= unit;
    }
    for i in (0..count / 2).rev().take((rest.abs() / 2) as usize) {
        parts[i] += unit;
        parts[count - 1 - i] += unit;
    }
    parts.iter().map(|p| *p as f32 / ONE as f32).collect()
}
