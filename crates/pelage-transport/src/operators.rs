//! How hairs of one height and one albedo attenuate and scatter light, averaged over their
//! directions.

use crate::bins::{BINS, edges, widths};
use crate::coat::{HeightLevel, Orientation};
use glam::Vec3;
use pelage_fur::fibre::table::MEAN_GLINT;
use pelage_fur::fibre::{Fibre, Hit};
use pelage_fur::random::hash2;
use sobol_burley::sample;

/// Samples for each bin of exit directions: a power of two, as suits a scrambled Sobol sequence.
// [Burley2020]
const SAMPLES: u32 = 1024;

/// Extinction and scattering of hairs, for a depth of 1 as [`crate::coat`] counts it.
pub struct Operators {
    /// Extinction along each bin's directions: the mean of [`Orientation::projected`] times the
    /// sine of the angle between hair and ray.
    pub extinction: [f64; BINS],
    /// Scattering, `[bin that light leaves into][bin that it arrives from]`: radiance sent for a
    /// radiance of 1 from the whole bin of arrival. A row's sum over its extinction is the hairs'
    /// directional albedo.
    pub kernel: Vec<[f64; BINS]>,
    /// Extinction along each bin's directions as the optical-depth lattice counts it, which knows
    /// less about the hairs.
    pub lattice_extinction: [f64; BINS],
}

impl Operators {
    /// Samples hairs of `level` at all azimuths. Paths are followed backwards: the exit direction
    /// is uniform in its bin, the direction of arrival is drawn by `fibre`.
    pub fn new(fibre: &Fibre, level: &HeightLevel, albedo: f32, seed: u32) -> Self {
        let hairs = &level.hairs;
        let (edges, widths) = (edges(), widths());
        let mut extinction = [0.0; BINS];
        let mut kernel = vec![[0.0; BINS]; BINS];
        for o in 0..BINS {
            // A sequence of its own for each bin, so that their errors do not add up.
            let sequence = hash2(seed, o as u32);
            for k in 0..SAMPLES {
                let random = |dimension| sample(k, dimension, sequence);
                let mu = edges[o] + widths[o] * f64::from(random(0));
                let pick = (random(1) * hairs.len() as f32) as usize;
                let turn = glam::Quat::from_rotation_z(std::f32::consts::TAU * random(2));
                let Orientation { tangent, projected } = hairs[pick.min(hairs.len() - 1)];
                let tangent = turn * tangent;
                let w = Vec3::new((1.0 - mu * mu).sqrt() as f32, 0.0, mu as f32);
                let (y, z) = tangent.any_orthonormal_pair();
                let local = |v: Vec3| Vec3::new(tangent.dot(v), y.dot(v), z.dot(v));
                let wo = local(w);
                let projected =
                    f64::from((1.0 - wo.x * wo.x).max(0.0).sqrt() * projected) / f64::from(SAMPLES);
                extinction[o] += projected;
                let hit =
                    Hit { tint: Vec3::splat(albedo), glint_angle: MEAN_GLINT, h: 2.0 * random(3) - 1.0 };
                if let Some(s) = fibre.sample(&hit, wo, [4, 5, 6, 7].map(random)) {
                    let up = f64::from(s.direction.dot(local(Vec3::Z)));
                    let bin = edges.partition_point(|e| *e <= up).clamp(1, BINS) - 1;
                    kernel[o][bin] += projected * f64::from(s.weight.x);
                }
            }
        }
        Self { extinction, kernel, lattice_extinction: level.lattice_extinction.unwrap_or(extinction) }
    }

    /// No hairs.
    pub(crate) fn none() -> Self {
        let none = [0.0; BINS];
        Self { extinction: none, kernel: vec![none; BINS], lattice_extinction: none }
    }

    /// Adds `weight` times the operators of other hairs.
    pub(crate) fn add(&mut self, hairs: &Operators, weight: f64) {
        for o in 0..BINS {
            self.extinction[o] += weight * hairs.extinction[o];
            self.lattice_extinction[o] += weight * hairs.lattice_extinction[o];
            for i in 0..BINS {
                self.kernel[o][i] += weight * hairs.kernel[o][i];
            }
        }
    }

    /// Scales scattering down wherever more light would leave than arrives: no directional albedo
    /// stays above 1.
    pub(crate) fn limit_albedo(&mut self) {
        for (row, extinction) in self.kernel.iter_mut().zip(&self.extinction) {
            let albedo = row.iter().sum::<f64>() / extinction.max(1e-12);
            row.iter_mut().for_each(|k| *k /= albedo.max(1.0));
        }
    }
}
