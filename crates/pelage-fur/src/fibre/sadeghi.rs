//! The model of Sadeghi et al.: lobes R, TT, TRT and glints, each with its own intensity, and a
//! Kajiya–Kay diffuse term. Lobes of unit height do not conserve energy; [`Sadeghi::normalised`]
//! limits them.
// [Sadeghi2010], [KajiyaKay1989]

use super::kajiya_kay::{diffuse_pdf, diffuse_sample};
use super::lobes::{Logistic, choose, wrap};
use super::{Angles, Hit};
use glam::Vec3;
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// Rows of the albedo table, one for each inclination.
pub const ALBEDO_ROWS: usize = 128;

/// Lobes and weights; angles in radians.
#[derive(Debug, Clone, PartialEq)]
pub struct Sadeghi {
    /// Intensities of R, TT, TRT.
    pub intensity: [f32; 3],
    /// Longitudinal shifts of R, TT, TRT.
    pub shift: [f32; 3],
    /// Longitudinal widths of R, TT, TRT: standard deviations in the half angle.
    pub width: [f32; 3],
    /// Azimuthal width of TT.
    pub azimuth_tt: f32,
    /// Intensity of the glints relative to TRT.
    pub glint: f32,
    /// Azimuthal width of the glints.
    pub glint_width: f32,
    /// Weight of the diffuse term.
    pub diffuse: f32,
    /// For the normalised model, directional albedos of R, TT, TRT of a white hair at evenly spaced
    /// inclinations from −π/2 to π/2; otherwise `None`.
    pub albedo: Option<Vec<[f32; 3]>>,
}

/// Gaussian of unit height and standard deviation `width`.
fn unit_gaussian(x: f32, width: f32) -> f32 {
    (-0.5 * x * x / (width * width)).exp()
}

/// Scale of the logistic distribution that is sampled instead of a Gaussian of unit width. Its
/// tails are heavier, so that sample weights stay bounded.
const LOGISTIC: f32 = 0.6;

impl Sadeghi {
    /// The model, scaled so that no more light leaves the hair than enters it.
    // DEVIATION: [Sadeghi2010] leaves it to the artist to avoid lobes that create energy.
    pub fn normalised(mut self) -> Self {
        self.albedo = None;
        self.albedo = Some((0..ALBEDO_ROWS).map(|row| self.lobe_albedo(row)).collect());
        self
    }

    /// Integrals of the lobes over all light directions at a row of the table.
    fn lobe_albedo(&self, row: usize) -> [f32; 3] {
        let theta_o = (row as f32 / (ALBEDO_ROWS - 1) as f32 - 0.5) * PI;
        let o = [theta_o.sin(), theta_o.cos().max(0.0)];
        let azimuth = [
            4.0,
            quadrature(-PI, PI, 512, |x| unit_gaussian(x, self.azimuth_tt)),
            4.0 + 2.0 * self.glint * quadrature(-PI, PI, 512, |x| unit_gaussian(x, self.glint_width)),
        ];
        [0, 1, 2].map(|lobe| {
            let along = quadrature(-FRAC_PI_2, FRAC_PI_2, 1024, |theta_i| {
                let i = [theta_i.sin(), theta_i.cos()];
                i[1] * i[1] * self.along(lobe, 0.5 * (theta_i + theta_o)) / cut(i, o)
            });
            self.intensity[lobe] * azimuth[lobe] * along
        })
    }

    fn along(&self, lobe: usize, theta_h: f32) -> f32 {
        unit_gaussian(theta_h - self.shift[lobe], self.width[lobe])
    }

    /// Normalisation factor on f: one over the albedo where that exceeds one, at whichever of the
    /// two inclinations it is larger, so that the model stays reciprocal.
    fn factor(&self, a: &Angles, tint: Vec3) -> Vec3 {
        let Some(table) = &self.albedo else { return Vec3::ONE };
        let albedo = |sin: f32| {
            let x = (sin.asin() / PI + 0.5) * (ALBEDO_ROWS - 1) as f32;
            let row = (x as usize).min(ALBEDO_ROWS - 2);
            let [low, high] = [0, 1].map(|k| Vec3::from(table[row + k]));
            let lobes = low.lerp(high, x - row as f32);
            lobes.x + tint * (lobes.y + self.diffuse + tint * lobes.z)
        };
        Vec3::ONE / albedo(a.i[0]).max(albedo(a.o[0])).max(Vec3::ONE)
    }

    /// f cos θ_i.
    // [Sadeghi2010]; the diffuse term is that of [KajiyaKay1989].
    pub fn scatter(&self, hit: &Hit, a: &Angles) -> Vec3 {
        let tint = hit.tint;
        let phi = a.phi.abs();
        let theta_h = 0.5 * (a.i[0].asin() + a.o[0].asin());
        let n_r = (0.5 * phi).cos();
        let n_tt = unit_gaussian(PI - phi, self.azimuth_tt);
        let n_glint = self.glint * unit_gaussian(hit.glint_angle - phi, self.glint_width);
        let lobes = self.intensity[0] * self.along(0, theta_h) * n_r * Vec3::ONE
            + self.intensity[1] * self.along(1, theta_h) * n_tt * tint
            + self.intensity[2] * self.along(2, theta_h) * (n_r + n_glint) * tint * tint;
        a.i[1] * (lobes / cut(a.i, a.o) + self.diffuse / (PI * PI) * tint) * self.factor(a, tint)
    }

    /// Unnormalised sampling probabilities of R, TT, TRT, glints and diffuse.
    fn shares(&self, tint: Vec3) -> [f32; 5] {
        let bright = tint.max_element();
        let along = |lobe: usize| self.intensity[lobe] * self.width[lobe] * 2.0 * TAU.sqrt();
        [
            4.0 * along(0),
            TAU.sqrt() * self.azimuth_tt * along(1) * bright,
            4.0 * along(2) * bright * bright,
            2.0 * TAU.sqrt() * self.glint_width * self.glint * along(2) * bright * bright,
            (self.diffuse * bright).max(1e-4),
        ]
    }

    fn theta_i(&self, lobe: usize, theta_o: f32) -> Logistic {
        let s = 2.0 * LOGISTIC * self.width[lobe];
        Logistic::new(2.0 * self.shift[lobe] - theta_o, s, [-FRAC_PI_2, FRAC_PI_2])
    }

    fn glint_azimuth(&self, hit: &Hit) -> Logistic {
        Logistic::new(hit.glint_angle, LOGISTIC * self.glint_width, [0.0, PI])
    }

    /// Samples the sine of θ_i and the azimuth.
    pub(super) fn sample(&self, hit: &Hit, o: [f32; 2], u: [f32; 4]) -> (f32, f32) {
        let (lobe, _) = choose(&self.shares(hit.tint), u[3]);
        if lobe == 4 {
            return (diffuse_sample([u[0], u[1]]), TAU * u[2] - PI);
        }
        let sin = self.theta_i(lobe.min(2), o[0].asin()).sample(u[0]).sin();
        let phi = match lobe {
            1 => wrap(PI + Logistic::turn(LOGISTIC * self.azimuth_tt).sample(u[1])),
            3 => self.glint_azimuth(hit).sample(u[1]) * if u[2] < 0.5 { -1.0 } else { 1.0 },
            _ => 2.0 * (2.0 * u[1] - 1.0).clamp(-1.0, 1.0).asin(),
        };
        (sin, phi)
    }

    /// Density of [`Sadeghi::sample`], 1/sr.
    pub(super) fn pdf(&self, hit: &Hit, a: &Angles) -> f32 {
        let shares = self.shares(hit.tint);
        let (theta_i, theta_o) = (a.i[0].asin(), a.o[0].asin());
        let phi = a.phi.abs();
        let even = 0.25 * (0.5 * phi).cos();
        let along = [0, 1, 2].map(|lobe| self.theta_i(lobe, theta_o).pdf(theta_i));
        let sum = shares[0] * along[0] * even
            + shares[1] * along[1] * Logistic::turn(LOGISTIC * self.azimuth_tt).pdf(PI - phi)
            + shares[2] * along[2] * even
            + shares[3] * along[2] * 0.5 * self.glint_azimuth(hit).pdf(phi);
        let whole: f32 = shares.iter().sum();
        (sum / a.i[1].max(1e-6) + shares[4] * diffuse_pdf(a.i[1])) / whole
    }
}

/// cos² of the difference angle (θ_i − θ_o)/2, bounded from below because lobes are divided by it.
fn cut(i: [f32; 2], o: [f32; 2]) -> f32 {
    // cos²(x / 2) from cos x.
    (0.5 * (1.0 + i[1] * o[1] + i[0] * o[0])).max(0.05)
}

/// Midpoint rule.
fn quadrature(low: f32, high: f32, steps: u32, f: impl Fn(f32) -> f32) -> f32 {
    let d = f64::from(high - low) / f64::from(steps);
    let sum: f64 = (0..steps).map(|k| f64::from(f(low + ((f64::from(k) + 0.5) * d) as f32))).sum();
    (sum * d) as f32
}
