//! Multiple scattering in fur: what reaches a hair after one or more other hairs.
//!
//! A coat is taken as plane-parallel, without end, on a skin; hairs, their directions and colours change with the height ([`coat`]). Its
//! radiative transfer with the fibres' own scattering is solved once for a rendering, for a directional light from each inclination and
//! coats of each brightness ([`slab`]). What remains is a [`Table`]: radiance that arrives around a hair at an optical depth towards
//! the light. Where it is looked up, the optical depth is that of the light lattice, which knows the true shape of the skin,
//! clumps and guard hairs; a coat that is not flat is so taken as flat around each point. In a bright coat hardly any light
//! that is seen was scattered once.
//!
//! DEVIATION: Zinke et al. 2008 (dual scattering) close the series over hairs by the shares that one hair scatters forward and
//! backward in azimuth. Upright hairs send light that comes from above on downwards whichever way it turns in azimuth, and
//! only roughness, tilt and disorder bring it out again: the inclination must be followed, and is followed here.

pub mod coat;
pub mod dual;
pub mod lookup;
pub mod slab;
#[cfg(test)]
mod slab_test;
mod world;

use coat::Medium;
use glam::Vec3;
use pelage_fur::fibre::{Fibre, Hit};
use rayon::prelude::*;
use slab::{BINS, HALF};
use sobol_burley::sample;
use std::f32::consts::{FRAC_PI_2, PI};

/// Brightnesses of hair in a table.
pub const ALBEDOS: usize = 10;
/// Optical depths towards the light.
pub const DEPTHS: usize = 20;
/// Inclinations of a light or a view to the skin's normal.
pub const COSINES: usize = 16;
/// Inclinations of the skin's normal to a guard hair, and its azimuths.
pub const TILTS: usize = 8;
/// Rows of `response_table` in `shaders/shared/transport.wgsl`.
pub const ROWS: usize = 5 + TILTS * TILTS;
/// Largest optical depth in a table, and that of a light that is blocked.
pub const DEEPEST: f32 = 18.0;
/// Samples for each entry of [`Table::guard`], a power of two.
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
    /// For an irradiance of 1: radiance that undercoat sends to a view, by its extinction; radiance that falls on guard hairs from
    /// above and from below, as the mean of them that sends to the view weights it; 0:
    /// `[tint][cosine of the view][colour][depth][cosine of the light]`. Hairs scatter into cones: the zones would not do.
    pub sent: Vec<[f32; 4]>,
    /// What a guard hair sends to a view for a radiance of 1 from above the skin's horizon and from below, then two zeros:
    /// `[tint][azimuth of the normal][its angle to the hair][sine of the view's inclination]`, the azimuth from that of the view, 0 to
    /// pi, the angle 0 to pi/2.
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
    let x = 1.0 - i as f32 / (ALBEDOS - 1) as f32;
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
        let operators = medium.operators();
        let weights: [f64; BINS] =
            std::array::from_fn(|bin| f64::from(if bin < HALF { terms.backward } else { terms.forward }));
        // By tint and colour: the field, and what is sent by the cosine of the view.
        let solved: Vec<_> = (0..3 * ALBEDOS)
            .into_par_iter()
            .map(|i| {
                let (of_tint, color) = (tint(i / 3), i % 3);
                let layers = medium.layers(&operators, of_tint, color);
                let solution = slab::solve(layers, medium.skin[color], &cosines);
                let mut field = Vec::with_capacity(DEPTHS * COSINES);
                let mut sent = vec![Vec::new(); COSINES];
                for (d, k) in (0..DEPTHS).flat_map(|d| (0..COSINES).map(move |k| (d, k))) {
                    if d + 1 == DEPTHS {
                        // What is blocked by the body itself is dark.
                        field.push([0.0; 4]);
                        sent.iter_mut().for_each(|row| row.push([0.0; 4]));
                        continue;
                    }
                    let place = solution.depth(f64::from(depth(d)), k);
                    let radiance: [f64; BINS] =
                        std::array::from_fn(|bin| weights[bin] * solution.radiance(place, k, bin));
                    let mut of_zone = [0.0; 4];
                    for bin in 0..BINS {
                        of_zone[zone(bin)] +=
                            widths[bin] as f32 * 0.5 / share[zone(bin)] * radiance[bin] as f32;
                    }
                    field.push(of_zone);
                    let responses = medium.responses(&operators, of_tint, place, color);
                    for (view, row) in sent.iter_mut().enumerate() {
                        let mu = f64::from(cosine(view, -1.0));
                        let [first, last] =
                            [0, responses.len() - 1].map(|kind: usize| responses[kind].at(mu));
                        let sum = |of: &dyn Fn(usize) -> f64, bins: std::ops::Range<usize>| -> f64 {
                            bins.map(of).sum()
                        };
                        let coat = sum(&|bin| first[bin] * radiance[bin], 0..BINS);
                        let mean = |bins: std::ops::Range<usize>| {
                            sum(&|bin| last[bin] * radiance[bin], bins.clone())
                                / sum(&|bin| last[bin], bins).max(1e-9)
                        };
                        row.push([coat, mean(HALF..BINS), mean(0..HALF), 0.0].map(|x| x as f32));
                    }
                }
                (field, sent)
            })
            .collect();
        let field = solved.iter().flat_map(|(field, _)| field.iter().copied()).collect();
        let mut sent = Vec::new();
        for by_color in solved.chunks(3) {
            for view in 0..COSINES {
                by_color.iter().for_each(|(_, of)| sent.extend_from_slice(&of[view]));
            }
        }
        Self {
            share,
            flux,
            dual_density: [terms.density[0] * terms.forward, terms.density[1] * terms.backward],
            field,
            sent,
            guard: guard_response(guard),
            dual: [dual::table(&medium.kinds[0].fibre), dual::table(guard)],
        }
    }

    /// Texels of `field_table`: [`COSINES`] x 3 [`DEPTHS`] x [`ALBEDOS`].
    pub fn field_texels(&self) -> &[[f32; 4]] {
        &self.field
    }

    /// Texels of `sent_table`: [`COSINES`] x 3 [`DEPTHS`] x ([`COSINES`] [`ALBEDOS`]).
    pub fn sent_texels(&self) -> &[[f32; 4]] {
        &self.sent
    }

    /// Texels of `response_table`: [`COSINES`] x [`ROWS`] x [`ALBEDOS`].
    pub fn response_texels(&self) -> Vec<[f32; 4]> {
        let [on, back] = self.dual_density;
        let mut head = vec![[0.0; 4]; COSINES];
        head[..3].copy_from_slice(&[self.share, self.flux, [on, back, 0.0, 0.0]]);
        let mut texels = Vec::new();
        for tint in 0..ALBEDOS {
            texels.extend_from_slice(&head);
            texels
                .extend_from_slice(self.guard.chunks(TILTS * TILTS * COSINES).nth(tint).unwrap_or_default());
            for dual in &self.dual {
                for which in 0..2 {
                    texels.extend(dual[2 * tint * COSINES..][..2 * COSINES].iter().skip(which).step_by(2));
                }
            }
        }
        texels
    }
}

/// [`Table::guard`].
fn guard_response(fibre: &Fibre) -> Vec<[f32; 4]> {
    let normals: Vec<Vec3> = (0..TILTS * TILTS)
        .map(|i| {
            let part = |k: usize| k as f32 / (TILTS - 1) as f32;
            let (sin, cos) = (FRAC_PI_2 * part(i % TILTS)).sin_cos();
            let azimuth = PI * part(i / TILTS);
            Vec3::new(cos, sin * azimuth.cos(), sin * azimuth.sin())
        })
        .collect();
    let of_views: Vec<Vec<[f32; 4]>> = (0..ALBEDOS * COSINES)
        .into_par_iter()
        .map(|i| {
            let sin = cosine(i % COSINES, -1.0).clamp(-0.999, 0.999);
            let wo = Vec3::new(sin, (1.0 - sin * sin).sqrt(), 0.0);
            let mut sums = vec![[0.0; 4]; normals.len()];
            for k in 0..SAMPLES {
                let random = |dimension| sample(k, dimension, i as u32);
                let hit = Hit {
                    tint: Vec3::splat(tint(i / COSINES)),
                    glint_angle: (30.0 + 15.0 * random(5)).to_radians(),
                    h: 2.0 * random(4) - 1.0,
                };
                if let Some(s) = fibre.sample(&hit, wo, [0, 1, 2, 3].map(random)) {
                    for (sum, normal) in sums.iter_mut().zip(&normals) {
                        // Hairs are the same on both sides of the view's plane.
                        for n in [*normal, *normal * Vec3::new(1.0, 1.0, -1.0)] {
                            let below = usize::from(s.direction.dot(n) < 0.0);
                            sum[below] += 0.5 * s.weight.x / SAMPLES as f32;
                        }
                    }
                }
            }
            sums
        })
        .collect();
    let normals = 0..normals.len();
    let of_tint = |views: &[Vec<[f32; 4]>]| -> Vec<[f32; 4]> {
        normals.clone().flat_map(|n| views.iter().map(move |of_view| of_view[n])).collect()
    };
    of_views.chunks(COSINES).flat_map(of_tint).collect()
}
