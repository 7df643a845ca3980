//! One-dimensional functions from which the models are composed, with their sampling.

use std::f32::consts::{PI, TAU};

/// I₀(x) e^−x, the exponentially scaled modified Bessel function of the first kind; x ≥ 0, relative
/// error below 1e-6.
// [AbramowitzStegun1964] 9.8.1 and 9.8.2
pub fn bessel_i0e(x: f32) -> f32 {
    if x < 3.75 {
        let t = (x / 3.75) * (x / 3.75);
        let sum = 1.0
            + t * (3.515_622_9
                + t * (3.089_942_4
                    + t * (1.206_749_2 + t * (0.265_973_2 + t * (0.036_076_8 + t * 0.004_581_3)))));
        return sum * (-x).exp();
    }
    let t = 3.75 / x;
    let sum = 0.398_942_3
        + t * (0.013_285_92
            + t * (0.002_253_19
                + t * (-0.001_575_65
                    + t * (0.009_162_81
                        + t * (-0.020_577_06
                            + t * (0.026_355_37 + t * (-0.016_476_33 + t * 0.003_923_77)))))));
    sum / x.sqrt()
}

/// Longitudinal scattering function of variance `v`; its integral times cos θ_i over the
/// inclination is 1 for every θ_o. `i` and `o` are sine and cosine of the inclinations.
// [DEon2011], in a form that does not overflow: I₀ and sinh are exponentially scaled.
pub fn longitudinal(i: [f32; 2], o: [f32; 2], v: f32) -> f32 {
    let product = i[1] * o[1];
    let exponent = (product - i[0] * o[0] - 1.0) / v;
    exponent.exp() * bessel_i0e(product / v) / (v * (1.0 - (-2.0 / v).exp()))
}

/// Samples the sine of an inclination from [`longitudinal`].
// [DEon2013], [Pharr2023] sec. 9.9
pub fn sample_longitudinal(o: [f32; 2], v: f32, u: [f32; 2]) -> f32 {
    let cos = 1.0 + v * (u[0].max(1e-7) + (1.0 - u[0]) * (-2.0 / v).exp()).ln();
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    (-cos * o[0] + sin * (TAU * u[1]).cos() * o[1]).clamp(-1.0, 1.0)
}

/// The logistic distribution of scale `s` around `mean`, truncated to an interval.
// [Pharr2023] sec. 9.9
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Logistic {
    mean: f32,
    s: f32,
    low: f32,
    high: f32,
    cdf_low: f32,
    cdf_high: f32,
}

fn logistic_cdf(x: f32, s: f32) -> f32 {
    1.0 / (1.0 + (-x / s).exp())
}

impl Logistic {
    /// The distribution truncated to `[low, high]`; `mean` is clamped to the interval.
    pub fn new(mean: f32, s: f32, [low, high]: [f32; 2]) -> Self {
        let mean = mean.clamp(low, high);
        let (cdf_low, cdf_high) = (logistic_cdf(low - mean, s), logistic_cdf(high - mean, s));
        Self { mean, s, low, high, cdf_low, cdf_high }
    }

    /// The distribution around 0, truncated to −π..π.
    pub fn turn(s: f32) -> Self {
        Self::new(0.0, s, [-PI, PI])
    }

    /// Probability density; 0 outside the interval.
    pub fn pdf(&self, x: f32) -> f32 {
        if x < self.low || x > self.high {
            return 0.0;
        }
        let e = (-(x - self.mean).abs() / self.s).exp();
        e / (self.s * (1.0 + e) * (1.0 + e) * (self.cdf_high - self.cdf_low))
    }

    /// The `u`-quantile.
    pub fn sample(&self, u: f32) -> f32 {
        let p = (self.cdf_low + u * (self.cdf_high - self.cdf_low)).clamp(1e-9, 1.0 - 6e-8);
        (self.mean - self.s * (1.0 / p - 1.0).ln()).clamp(self.low, self.high)
    }
}

/// Wraps an angle to −π..π.
pub fn wrap(x: f32) -> f32 {
    let x = x - TAU * (x / TAU).round();
    x.clamp(-PI, PI)
}

/// Wrapped normal density of standard deviation `width` on the circle; `x` in −π..π.
pub fn wrapped_gaussian(x: f32, width: f32) -> f32 {
    let g = |x: f32| (-0.5 * (x / width) * (x / width)).exp();
    let mut sum = g(x);
    for turn in 1..=(1 + (width * 5.0 / TAU) as i32) {
        sum += g(x - TAU * turn as f32) + g(x + TAU * turn as f32);
    }
    sum / (width * TAU.sqrt())
}

/// A standard normal deviate from two uniform numbers.
// [BoxMuller1958]
pub fn normal(u: [f32; 2]) -> f32 {
    (-2.0 * u[0].max(1e-12).ln()).sqrt() * (TAU * u[1]).cos()
}

/// Fresnel reflectance of a smooth dielectric of relative index `eta`, from outside, for
/// unpolarised light; `cos` is that of the angle of incidence.
pub fn fresnel(cos: f32, eta: f32) -> f32 {
    let cos = cos.clamp(0.0, 1.0);
    let cos_t = (1.0 - (1.0 - cos * cos) / (eta * eta)).max(0.0).sqrt();
    let parallel = (eta * cos - cos_t) / (eta * cos + cos_t);
    let perpendicular = (cos - eta * cos_t) / (cos + eta * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// Selects an index with probability proportional to its weight; also returns the random number,
/// rescaled to 0..1 for reuse.
pub fn choose(weights: &[f32], u: f32) -> (usize, f32) {
    let sum: f32 = weights.iter().sum();
    let mut rest = u * sum;
    let mut last = 0;
    for (i, w) in weights.iter().enumerate() {
        if *w > 0.0 {
            if rest < *w {
                return (i, (rest / w).clamp(0.0, 0.999_999_9));
            }
            last = i;
        }
        rest -= w;
    }
    (last, 0.999_999_9)
}
