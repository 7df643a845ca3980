//! The model of Chiang et al. in the form of Pharr et al.: a rough dielectric cylinder with
//! absorption, lossless if nothing is absorbed.
// [Chiang2016], [Pharr2023] sec. 9.9

use super::lobes::{Logistic, choose, fresnel, longitudinal, sample_longitudinal, wrap};
use super::{Angles, Hit};
use glam::Vec3;
use std::f32::consts::{PI, TAU};

/// Absorption of a fibre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Absorption {
    /// From the colour of the hair, so that a mass of such fibres has this colour: the coefficient
    /// is the square of the colour's logarithm over this divisor.
    Color(f32),
    /// Absorption coefficient, per radius of the fibre.
    Fixed(Vec3),
}

/// Lower bound of colours, because the logarithm of 0 is not finite.
pub const DARKEST: f32 = 1e-3;

impl Absorption {
    /// Absorption from the colour of the hair, for an azimuthal roughness in 0..1.
    pub fn by_color(roughness: f32) -> Self {
        Self::Color(Self::divisor(roughness))
    }

    /// Divisor of the colour's logarithm for an azimuthal roughness in 0..1.
    // [Chiang2016] sec. 4.2
    pub fn divisor(roughness: f32) -> f32 {
        let b = roughness;
        5.969 - 0.215 * b + 2.532 * b.powi(2) - 10.73 * b.powi(3) + 5.574 * b.powi(4) + 0.245 * b.powi(5)
    }

    /// Absorption coefficient of a hair of colour `tint`, per radius.
    pub fn of(&self, tint: Vec3) -> Vec3 {
        match self {
            Self::Fixed(sigma) => *sigma,
            Self::Color(divisor) => {
                let log = Vec3::from(tint.clamp(Vec3::splat(DARKEST), Vec3::ONE).to_array().map(f32::ln))
                    / *divisor;
                log * log
            }
        }
    }
}

/// The lobes R, TT, TRT and the rest, all longer paths together.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chiang {
    /// Relative index of refraction.
    pub ior: f32,
    /// Longitudinal variances of the four lobes.
    pub variance: [f32; 4],
    /// Scale of the azimuthal logistic distribution.
    pub scale: f32,
    around: Logistic,
    /// Rotations of θ_o by the tilt of the cuticle's scales, for the four lobes, radians.
    pub shift: [f32; 4],
    /// Absorption.
    pub absorption: Absorption,
}

/// Geometry of a ray within the fibre.
struct Within {
    gamma_o: f32,
    gamma_t: f32,
    /// Path length of one pass through the fibre, in radii.
    path_length: f32,
    fresnel: f32,
}

/// Longitudinal variance for a roughness of 0..1.
// [Chiang2016] eq. 7
pub fn longitudinal_variance(roughness: f32) -> f32 {
    (0.726 * roughness + 0.812 * roughness.powi(2) + 3.7 * roughness.powi(20)).powi(2)
}

/// Scale of the logistic distribution of the azimuth for a roughness of 0..1, radians.
// [Chiang2016] eq. 8
pub fn azimuthal_scale(roughness: f32) -> f32 {
    (PI / 8.0).sqrt() * (0.265 * roughness + 1.194 * roughness.powi(2) + 5.372 * roughness.powi(22))
}

impl Chiang {
    /// The model for `[longitudinal, azimuthal]` roughness in 0..1 and a tilt of the scales in
    /// radians; without `absorption` it follows the colour.
    // [Chiang2016] eq. 7 and 8, [Pharr2023] sec. 9.9
    pub fn new([along, around]: [f32; 2], tilt: f32, ior: f32, absorption: Option<Vec3>) -> Self {
        let v = longitudinal_variance(along);
        let scale = azimuthal_scale(around);
        Self {
            ior,
            variance: [v, 0.25 * v, 4.0 * v, 4.0 * v],
            scale,
            around: Logistic::turn(scale),
            shift: [-2.0 * tilt, tilt, 4.0 * tilt, 0.0],
            absorption: absorption.map_or_else(|| Absorption::by_color(around), Absorption::Fixed),
        }
    }

    fn within(&self, o: [f32; 2], h: f32) -> Within {
        let cos_o = o[1].max(1e-4);
        let inner = (self.ior * self.ior - o[0] * o[0]).max(1e-6).sqrt() / cos_o;
        let sin_t = (h / inner).clamp(-1.0, 1.0);
        let cos_theta_t = (1.0 - (o[0] / self.ior).powi(2)).max(0.0).sqrt();
        Within {
            gamma_o: h.clamp(-1.0, 1.0).asin(),
            gamma_t: sin_t.asin(),
            path_length: 2.0 * (1.0 - sin_t * sin_t).max(0.0).sqrt() / cos_theta_t,
            fresnel: fresnel(o[1] * (1.0 - h * h).max(0.0).sqrt(), self.ior),
        }
    }

    /// Attenuations of the lobes; `through` is the transmittance of one pass through the fibre.
    fn attenuation(fresnel: f32, through: Vec3) -> [Vec3; 4] {
        let r = Vec3::splat(fresnel);
        let tt = (1.0 - fresnel) * (1.0 - fresnel) * through;
        let trt = tt * through * fresnel;
        let rest = trt * fresnel * through / (Vec3::ONE - through * fresnel).max(Vec3::splat(1e-6));
        [r, tt, trt, rest]
    }

    fn attenuations(&self, within: &Within, tint: Vec3) -> [Vec3; 4] {
        let sigma = self.absorption.of(tint);
        let through = Vec3::from((-sigma * within.path_length).to_array().map(f32::exp));
        Self::attenuation(within.fresnel, through)
    }

    /// Azimuthal functions of the lobes at `phi` = φ_i − φ_o.
    fn azimuthal(&self, within: &Within, phi: f32) -> [f32; 4] {
        let at = |p: f32| self.around.pdf(wrap(phi - exit(p, within.gamma_o, within.gamma_t)));
        [at(0.0), at(1.0), at(2.0), 1.0 / TAU]
    }

    /// Sine and cosine of θ_o, rotated by the tilt for lobe `p`.
    pub fn turned(&self, p: usize, o: [f32; 2]) -> [f32; 2] {
        let (s, c) = self.shift[p].sin_cos();
        [o[0] * c + o[1] * s, (o[1] * c - o[0] * s).abs()]
    }

    /// Longitudinal functions of the lobes.
    pub fn along(&self, a: &Angles) -> [f32; 4] {
        [0, 1, 2, 3].map(|p| longitudinal(a.i, self.turned(p, a.o), self.variance[p]))
    }

    /// f cos θ_i at the offset of `hit`.
    // [Chiang2016], [Pharr2023] sec. 9.9
    pub fn scatter(&self, hit: &Hit, a: &Angles) -> Vec3 {
        let within = self.within(a.o, hit.h);
        let (attenuation, along) = (self.attenuations(&within, hit.tint), self.along(a));
        let around = self.azimuthal(&within, a.phi);
        (0..4).map(|p| attenuation[p] * along[p] * around[p]).sum()
    }

    fn shares(attenuation: &[Vec3; 4]) -> [f32; 4] {
        attenuation.map(|a| a.max_element() + 1e-6)
    }

    /// Samples the sine of θ_i and the azimuth.
    pub(super) fn sample(&self, hit: &Hit, o: [f32; 2], u: [f32; 4]) -> (f32, f32) {
        let within = self.within(o, hit.h);
        let (p, _) = choose(&Self::shares(&self.attenuations(&within, hit.tint)), u[0]);
        let sin = sample_longitudinal(self.turned(p, o), self.variance[p], [u[2], u[3]]);
        let phi = match p {
            3 => TAU * u[1] - PI,
            _ => wrap(exit(p as f32, within.gamma_o, within.gamma_t) + self.around.sample(u[1])),
        };
        (sin, phi)
    }

    /// Density of [`Chiang::sample`], 1/sr.
    pub(super) fn pdf(&self, hit: &Hit, a: &Angles) -> f32 {
        let within = self.within(a.o, hit.h);
        let shares = Self::shares(&self.attenuations(&within, hit.tint));
        let (along, around) = (self.along(a), self.azimuthal(&within, a.phi));
        (0..4).map(|p| shares[p] * along[p] * around[p]).sum::<f32>() / shares.iter().sum::<f32>()
    }

    /// Adds the azimuthal functions of the lobes, times their attenuations and `weight`, to
    /// `sum[layer * phis + k]` for azimuths from 0 to π; `o` is sine and cosine of θ_o, `h` the
    /// offset, and `radius` holds the transmittance exp(−σ) of one radius for each layer.
    pub(super) fn add_far(
        &self,
        o: [f32; 2],
        h: f32,
        weight: f32,
        radius: &[f32],
        phis: usize,
        sum: &mut [[f32; 4]],
    ) {
        let within = self.within(o, h);
        let attenuation: Vec<[f32; 4]> = radius
            .iter()
            .map(|t| {
                Self::attenuation(within.fresnel, Vec3::splat(t.powf(within.path_length)))
                    .map(|a| weight * a.x)
            })
            .collect();
        for k in 0..phis {
            let around = self.azimuthal(&within, PI * k as f32 / (phis - 1) as f32);
            for (layer, a) in attenuation.iter().enumerate() {
                (0..4).for_each(|p| sum[layer * phis + k][p] += a[p] * around[p]);
            }
        }
    }
}

/// Azimuth at which a ray leaves a smooth fibre after `p` passes through it.
// [Chiang2016], [Pharr2023] sec. 9.9
pub(super) fn exit(p: f32, gamma_o: f32, gamma_t: f32) -> f32 {
    2.0 * p * gamma_t - 2.0 * gamma_o + p * PI
}
