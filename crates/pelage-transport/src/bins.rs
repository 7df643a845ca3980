//! Bins of the cosine to the skin's normal: the directions of the radiative transfer.
//!
//! Radiance is a mean over azimuth and over a bin. Bins are numbered from straight down (cosine -1)
//! to straight up (1).

use std::sync::LazyLock;

/// Bins in a hemisphere. Fibres send light into narrow cones, which coarse bins would spread over
/// other inclinations.
pub const HALF: usize = 24;
/// Bins in the sphere.
pub const BINS: usize = 2 * HALF;

/// Edges of the bins in the cosine: the mean of an even spacing in the cosine and an even spacing
/// in the angle.
pub fn edges() -> [f64; BINS + 1] {
    static EDGES: LazyLock<[f64; BINS + 1]> = LazyLock::new(|| {
        std::array::from_fn(|k| {
            let x = (k as f64 - HALF as f64) / HALF as f64;
            0.5 * (x + (x * std::f64::consts::FRAC_PI_2).sin())
        })
    });
    *EDGES
}

/// Widths of the bins in the cosine.
pub fn widths() -> [f64; BINS] {
    let e = edges();
    std::array::from_fn(|k| e[k + 1] - e[k])
}

/// Cosine at the centre of a bin.
pub(crate) fn centre(bin: usize) -> f64 {
    let e = edges();
    0.5 * (e[bin] + e[bin + 1])
}

/// The two bins whose centres enclose the cosine `mu`, and the weight of the second; twice the
/// outermost bin, with a weight of 0, beyond its centre.
pub(crate) fn neighbours(mu: f64) -> (usize, usize, f64) {
    let e = edges();
    let centre = |k: usize| 0.5 * (e[k] + e[k + 1]);
    let after = (0..BINS).find(|k| centre(*k) > mu).unwrap_or(BINS);
    if after == 0 || after == BINS {
        let k = if after == 0 { 0 } else { BINS - 1 };
        return (k, k, 0.0);
    }
    let (a, b) = (centre(after - 1), centre(after));
    (after - 1, after, (mu - a) / (b - a))
}

/// A function of direction that is known by bin, interpolated at the cosine `mu`.
pub(crate) fn interpolate(by_bin: &[f64; BINS], mu: f64) -> f64 {
    let (a, b, x) = neighbours(mu);
    by_bin[a] + (by_bin[b] - by_bin[a]) * x
}
