//! Multiple scattering in fur: what reaches a hair after one or more other hairs.
//!
//! A coat is taken as plane-parallel: even, without end, on a skin. Its radiative transfer with the fibres' own scattering and
//! the directions in which they stand is solved once for a rendering, for a directional light from each inclination and hairs
//! of each brightness ([`slab`]). What remains is a [`Table`]: radiance that arrives around a hair at an optical depth towards
//! the light. Where it is looked up, the optical depth is that of the light lattice, which knows the true shape of the skin,
//! clumps and guard hairs; a coat that is not flat is so taken as flat around each point. In a bright coat hardly any light
//! that is seen was scattered once.
//!
//! DEVIATION: Zinke et al. 2008 (dual scattering) close the series over hairs by the shares that one hair scatters forward and
//! backward in azimuth. Upright hairs send light that comes from above on downwards whichever way it turns in azimuth, and
//! only roughness, tilt and disorder bring it out again: the inclination must be followed, and is followed here.

pub mod dual;
pub mod slab;
#[cfg(test)]
mod slab_test;
mod world;

use crate::fibre::{Fibre, Hit};
use crate::reference::hash::{hash2, random, random_direction};
use glam::Vec3;
use rayon::prelude::*;
use slab::{BINS, HALF, Medium};

/// Brightnesses of hair in a table.
pub const TINTS: usize = 10;
/// Optical depths towards the light.
pub const DEPTHS: usize = 20;
/// Inclinations of a light or a view to the skin's normal.
pub const COSINES: usize = 16;
/// Rows of `response_table` in `shaders/shared/transport.wgsl`.
pub const ROWS: usize = 6;
/// Largest optical depth in a table, and that of a light that is blocked.
pub const DEEPEST: f32 = 18.0;
/// Samples for each entry of [`Table::guard`].
const SAMPLES: u32 = 2048;

/// Scattered light in a coat, by the brightness of its hairs, the light's inclination and the optical depth towards it.
///
/// Radiance is a mean over four zones, by the cosine to the skin's normal of the direction that it comes from: high, low, from
/// slightly and from far below.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Share of the sphere of each zone.
    pub share: [f32; 4],
    /// Integral of the cosine over each zone by 2 pi.
    pub flux: [f32; 4],
    /// Weights of light scattered on and back by dual scattering: its density factors.
    pub dual_density: [f32; 2],
    /// Radiance in the zones for an irradiance of 1, for the skin's reflectance of each colour: `[tint][colour][depth][cosine of the light]`.
    pub field: Vec<[f32; 4]>,
    /// Radiance that undercoat sends to a view, by its extinction, for an irradiance of 1:
    /// `[tint][cosine of the view][colour][depth][cosine of the light]`. Hairs scatter into cones: the zones would not do.
    pub sent: Vec<f32>,
    /// What a guard hair sends to a view for a radiance of 1 all round, and for one that grows as the cosine to an axis: along
    /// the hair, and along the view's part across the hair: `[tint][sine of the view's inclination]`, the fourth is 0.
    pub guard: Vec<[f32; 4]>,
    /// [`dual::table`] of the undercoat's fibres and of the guard hairs'.
    pub dual: [Vec<[f32; 4]>; 2],
}

/// Which light scattered more than once is counted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terms {
    /// Weight of light that comes from above, or was scattered on towards the hair.
    pub forward: f32,
    /// Weight of light that comes from below, or was scattered back by the hairs behind.
    pub backward: f32,
    /// Density factors of dual scattering, on and back.
    pub density: [f32; 2],
}

/// Brightness of index `i` in a table; what comes out of a coat is about even in the root of what a hair takes.
pub fn tint(i: usize) -> f32 {
    let x = 1.0 - i as f32 / (TINTS - 1) as f32;
    1.0 - x * x
}

/// Optical depth of index `i` in a table.
pub fn depth(i: usize) -> f32 {
    let x = i as f32 / (DEPTHS - 1) as f32;
    DEEPEST * x * x
}

/// Cosine of index `i` in a table: of the light for 0..=1, of the view for -1..=1.
fn cosine(i: usize, lowest: f32) -> f32 {
    lowest + (1.0 - lowest) * i as f32 / (COSINES - 1) as f32
}

impl Table {
    /// Solves the transport in `medium` and tabulates it, with the response of guard hairs of model `guard`; terms are weighted.
    pub fn new(medium: &Medium, guard: &Fibre, terms: &Terms) -> Self {
        let zone = |bin: usize| match bin {
            _ if bin < HALF / 2 => 3,
            _ if bin < HALF => 2,
            _ if bin < HALF + HALF / 2 => 1,
            _ => 0,
        };
        let (edges, widths) = (slab::edges(), slab::widths());
        let (mut share, mut flux) = ([0.0; 4], [0.0; 4]);
        for bin in 0..BINS {
            share[zone(bin)] += 0.5 * widths[bin] as f32;
            flux[zone(bin)] += (0.5 * (edges[bin + 1].powi(2) - edges[bin].powi(2))) as f32;
        }
        let cosines: Vec<f64> = (0..COSINES).map(|i| f64::from(cosine(i, 0.0)).max(0.02)).collect();
        let solved: Vec<_> = (0..TINTS)
            .into_par_iter()
            .map(|i| {
                let operators = medium.operators(tint(i));
                (medium.skin.map(|skin| medium.solve(&operators, skin, &cosines)), operators)
            })
            .collect();
        let (mut field, mut sent) = (Vec::new(), Vec::new());
        for (by_skin, operators) in &solved {
            for (solution, d) in by_skin.iter().flat_map(|s| (0..DEPTHS).map(move |d| (s, d))) {
                for (k, mu) in cosines.iter().enumerate() {
                    let mut of_zone = [0.0; 4];
                    // What is blocked by the body itself is dark.
                    if d + 1 < DEPTHS {
                        let square = f64::from(depth(d)) * mu / operators.extinction_at(*mu);
                        for bin in 0..BINS {
                            let part = widths[bin] as f32 * 0.5 / share[zone(bin)];
                            let weight = if bin < HALF { terms.backward } else { terms.forward };
                            of_zone[zone(bin)] += weight * part * solution.radiance(square, k, bin) as f32;
                        }
                    }
                    field.push(of_zone);
                }
            }
            for i in 0..COSINES {
                let mu = f64::from(cosine(i, -1.0));
                let response: Vec<f64> = (0..BINS)
                    .map(|bin| {
                        let weight = if bin < HALF { terms.backward } else { terms.forward };
                        f64::from(weight) * operators.kernel_at(mu, bin) / operators.extinction_at(mu)
                    })
                    .collect();
                for (solution, d) in by_skin.iter().flat_map(|s| (0..DEPTHS).map(move |d| (s, d))) {
                    for (k, light) in cosines.iter().enumerate() {
                        let square = f64::from(depth(d)) * light / operators.extinction_at(*light);
                        let sum: f64 =
                            (0..BINS).map(|bin| response[bin] * solution.radiance(square, k, bin)).sum();
                        sent.push(if d + 1 < DEPTHS { sum as f32 } else { 0.0 });
                    }
                }
            }
        }
        Self {
            share,
            flux,
            dual_density: [terms.density[0] * terms.forward, terms.density[1] * terms.backward],
            field,
            sent,
            guard: guard_response(guard),
            dual: [dual::table(&medium.fibre), dual::table(guard)],
        }
    }
}

/// [`Table::guard`].
fn guard_response(fibre: &Fibre) -> Vec<[f32; 4]> {
    (0..TINTS * COSINES)
        .into_par_iter()
        .map(|i| {
            let sin = cosine(i % COSINES, -1.0).clamp(-0.999, 0.999);
            let cos = (1.0 - sin * sin).sqrt();
            let wo = Vec3::new(sin, cos, 0.0);
            let mut sum = Vec3::ZERO;
            for k in 0..SAMPLES {
                let seed = hash2(i as u32, k);
                let hit = Hit {
                    tint: Vec3::splat(tint(i / COSINES)),
                    glint_angle: (30.0 + 15.0 * random(seed, 5)).to_radians(),
                    h: 2.0 * random(seed, 4) - 1.0,
                };
                if let Some(s) = fibre.sample(&hit, wo, [0, 1, 2, 3].map(|k| random(seed, k))) {
                    sum += s.weight.x * Vec3::new(1.0, s.direction.x, s.direction.y);
                }
            }
            // As in the coat, no hair sends out more than comes in.
            (sum / (SAMPLES as f32).max(sum.x)).extend(0.0).to_array()
        })
        .collect()
}

/// Directions in which hairs stand around a normal, which is z: unit tangents that lean by `lean` (tangent of the angle) at the tip and
/// are turned by `jitter`, at all heights of a coat alike: light that comes out has been deep in it.
pub fn tangents(lean: f32, jitter: f32, exponent: f32, seed: u32) -> Vec<Vec3> {
    (0..512)
        .map(|i| {
            let h = hash2(seed, i);
            let t = random(h, 0);
            let turn = jitter * t.powf(exponent) * random_direction(h, 1);
            (Vec3::new(lean * t, 0.0, 1.0) + turn).normalize()
        })
        .collect()
}

impl Table {
    /// Texels of `field_table`: [`COSINES`] x 3 [`DEPTHS`] x [`TINTS`].
    pub fn field_texels(&self) -> &[[f32; 4]] {
        &self.field
    }

    /// Texels of `sent_table`: [`COSINES`] x 3 [`DEPTHS`] x ([`COSINES`] [`TINTS`]).
    pub fn sent_texels(&self) -> Vec<[f32; 4]> {
        self.sent.iter().map(|s| [*s, 0.0, 0.0, 0.0]).collect()
    }

    /// Texels of `response_table`: [`COSINES`] x [`ROWS`] x [`TINTS`].
    pub fn response_texels(&self) -> Vec<[f32; 4]> {
        let [on, back] = self.dual_density;
        let mut head = vec![[0.0; 4]; COSINES];
        head[..3].copy_from_slice(&[self.share, self.flux, [on, back, 0.0, 0.0]]);
        let mut texels = Vec::new();
        for tint in 0..TINTS {
            let row = |table: &[[f32; 4]]| table[tint * COSINES..][..COSINES].to_vec();
            texels.extend_from_slice(&head);
            texels.extend(row(&self.guard));
            for dual in &self.dual {
                for which in 0..2 {
                    texels.extend(dual[2 * tint * COSINES..][..2 * COSINES].iter().skip(which).step_by(2));
                }
            }
        }
        texels
    }
}
