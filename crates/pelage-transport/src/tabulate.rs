//! Solves the transport in a coat for every albedo, colour and light of a [`Table`].

use crate::bins::{BINS, HALF, edges, widths};
use crate::coat::{Medium, OperatorTable};
use crate::grid::{ALBEDOS, COSINES, DEPTHS, TILTS, albedo, cosine, depth};
use crate::{Table, Terms, dual, slab};
use glam::Vec3;
use pelage_fur::fibre::{Fibre, Hit};
use rayon::prelude::*;
use sobol_burley::sample;
use std::f32::consts::{FRAC_PI_2, PI};
use std::ops::Range;

/// Samples for each entry of [`Table::guard`], a power of two.
const SAMPLES: u32 = 2048;

/// Bins of light that comes from above, and from below.
const ABOVE: Range<usize> = HALF..BINS;
const BELOW: Range<usize> = 0..HALF;

/// Zone of a bin, as [`Table`] numbers them.
fn zone(bin: usize) -> usize {
    match bin {
        _ if bin < HALF / 2 => 3,
        _ if bin < HALF => 2,
        _ if bin < HALF + HALF / 2 => 1,
        _ => 0,
    }
}

/// [`Table::share`] and [`Table::flux`].
fn zone_integrals() -> [[f32; 4]; 2] {
    let (edges, widths) = (edges(), widths());
    let (mut share, mut flux) = ([0.0; 4], [0.0; 4]);
    for bin in 0..BINS {
        share[zone(bin)] += 0.5 * widths[bin] as f32;
        flux[zone(bin)] += (0.5 * (edges[bin + 1].powi(2) - edges[bin].powi(2))) as f32;
    }
    [share, flux]
}

impl Table {
    /// Solves the transport in `medium` and tabulates it, with the response of guard hairs of model
    /// `guard`. `terms` weights light from above and from below.
    pub fn new(medium: &Medium, guard: &Fibre, terms: &Terms) -> Self {
        let [share, flux] = zone_integrals();
        let operators = medium.operators();
        // `[albedo][colour]`
        let solved: Vec<Solved> = (0..3 * ALBEDOS)
            .into_par_iter()
            .map(|i| Solved::new(medium, &operators, terms, &share, (albedo(i / 3), i % 3)))
            .collect();
        let field = solved.iter().flat_map(|of_color| of_color.field.iter().copied()).collect();
        let mut sent = Vec::new();
        for by_color in solved.chunks(3) {
            for view in 0..COSINES {
                by_color.iter().for_each(|of_color| sent.extend_from_slice(&of_color.sent[view]));
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
}

/// Entries of a table for one albedo and one colour.
struct Solved {
    /// `[depth][cosine of the light]`
    field: Vec<[f32; 4]>,
    /// `[cosine of the view][depth][cosine of the light]`
    sent: Vec<Vec<[f32; 4]>>,
}

impl Solved {
    fn new(
        medium: &Medium,
        operators: &OperatorTable,
        terms: &Terms,
        share: &[f32; 4],
        (albedo, color): (f32, usize),
    ) -> Self {
        // Light along the skin would never get in.
        let lights: Vec<f64> = (0..COSINES).map(|i| f64::from(cosine(i, 0.0)).max(0.02)).collect();
        let weights: [f64; BINS] =
            std::array::from_fn(|bin| f64::from(if bin < HALF { terms.backward } else { terms.forward }));
        let widths = widths();
        let layers = medium.layers(operators, albedo, color);
        let solution = slab::solve(layers, medium.skin[color], &lights);
        let mut field = Vec::with_capacity(DEPTHS * COSINES);
        let mut sent = vec![Vec::new(); COSINES];
        for (d, k) in (0..DEPTHS).flat_map(|d| (0..COSINES).map(move |k| (d, k))) {
            if d + 1 == DEPTHS {
                // Where the body itself blocks the light, it is dark.
                field.push([0.0; 4]);
                sent.iter_mut().for_each(|row| row.push([0.0; 4]));
                continue;
            }
            let place = solution.depth(f64::from(depth(d)), k);
            let radiance: [f64; BINS] =
                std::array::from_fn(|bin| weights[bin] * solution.radiance(place, k, bin));
            let mut by_zone = [0.0; 4];
            for bin in 0..BINS {
                by_zone[zone(bin)] += widths[bin] as f32 * 0.5 / share[zone(bin)] * radiance[bin] as f32;
            }
            field.push(by_zone);
            let responses = medium.responses(operators, albedo, place, color);
            for (view, row) in sent.iter_mut().enumerate() {
                let mu = f64::from(cosine(view, -1.0));
                let [undercoat, guard] = [0, responses.len() - 1].map(|kind: usize| responses[kind].at(mu));
                let sum = |of: &dyn Fn(usize) -> f64, bins: Range<usize>| -> f64 { bins.map(of).sum() };
                let source = sum(&|bin| undercoat[bin] * radiance[bin], 0..BINS);
                let mean = |bins: Range<usize>| {
                    sum(&|bin| guard[bin] * radiance[bin], bins.clone())
                        / sum(&|bin| guard[bin], bins).max(1e-9)
                };
                row.push([source, mean(ABOVE), mean(BELOW), 0.0].map(|x| x as f32));
            }
        }
        Self { field, sent }
    }
}

/// [`Table::guard`].
fn guard_response(fibre: &Fibre) -> Vec<[f32; 4]> {
    // Normals of the skin in the hair's frame, whose x is the tangent; the view lies in the plane
    // of x and y.
    let normals: Vec<Vec3> = (0..TILTS * TILTS)
        .map(|i| {
            let part = |k: usize| k as f32 / (TILTS - 1) as f32;
            let (sin, cos) = (FRAC_PI_2 * part(i % TILTS)).sin_cos();
            let azimuth = PI * part(i / TILTS);
            Vec3::new(cos, sin * azimuth.cos(), sin * azimuth.sin())
        })
        .collect();
    // `[albedo][sine of the view's inclination][normal]`
    let by_view: Vec<Vec<[f32; 4]>> = (0..ALBEDOS * COSINES)
        .into_par_iter()
        .map(|i| {
            let sin = cosine(i % COSINES, -1.0).clamp(-0.999, 0.999);
            let wo = Vec3::new(sin, (1.0 - sin * sin).sqrt(), 0.0);
            let mut sums = vec![[0.0; 4]; normals.len()];
            for k in 0..SAMPLES {
                let random = |dimension| sample(k, dimension, i as u32);
                let hit = Hit {
                    tint: Vec3::splat(albedo(i / COSINES)),
                    glint_angle: pelage_fur::fibre::glint_angle(random(5)),
                    h: 2.0 * random(4) - 1.0,
                };
                if let Some(s) = fibre.sample(&hit, wo, [0, 1, 2, 3].map(random)) {
                    for (sum, normal) in sums.iter_mut().zip(&normals) {
                        // Azimuths go from 0 to pi only: a hair's scattering is the same on both
                        // sides of the view's plane.
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
    let by_normal = |views: &[Vec<[f32; 4]>]| -> Vec<[f32; 4]> {
        normals.clone().flat_map(|n| views.iter().map(move |of_view| of_view[n])).collect()
    };
    by_view.chunks(COSINES).flat_map(by_normal).collect()
}
