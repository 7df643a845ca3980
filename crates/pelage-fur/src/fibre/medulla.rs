//! The model of Yan et al.: a cortex around a medulla that scatters light. Lobes R, TT, TRT as in a
//! plain fibre, and TTs and TRTs, scattered in the medulla on the first or second pass.
// [Yan2017]

pub mod scatter;

use super::chiang::{Absorption, exit};
use super::lobes::{choose, fresnel, longitudinal, normal, sample_longitudinal, wrap, wrapped_gaussian};
use super::{Angles, Hit, inclination};
use glam::Vec3;
use scatter::{Medium, ScatterTable};
use std::f32::consts::{PI, TAU};
use std::path::Path;
use std::sync::Arc;

/// Parameters of a fibre with a medulla; coefficients are per radius of the hair, angles in
/// radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parts {
    /// Index of refraction.
    pub ior: f32,
    /// Tilt of the cuticle's scales.
    pub tilt: f32,
    /// Number of layers of the cuticle.
    pub layers: f32,
    /// Absorption of the cortex.
    pub absorption: Absorption,
    /// Radius of the medulla relative to that of the hair, below 1.
    pub radius: f32,
    /// Scattering coefficient of the medulla.
    pub scattering: f32,
    /// Absorption coefficient of the medulla.
    pub medulla_absorption: f32,
    /// Mean cosine g of the medulla's phase function.
    pub anisotropy: f32,
    /// Longitudinal and azimuthal widths.
    pub width: [f32; 2],
}

/// A fibre with its scattering tables.
#[derive(Debug, Clone, PartialEq)]
pub struct Medulla {
    /// Parameters.
    pub parts: Parts,
    table: Option<Arc<ScatterTable>>,
}

/// Geometry and transmittances of a ray within the fibre.
struct Within {
    gamma_o: f32,
    gamma_t: f32,
    fresnel: f32,
    /// Path lengths in the cortex: of an unscattered pass; and up to scattering and out.
    cortex: [f32; 2],
    /// Transmittance of the medulla's absorption: for an unscattered pass, and for a scattered one.
    medulla: [f32; 2],
    /// Fraction that is not scattered in a pass.
    unscattered: f32,
    /// Offset in the medulla, relative to its radius.
    offset: f32,
}

/// Smallest longitudinal width, radians; the width of R would vanish in the forward direction.
const LEAST_WIDTH: f32 = 0.01;

/// Number of lobes: R, TT, TRT, TTs, TRTs, and all longer paths.
const LOBES: usize = 6;

impl Medulla {
    /// The model, with tables from the cache folder `cache`, or simulated if they are not there.
    pub fn new(parts: Parts, cache: Option<&Path>) -> Self {
        let scatters = parts.radius > 1e-3 && parts.scattering > 1e-4;
        let medium = Medium {
            scattering: parts.scattering * parts.radius,
            anisotropy: parts.anisotropy,
            ior: parts.ior,
        };
        Self { parts, table: scatters.then(|| Arc::new(ScatterTable::cached(medium, cache))) }
    }

    // [Yan2017]: s_c and s_m are half the path lengths in cortex and medulla; F_l is the
    // reflectance of the cuticle's layers.
    fn within(&self, o: [f32; 2], h: f32) -> Within {
        let parts = &self.parts;
        let cos_o = o[1].max(1e-4);
        let inner = (parts.ior * parts.ior - o[0] * o[0]).max(1e-6).sqrt() / cos_o;
        let sin_t = (h / inner).clamp(-1.0, 1.0);
        let cos_theta_t = (1.0 - (o[0] / parts.ior).powi(2)).max(0.0).sqrt();
        let whole = (1.0 - sin_t * sin_t).max(0.0).sqrt();
        let (in_medulla, offset) = match &self.table {
            Some(_) => ((parts.radius * parts.radius - sin_t * sin_t).max(0.0).sqrt(), sin_t / parts.radius),
            None => (0.0, 1.0),
        };
        let in_cortex = whole - in_medulla;
        let f = fresnel(o[1] * (1.0 - h * h).max(0.0).sqrt(), parts.ior);
        let scattered_length = match &self.table {
            Some(table) if offset.abs() < 1.0 => parts.radius * table.path_length(o[0], offset),
            _ => 0.0,
        };
        Within {
            gamma_o: h.clamp(-1.0, 1.0).asin(),
            gamma_t: sin_t.asin(),
            fresnel: parts.layers * f / (1.0 + (parts.layers - 1.0) * f).max(1e-6),
            cortex: [2.0 * in_cortex, in_cortex + 1.0 - parts.radius].map(|x| x / cos_theta_t),
            medulla: [2.0 * in_medulla / cos_theta_t, scattered_length]
                .map(|x| (-x * parts.medulla_absorption).exp()),
            unscattered: (-2.0 * in_medulla / cos_theta_t * parts.scattering).exp(),
            offset: offset.clamp(-1.0, 1.0),
        }
    }

    /// Attenuations of the lobes for the transmittances of the cortex over the two path lengths of
    /// [`Within::cortex`].
    // [Yan2017]. DEVIATION: what is scattered in a pass is exactly what is not left unscattered, so
    // that energy is conserved; longer paths, which the paper omits, join the light from the
    // medulla, uniform in azimuth.
    fn attenuation(w: &Within, [pass, half]: [f32; 2]) -> [f32; LOBES] {
        let f = w.fresnel;
        let through = pass * w.medulla[0] * w.unscattered;
        let scattered = (1.0 - w.unscattered) * half * w.medulla[1];
        let (tt, tts) = ((1.0 - f) * (1.0 - f) * through, (1.0 - f) * scattered);
        let again = f * through;
        let rest = again * again / (1.0 - again).max(1e-6);
        [f, tt, tt * again, tts, tts * again, rest * (tt + tts)]
    }

    fn attenuations(&self, w: &Within, tint: Vec3) -> [Vec3; LOBES] {
        let sigma = self.parts.absorption.of(tint);
        let [r, g, b] =
            sigma.to_array().map(|s| Self::attenuation(w, w.cortex.map(|length| (-s * length).exp())));
        std::array::from_fn(|p| Vec3::new(r[p], g[p], b[p]))
    }

    /// Azimuth of propagation within the medulla on the `p`th pass.
    fn inside(w: &Within, p: f32) -> f32 {
        PI + w.gamma_t - w.gamma_o + (p - 1.0) * (PI + 2.0 * w.gamma_t)
    }

    fn azimuthal(&self, w: &Within, o: [f32; 2], phi: f32) -> [f32; LOBES] {
        let plain = |p: f32| {
            wrapped_gaussian(
                wrap(phi - exit(p, w.gamma_o, w.gamma_t)),
                self.parts.width[1] * (p + 1.0).sqrt(),
            )
        };
        let scattered = |p: f32| match &self.table {
            Some(table) if w.unscattered < 1.0 => {
                table.around(o[0], w.offset, wrap(phi - Self::inside(w, p)))
            }
            _ => 1.0 / TAU,
        };
        [plain(0.0), plain(1.0), plain(2.0), scattered(1.0), scattered(2.0), 1.0 / TAU]
    }

    /// Inclination (sine, cosine) whose mirror cone is the centre of lobe R, TT or TRT (`p` = 0, 1,
    /// 2), and the lobe's variance.
    // [Yan2017]: R lies on the cone of the tilted surface; TT and TRT have fixed shifts.
    fn cone(&self, p: usize, o: [f32; 2], phi: f32) -> ([f32; 2], f32) {
        let (tilt, width) = (self.parts.tilt, self.parts.width[0]);
        if p == 0 {
            let half = (0.5 * phi).cos();
            let (s, c) = tilt.sin_cos();
            let u = half * c * o[1] + s * o[0];
            let width = (2f32.sqrt() * width * half).max(LEAST_WIDTH);
            return (inclination(o[0] - 2.0 * s * u), width * width);
        }
        let (shift, width) = if p == 1 { (tilt, width) } else { (3.0 * tilt, 1.5 * width) };
        let (s, c) = shift.sin_cos();
        ([o[0] * c + o[1] * s, (o[1] * c - o[0] * s).abs()], width * width)
    }

    /// Longitudinal functions of R, TT, TRT and of all scattered light.
    // DEVIATION: [Yan2017] divides Gaussians by cos², which loses light at grazing angles; this
    // function is normalised on the sphere.
    pub fn along(&self, a: &Angles) -> [f32; 4] {
        let plain = |p: usize| {
            let (o, v) = self.cone(p, a.o, a.phi);
            longitudinal(a.i, o, v)
        };
        [plain(0), plain(1), plain(2), self.scattered_along(a.o[0], a.i[0])]
    }

    /// Density of the sine of θ_i for scattered light.
    pub fn scattered_along(&self, sin_o: f32, sin_i: f32) -> f32 {
        self.table.as_ref().map_or(0.5, |table| table.along(sin_o, sin_i))
    }

    /// f cos θ_i at the offset of `hit`.
    pub fn scatter(&self, hit: &Hit, a: &Angles) -> Vec3 {
        let w = self.within(a.o, hit.h);
        let (attenuation, along) = (self.attenuations(&w, hit.tint), self.along(a));
        let around = self.azimuthal(&w, a.o, a.phi);
        (0..LOBES).map(|p| attenuation[p] * along[p.min(3)] * around[p]).sum()
    }

    /// Energies of the lobes at offset `h` for a fibre whose cortex absorbs nothing; `o` is sine
    /// and cosine of θ_o.
    pub fn energies(&self, o: [f32; 2], h: f32) -> [f32; LOBES] {
        Self::attenuation(&self.within(o, h), [1.0; 2])
    }

    fn shares(attenuation: &[Vec3; LOBES]) -> [f32; LOBES] {
        attenuation.map(|a| a.max_element() + 1e-6)
    }

    /// Samples the sine of θ_i and the azimuth.
    pub(super) fn sample(&self, hit: &Hit, o: [f32; 2], u: [f32; 4]) -> (f32, f32) {
        let w = self.within(o, hit.h);
        let (p, rest) = choose(&Self::shares(&self.attenuations(&w, hit.tint)), u[0]);
        let phi = match (p, &self.table) {
            (0..3, _) => {
                let width = self.parts.width[1] * (p as f32 + 1.0).sqrt();
                wrap(exit(p as f32, w.gamma_o, w.gamma_t) + width * normal([rest, u[1]]))
            }
            (3 | 4, Some(table)) if w.unscattered < 1.0 => {
                wrap(Self::inside(&w, p as f32 - 2.0) + table.sample_around(o[0], w.offset, [rest, u[1]]))
            }
            _ => TAU * u[1] - PI,
        };
        let sin = match (p, &self.table) {
            (0..3, _) => {
                let (o, v) = self.cone(p, o, phi);
                sample_longitudinal(o, v, [u[2], u[3]])
            }
            (_, Some(table)) => table.sample_along(o[0], [u[2], u[3]]),
            _ => 2.0 * u[2] - 1.0,
        };
        (sin, phi)
    }

    /// Density of [`Medulla::sample`], 1/sr.
    pub(super) fn pdf(&self, hit: &Hit, a: &Angles) -> f32 {
        let w = self.within(a.o, hit.h);
        let shares = Self::shares(&self.attenuations(&w, hit.tint));
        let (along, around) = (self.along(a), self.azimuthal(&w, a.o, a.phi));
        (0..LOBES).map(|p| shares[p] * along[p.min(3)] * around[p]).sum::<f32>() / shares.iter().sum::<f32>()
    }

    /// As [`super::Chiang::add_far`]; the fourth lobe is all light scattered in the medulla and all
    /// longer paths.
    pub(super) fn add_far(
        &self,
        o: [f32; 2],
        h: f32,
        weight: f32,
        radius: &[f32],
        phis: usize,
        sum: &mut [[f32; 4]],
    ) {
        let w = self.within(o, h);
        let attenuation: Vec<[f32; LOBES]> = radius
            .iter()
            .map(|t| Self::attenuation(&w, w.cortex.map(|length| t.powf(length))).map(|a| weight * a))
            .collect();
        for k in 0..phis {
            let n = self.azimuthal(&w, o, PI * k as f32 / (phis - 1) as f32);
            for (layer, a) in attenuation.iter().enumerate() {
                let to = &mut sum[layer * phis + k];
                (0..3).for_each(|p| to[p] += a[p] * n[p]);
                to[3] += a[3] * n[3] + a[4] * n[4] + a[5] * n[5];
            }
        }
    }
}
