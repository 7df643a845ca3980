//! The shares of Zinke et al. 2008 (dual scattering): what a hair scatters on and back, and what many hairs behind it send back.

use super::{ALBEDOS, COSINES, cosine, tint};
use glam::Vec3;
use pelage_fur::fibre::{Albedos, Fibre, Hemispheres};
use rayon::prelude::*;
use std::f32::consts::{FRAC_PI_2, PI};

/// What hairs of one brightness do with light of one inclination.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Shares {
    /// Share scattered on, away from the light in azimuth, and back.
    pub share: [f32; 2],
    /// Mean shift of the inclination from the mirror cone, radians, on and back.
    pub shift: [f32; 2],
    /// Its variance, square radians.
    pub variance: [f32; 2],
}

impl Shares {
    /// Light that hairs behind send back, all orders, less what the hair itself does: R = b + f² R / (1 - b R) for an endless row.
    ///
    /// DEVIATION: Zinke et al. 2008 keep one and three backward scatterings; this is the whole series.
    pub fn behind(&self) -> f32 {
        let [f, b] = self.share;
        let half = 0.5 * (1.0 + b * b - f * f);
        let root = (half * half - b * b).max(0.0).sqrt();
        // The smaller root of b R² - 2 half R + b = 0, without cancellation.
        (b / (half + root) - b).max(0.0)
    }

    /// Mean shift and variance of [`Shares::behind`].
    // [Zinke2008] eq. 16 and 17
    pub fn behind_lobe(&self) -> (f32, f32) {
        let [f, b] = self.share;
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

impl From<Hemispheres> for Shares {
    /// Of the first colour.
    fn from(of: Hemispheres) -> Self {
        let sides = [of.forward, of.backward];
        Self {
            share: sides.map(|s| s.albedo.x.min(0.9999)),
            shift: sides.map(|s| s.shift),
            variance: sides.map(|s| (s.width * s.width).max(1e-4)),
        }
    }
}

/// Shares of a model, two entries for each `[tint][sine of the inclination]`: on, back, from behind, its shift; then variances on, back,
/// from behind, and the shift back.
pub fn table(fibre: &Fibre) -> Vec<[f32; 4]> {
    let albedos = Albedos::new(fibre);
    (0..ALBEDOS * COSINES)
        .into_par_iter()
        .flat_map_iter(|i| {
            let theta = cosine(i % COSINES, -1.0).clamp(-0.995, 0.995).asin();
            let s = Shares::from(albedos.hemispherical(theta, Vec3::splat(tint(i / COSINES))));
            let (shift, variance) = s.behind_lobe();
            [
                [s.share[0], s.share[1], s.behind(), shift],
                [s.variance[0], s.variance[1], variance, s.shift[1]],
            ]
        })
        .collect()
}

/// Light scattered more than once towards a view, for an irradiance of 1 across the light, by the two entries of a table at the
/// difference angle; `density` are the density factors on and back, 0 where a term is off; the cosine of incidence is in it.
// [Zinke2008] eq. 5, 12 and 20
pub fn scatter(entries: [[f32; 4]; 2], [theta_i, theta_o]: [f32; 2], tau: f32, density: [f32; 2]) -> f32 {
    let [[on, back, behind, behind_shift], [on_variance, back_variance, behind_variance, back_shift]] =
        entries;
    let gaussian = |x: f32, variance: f32| (-0.5 * x * x / variance).exp() / (2.0 * PI * variance).sqrt();
    let turn = theta_i + theta_o;
    let cos_d = (0.5 * (theta_o - theta_i)).cos();
    let direct = (-tau).exp();
    // DEVIATION: the number of hairs on the way has a Poisson distribution here, of mean tau.
    let forward = density[0] * ((-tau * (1.0 - on)).exp() - direct);
    let spread = (tau * on).max(1.0) * on_variance;
    let from_behind =
        |variance: f32| 2.0 * behind * gaussian(turn - behind_shift, behind_variance + variance);
    let around = back * gaussian(turn - back_shift, back_variance + spread);
    let sum =
        direct * density[1] * from_behind(0.0) + forward * (around + PI * density[1] * from_behind(spread));
    theta_i.cos().max(0.0) * sum / (PI * (cos_d * cos_d).max(0.05))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_fur::fibre::KajiyaKay;

    #[test]
    fn an_endless_row_sends_back_what_a_long_one_does() {
        let of = |f: f32, b: f32| Shares { share: [f, b], ..Default::default() }.behind();
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
    fn a_diffuse_hair_scatters_as_much_on_as_back() {
        let fibre = Fibre::KajiyaKay(KajiyaKay::new(1.0, 0.0, 1.0));
        let s = Shares::from(Albedos::new(&fibre).hemispherical(0.3f32.asin(), Vec3::splat(0.8)));
        assert!((s.share[0] - 0.4).abs() < 0.01 && (s.share[1] - 0.4).abs() < 0.01, "{s:?}");
    }
}
