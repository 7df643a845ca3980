//! Far fields as tables, for shaders and quadrature: azimuthal functions of four lobes, integrated
//! over the offset. The longitudinal functions are closed forms, or one more layer of the table.

use super::{Absorption, Angles, Fibre, inclination, offsets};
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::{FRAC_PI_2, PI};
use std::sync::{Arc, Mutex};

/// Far-field azimuthal functions of R, TT, TRT and the rest.
#[derive(Debug, Clone, PartialEq)]
pub struct FarTable {
    /// Number of azimuths, evenly spaced from 0 to π.
    pub phis: usize,
    /// Number of inclinations θ_o, evenly spaced from 0 to π/2.
    pub thetas: usize,
    /// Number of layers, evenly spaced in the transmittance of one diameter from 0 to 1. Fibres
    /// with a medulla have one more: the longitudinal density of scattered light, with the sine of
    /// θ_i (−1 to 1) in place of the azimuth.
    pub layers: usize,
    /// Values of the four lobes, `[layer][inclination][azimuth]`.
    pub values: Vec<[f32; 4]>,
}

/// Number of offsets over which the near field is averaged.
const OFFSETS: u32 = 256;

impl FarTable {
    /// [`FarTable::new`] with a process-wide cache: frames of an animation have the same hairs.
    pub fn shared(fibre: &Fibre) -> Option<Arc<Self>> {
        static CACHE: Mutex<Vec<(Fibre, Arc<FarTable>)>> = Mutex::new(Vec::new());
        const CAPACITY: usize = 8;
        if !fibre.is_near_field() {
            return None;
        }
        let cache = || CACHE.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some((_, table)) = cache().iter().find(|(of, _)| of == fibre) {
            return Some(table.clone());
        }
        let table = Arc::new(Self::new(fibre)?);
        let mut cache = cache();
        if cache.len() >= CAPACITY {
            cache.remove(0);
        }
        cache.push((fibre.clone(), table.clone()));
        Some(table)
    }

    /// The table of a model that depends on the offset; `None` for the others.
    pub fn new(fibre: &Fibre) -> Option<Self> {
        let width = match fibre {
            Fibre::Chiang(model) => 1.8 * model.scale,
            Fibre::Medulla(model) => model.parts.width[1],
            _ => return None,
        };
        // At most two MiB as halves.
        let [phis, thetas, layers] = if width < 0.12 { [256, 78, 12] } else { [128, 64, 16] };
        let radius: Vec<f32> = (0..layers).map(|k| (k as f32 / (layers - 1) as f32).sqrt()).collect();
        let rows: Vec<Vec<[f32; 4]>> = (0..thetas)
            .into_par_iter()
            .map(|row| {
                let theta = row as f32 / (thetas - 1) as f32 * FRAC_PI_2;
                let o = [theta.sin(), theta.cos().max(0.0)];
                let mut sum = vec![[0.0; 4]; layers * phis];
                for (h, weight) in offsets(OFFSETS) {
                    match fibre {
                        Fibre::Chiang(model) => model.add_far(o, h, weight, &radius, phis, &mut sum),
                        Fibre::Medulla(model) => model.add_far(o, h, weight, &radius, phis, &mut sum),
                        _ => {}
                    }
                }
                sum
            })
            .collect();
        let mut values = Vec::with_capacity((layers + 1) * thetas * phis);
        for layer in 0..layers {
            rows.iter().for_each(|row| values.extend_from_slice(&row[layer * phis..][..phis]));
        }
        let mut table = Self { phis, thetas, layers, values };
        if let Fibre::Medulla(model) = fibre {
            for row in 0..thetas {
                let sin_o = (row as f32 / (thetas - 1) as f32 * FRAC_PI_2).sin();
                table.values.extend((0..phis).map(|k| {
                    let sin_i = 2.0 * k as f32 / (phis - 1) as f32 - 1.0;
                    [model.scattered_along(sin_o, sin_i), 0.0, 0.0, 0.0]
                }));
            }
            table.layers += 1;
        }
        Some(table)
    }

    /// Number of layers that vary the transmittance.
    pub fn absorptions(&self, fibre: &Fibre) -> usize {
        self.layers - usize::from(matches!(fibre, Fibre::Medulla(_)))
    }

    /// The four functions for transmittance `through` of one diameter; `k` is the index of the
    /// azimuth, `theta` is θ_o.
    fn at(&self, absorptions: usize, through: f32, theta: f32, k: usize) -> [f32; 4] {
        let split = |x: f32, n: usize| {
            let x = x.clamp(0.0, 1.0) * (n - 1) as f32;
            let low = (x as usize).min(n - 2);
            (low, x - low as f32)
        };
        let (l, lw) = split(through, absorptions);
        let (t, tw) = split(theta.abs() / FRAC_PI_2, self.thetas);
        let value = |l: usize, t: usize, p: usize| self.values[(l * self.thetas + t) * self.phis + k][p];
        std::array::from_fn(|p| {
            (1.0 - lw) * ((1.0 - tw) * value(l, t, p) + tw * value(l, t + 1, p))
                + lw * ((1.0 - tw) * value(l + 1, t, p) + tw * value(l + 1, t + 1, p))
        })
    }
}

impl FarTable {
    /// f cos θ_i of the far field from the table, as the shaders evaluate it; 0 for models without
    /// a table.
    pub fn scatter(&self, fibre: &Fibre, a: &Angles, tint: Vec3) -> Vec3 {
        let (absorption, along) = match fibre {
            Fibre::Chiang(m) => (m.absorption, m.along(a)),
            Fibre::Medulla(m) => (m.parts.absorption, m.along(a)),
            _ => return Vec3::ZERO,
        };
        let theta = a.o[0].clamp(-1.0, 1.0).asin();
        let x = (a.phi.abs() / PI).clamp(0.0, 1.0) * (self.phis - 1) as f32;
        let k = (x as usize).min(self.phis - 2);
        let absorptions = self.absorptions(fibre);
        let value = |through: f32| -> f32 {
            let [low, high] = [k, k + 1].map(|k| self.at(absorptions, through, theta, k));
            (0..4).map(|p| (low[p] + (high[p] - low[p]) * (x - k as f32)) * along[p]).sum()
        };
        Vec3::from((-2.0 * absorption.of(tint)).to_array().map(|x| value(x.exp())))
    }
}

/// Light that a hair scatters into one half of all directions.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Hemisphere {
    /// Directional albedo into this half.
    pub albedo: Vec3,
    /// Mean of θ_i + θ_o, radians; 0 on the mirror cone.
    pub shift: f32,
    /// Standard deviation of θ_i + θ_o, radians.
    pub width: f32,
}

/// Scattered light by halves; forward means |φ| > π/2.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Hemispheres {
    /// Forward-scattered light.
    pub forward: Hemisphere,
    /// Backward-scattered light.
    pub backward: Hemisphere,
}

/// Moments of θ_i + θ_o over one half, of order 0, 1 and 2.
#[derive(Default, Clone, Copy)]
struct Moments([Vec3; 3]);

impl Moments {
    fn add(&mut self, value: Vec3, x: f32) {
        self.0[0] += value;
        self.0[1] += value * x;
        self.0[2] += value * x * x;
    }

    fn finish(self) -> Hemisphere {
        let [whole, first, second] = self.0.map(Vec3::element_sum);
        let mean = first / whole.max(1e-12);
        let width = (second / whole.max(1e-12) - mean * mean).max(0.0).sqrt();
        Hemisphere { albedo: self.0[0], shift: mean, width }
    }
}

/// Steps of the quadrature over θ_i and half of the azimuths.
const STEPS: [usize; 2] = [256, 128];

/// Evaluates directional albedos and lobes of a far field by halves; built once for a fibre,
/// evaluated for many inclinations and colours.
pub struct Albedos<'a> {
    fibre: &'a Fibre,
    table: Option<Arc<FarTable>>,
}

impl<'a> Albedos<'a> {
    /// For a fibre, with its table if it has one.
    pub fn new(fibre: &'a Fibre) -> Self {
        Self { fibre, table: FarTable::shared(fibre) }
    }

    /// Integrals of f cos θ_i over ω_i for an inclination `theta` of ω_o (radians). They sum to 1
    /// for lossless models. For reciprocal models the two directions may be exchanged.
    pub fn hemispherical(&self, theta: f32, tint: Vec3) -> Hemispheres {
        let (absorption, table) = match (self.fibre, &self.table) {
            (Fibre::Chiang(m), Some(table)) => (&m.absorption, table),
            (Fibre::Medulla(m), Some(table)) => (&m.parts.absorption, table),
            _ => return self.direct(theta, tint),
        };
        self.by_table(theta, absorption, tint, table)
    }

    fn by_table(&self, theta: f32, absorption: &Absorption, tint: Vec3, table: &FarTable) -> Hemispheres {
        let o = [theta.sin(), theta.cos().max(0.0)];
        let through = (-2.0 * absorption.of(tint)).to_array().map(f32::exp);
        let absorptions = table.absorptions(self.fibre);
        let along = |i: [f32; 2], phi: f32| {
            let a = Angles { i, o, phi };
            match self.fibre {
                Fibre::Chiang(m) => m.along(&a),
                Fibre::Medulla(m) => m.along(&a),
                _ => [0.0; 4],
            }
        };
        // Longitudinal moments of the lobes. Only R of a fibre with a medulla depends on the
        // azimuth.
        let moments = |phi: f32| {
            let mut sums = [[0f32; 3]; 4];
            let step = PI / STEPS[0] as f32;
            for k in 0..STEPS[0] {
                let theta_i = (k as f32 + 0.5) * step - FRAC_PI_2;
                let m = along([theta_i.sin(), theta_i.cos()], phi);
                let x = theta_i + theta;
                for p in 0..4 {
                    let w = m[p] * theta_i.cos() * step;
                    (0..3).for_each(|n| sums[p][n] += w * x.powi(n as i32));
                }
            }
            // Normalised, because narrow lobes may fall between the steps.
            sums.map(|s| s.map(|x| x / s[0].max(1e-9)))
        };
        let fixed = moments(0.0);
        let turns = matches!(self.fibre, Fibre::Medulla(_));
        let mut halves = [Moments::default(); 2];
        for k in 0..table.phis {
            let phi = PI * k as f32 / (table.phis - 1) as f32;
            let ends = k == 0 || k == table.phis - 1;
            let weight = 2.0 * PI / (table.phis - 1) as f32 * if ends { 0.5 } else { 1.0 };
            let mut of_phi = fixed;
            if turns {
                of_phi[0] = moments(phi)[0];
            }
            let [r, g, b] = through.map(|through| table.at(absorptions, through, theta, k));
            let half = &mut halves[usize::from(phi <= FRAC_PI_2)].0;
            for p in 0..4 {
                let value = Vec3::new(r[p], g[p], b[p]) * weight;
                (0..3).for_each(|n| half[n] += value * of_phi[p][n]);
            }
        }
        Hemispheres { forward: halves[0].finish(), backward: halves[1].finish() }
    }

    fn direct(&self, theta: f32, tint: Vec3) -> Hemispheres {
        let hit = super::Hit { tint, glint_angle: MEAN_GLINT, h: 0.0 };
        let mut halves = [Moments::default(); 2];
        let (dt, dp) = (PI / STEPS[0] as f32, PI / STEPS[1] as f32);
        for j in 0..STEPS[0] {
            let theta_i = (j as f32 + 0.5) * dt - FRAC_PI_2;
            for k in 0..STEPS[1] {
                let phi = (k as f32 + 0.5) * dp;
                let a = Angles { i: inclination(theta_i.sin()), o: inclination(theta.sin()), phi };
                let value = self.fibre.scatter(&hit, &a) * (theta_i.cos() * dt * 2.0 * dp);
                halves[usize::from(phi <= FRAC_PI_2)].add(value, theta_i + theta);
            }
        }
        Hemispheres { forward: halves[0].finish(), backward: halves[1].finish() }
    }
}

/// Mean azimuth of glints, radians.
pub const MEAN_GLINT: f32 = 0.654_498_5;
