//! One-dimensional functions that the models are made of, each with its samples.

use std::f32::consts::{PI, TAU};

/// I0(x) e^-x, the modified Bessel function of the first kind without its growth; x >= 0, relative error below 1e-6.
// Abramowitz and Stegun, Handbook of mathematical functions, 9.8.1 and 9.8.2
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

/// Longitudinal function of variance `v`: its integral times cos over the inclination is 1 for every inclination of the eye.
/// `i` and `o` are sine and cosine of the inclinations.
// [DEon2011], in a form that does not overflow: I0 and sinh without their growth
pub fn longitudinal(i: [f32; 2], o: [f32; 2], v: f32) -> f32 {
    let product = i[1] * o[1];
    let exponent = (product - i[0] * o[0] - 1.0) / v;
    exponent.exp() * bessel_i0e(product / v) / (v * (1.0 - (-2.0 / v).exp()))
}

/// Sine of an inclination drawn by [`longitudinal`].
pub fn sample_longitudinal(o: [f32; 2], v: f32, u: [f32; 2]) -> f32 {
    let cos = 1.0 + v * (u[0].max(1e-7) + (1.0 - u[0]) * (-2.0 / v).exp()).ln();
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    (-cos * o[0] + sin * (TAU * u[1]).cos() * o[1]).clamp(-1.0, 1.0)
}

/// The logistic distribution of scale `s` around `mean`, cut to an interval.
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
    /// `mean` is moved into the interval.
    pub fn new(mean: f32, s: f32, [low, high]: [f32; 2]) -> Self {
        let mean = mean.clamp(low, high);
        let (cdf_low, cdf_high) = (logistic_cdf(low - mean, s), logistic_cdf(high - mean, s));
        Self { mean, s, low, high, cdf_low, cdf_high }
    }

    /// Around 0 between -pi and pi.
    pub fn turn(s: f32) -> Self {
        Self::new(0.0, s, [-PI, PI])
    }

    /// Density; 0 outside of the interval.
    pub fn pdf(&self, x: f32) -> f32 {
        if x < self.low || x > self.high {
            return 0.0;
        }
        let e = (-(x - self.mean).abs() / self.s).exp();
        e / (self.s * (1.0 + e) * (1.0 + e) * (self.cdf_high - self.cdf_low))
    }

    /// The place under which a share `u` of the distribution lies.
    pub fn sample(&self, u: f32) -> f32 {
        let p = (self.cdf_low + u * (self.cdf_high - self.cdf_low)).clamp(1e-9, 1.0 - 6e-8);
        (self.mean - self.s * (1.0 / p - 1.0).ln()).clamp(self.low, self.high)
    }
}

/// An angle between -pi and pi.
pub fn wrap(x: f32) -> f32 {
    let x = x - TAU * (x / TAU).round();
    x.clamp(-PI, PI)
}

/// Gaussian of unit area on the circle; `x` between -pi and pi.
pub fn wrapped_gaussian(x: f32, width: f32) -> f32 {
    let g = |x: f32| (-0.5 * (x / width) * (x / width)).exp();
    let mut sum = g(x);
    for turn in 1..=(1 + (width * 5.0 / TAU) as i32) {
        sum += g(x - TAU * turn as f32) + g(x + TAU * turn as f32);
    }
    sum / (width * TAU.sqrt())
}

/// Two random numbers to a standard normal one.
pub fn normal(u: [f32; 2]) -> f32 {
    // Box and Muller
    (-2.0 * u[0].max(1e-12).ln()).sqrt() * (TAU * u[1]).cos()
}

/// Reflectance of a smooth dielectric of relative index `eta`, from outside.
pub fn fresnel(cos: f32, eta: f32) -> f32 {
    let cos = cos.clamp(0.0, 1.0);
    let cos_t = (1.0 - (1.0 - cos * cos) / (eta * eta)).max(0.0).sqrt();
    let parallel = (eta * cos - cos_t) / (eta * cos + cos_t);
    let perpendicular = (cos - eta * cos_t) / (cos + eta * cos_t);
    0.5 * (parallel * parallel + perpendicular * perpendicular)
}

/// Takes a share of the interval 0..1 by weights: the index, and the random number stretched back to 0..1.
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
