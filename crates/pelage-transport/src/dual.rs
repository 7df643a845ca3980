//! Dual scattering, Zinke et al. 2008: how much light a hair scatters forward and backward, and how
//! much the hairs behind it send back.
//!
//! Forward means away from the light, in the half of the azimuths opposite to it; backward means
//! towards it. Pairs are in this order.

use crate::grid::{ALBEDOS, COSINES, albedo, cosine};
use glam::Vec3;
use pelage_fur::fibre::{Albedos, Fibre, Hemispheres};
use rayon::prelude::*;
use std::f32::consts::{FRAC_PI_2, PI};

/// What one hair does with light of one inclination, forward and backward.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Attenuation {
    /// Share of the light that is scattered into each half: the paper's average attenuations a_f
    /// and a_b.
    pub mean: [f32; 2],
    /// Mean shift of the inclination from the mirror cone, radians: alpha_f and alpha_b.
    pub shift: [f32; 2],
    /// Variance of the inclination, square radians: sigma_f² and sigma_b².
    pub variance: [f32; 2],
}

impl Attenuation {
    /// Share of the light that the hairs behind one send back: the paper's A_b. An endless row of
    /// hairs, each forward f and backward b, reflects R = b + f² R / (1 - b R); the first hair's
    /// own b is subtracted.
    ///
    /// DEVIATION: Zinke et al. 2008 keep the terms of one and three backward scatterings; this is
    /// the whole series.
    pub fn backscatter(&self) -> f32 {
        let [f, b] = self.mean;
        let half = 0.5 * (1.0 + b * b - f * f);
        let root = (half * half - b * b).max(0.0).sqrt();
        // The smaller root of b R² - 2 half R + b = 0, without cancellation.
        (b / (half + root) - b).max(0.0)
    }

    /// Mean shift (radians) and variance (square radians) of the inclination of
    /// [`Attenuation::backscatter`].
    // [Zinke2008] eq. 16 and 17
    pub fn backscatter_lobe(&self) -> (f32, f32) {
        let [f, b] = self.mean;
        let rest = (1.0 - f * f).max(1e-3);
        let shift = self.shift[1] * (1.0 - 2.0 * b * b / (rest * rest))
            + self.shift[0] * (2.0 * rest * rest + 4.0 * f * f * b * b) / rest.powi(3);
        let [vf, vb] = self.variance;
        let (wf, wb) = (vf.sqrt(), vb.sqrt());
        let width = (b * (2.0 * vf + vb).sqrt() + b.powi(3) * (2.0 * vf + 3.0 * vb).sqrt())
            / (b + b.powi(3) * (2.0 * wf + 3.0 * wb)).max(1e-6);
        let width = (1.0 + 0.7 * f * f) * width;
        (shift.clamp(-FRAC_PI_2, FRAC_PI_2), (width * width).clamp(1e-4, 4.0))
    }
}

impl From<Hemispheres> for Attenuation {
    /// Of the first colour channel.
    fn from(of: Hemispheres) -> Self {
        let sides = [of.forward, of.backward];
        Self {
            mean: sides.map(|s| s.albedo.x.min(0.9999)),
            shift: sides.map(|s| s.shift),
            variance: sides.map(|s| (s.width * s.width).max(1e-4)),
        }
    }
}

/// Dual scattering of a fibre model: `[albedo][sine of the inclination]`, two entries each.
///
/// First a_f, a_b, [`Attenuation::backscatter`] and its shift; then the variances forward, backward
/// and of the backscatter, and the shift backward.
pub fn table(fibre: &Fibre) -> Vec<[f32; 4]> {
    let albedos = Albedos::new(fibre);
    (0..ALBEDOS * COSINES)
        .into_par_iter()
        .flat_map_iter(|i| {
            let theta = cosine(i % COSINES, -1.0).clamp(-0.995, 0.995).asin();
            let s = Attenuation::from(albedos.hemispherical(theta, Vec3::splat(albedo(i / COSINES))));
            let (shift, variance) = s.backscatter_lobe();
            [
                [s.mean[0], s.mean[1], s.backscatter(), shift],
                [s.variance[0], s.variance[1], variance, s.shift[1]],
            ]
        })
        .collect()
}

/// Radiance that a hair sends to a view of light that was scattered more than once, for an
/// irradiance of 1 perpendicular to the light; the cosine of incidence is included.
///
/// `entries` are those of [`table`] at the difference angle (theta_o - theta_i) / 2, `tau` the
/// optical depth towards the light, `density` the density factors d_f and d_b, 0 where a term is
/// off.
// [Zinke2008] eq. 5, 12 and 20
pub fn scatter(entries: [[f32; 4]; 2], [theta_i, theta_o]: [f32; 2], tau: f32, density: [f32; 2]) -> f32 {
    let [[a_f, a_b, backscatter, backscatter_shift], [variance_f, variance_b, backscatter_variance, shift_b]] =
        entries;
    let gaussian = |x: f32, variance: f32| (-0.5 * x * x / variance).exp() / (2.0 * PI * variance).sqrt();
    let turn = theta_i + theta_o;
    let cos_d = (0.5 * (theta_o - theta_i)).cos();
    // Light that meets no hair before this one, and light that other hairs scatter forward to it.
    let direct = (-tau).exp();
    // DEVIATION: the number of hairs in front is Poisson distributed with mean tau; Zinke et al.
    // 2008 count them along the ray.
    let forward = density[0] * ((-tau * (1.0 - a_f)).exp() - direct);
    let spread = (tau * a_f).max(1.0) * variance_f;
    // Towards the view, such light comes from the hairs behind, or from this hair's own backward
    // scattering.
    let from_behind = |variance: f32| {
        2.0 * backscatter * gaussian(turn - backscatter_shift, backscatter_variance + variance)
    };
    let by_hair = a_b * gaussian(turn - shift_b, variance_b + spread);
    let sum =
        direct * density[1] * from_behind(0.0) + forward * (by_hair + PI * density[1] * from_behind(spread));
    theta_i.cos().max(0.0) * sum / (PI * (cos_d * cos_d).max(0.05))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_fur::fibre::KajiyaKay;

    #[test]
    fn an_endless_row_sends_back_what_a_long_one_does() {
        let of = |f: f32, b: f32| Attenuation { mean: [f, b], ..Default::default() }.backscatter();
        // Rows of hairs added one by one, from the back.
        for (f, b) in [(0.6f32, 0.1f32), (0.7, 0.2), (0.3, 0.6)] {
            let mut row = 0.0;
            for _ in 0..500 {
                row = b + f * f * row / (1.0 - b * row);
            }
            assert!((of(f, b) - (row - b)).abs() < 1e-5, "{f} {b}: {} {row}", of(f, b));
        }
        assert!((of(0.6, 0.1) - 0.05767).abs() < 2e-5);
        assert!((of(0.6, 0.4) - 0.6).abs() < 1e-2, "lossless: all comes back, {}", of(0.6, 0.4));
    }

    #[test]
    fn a_diffuse_hair_scatters_as_much_forward_as_backward() {
        let fibre = Fibre::KajiyaKay(KajiyaKay::new(1.0, 0.0, 1.0));
        let s = Attenuation::from(Albedos::new(&fibre).hemispherical(0.3f32.asin(), Vec3::splat(0.8)));
        assert!((s.mean[0] - 0.4).abs() < 0.01 && (s.mean[1] - 0.4).abs() < 0.01, "{s:?}");
    }
}
