//! Radiative transfer in a plane-parallel coat of fibres, by bins of the cosine to the normal and the adding method.
//!
//! Depth is the optical depth that hairs seen square would have: hairs per area times diameter times the way along the normal.
//! Along direction ω the extinction by it is the mean of sin(T, ω) / cos ψ over the tangents T, which lean by ψ.

use crate::fibre::{Fibre, Hit};
use crate::reference::hash::{hash2, random};
use faer::{Mat, linalg::solvers::Solve};
use glam::Vec3;

/// Bins of the cosine in a hemisphere. Fibres send light into cones: fewer bins spread it over inclinations by themselves.
pub const HALF: usize = 24;
/// Bins in the sphere, from straight down to straight up.
pub const BINS: usize = 2 * HALF;

/// Samples of the kernel for each bin.
const SAMPLES: u32 = 4096;

/// Part of the light that hairs may scatter on: what is more than the sampling's noise above 1 is cut.
const LARGEST_ALBEDO: f64 = 1.01;

/// An even coat on a skin.
#[derive(Debug, Clone)]
pub struct Medium {
    /// How its hairs scatter.
    pub fibre: Fibre,
    /// Their directions, unit, root to tip; z is the skin's normal.
    pub tangents: Vec<Vec3>,
    /// Depth of the whole coat.
    pub depth: f64,
    /// Reflectance of the skin, linear RGB.
    pub skin: [f64; 3],
    /// Seed of the sampling.
    pub seed: u32,
}

/// Extinction and scattering for hairs of one brightness.
pub struct Operators {
    extinction: [f64; BINS],
    /// Radiance sent into bin o for a radiance of 1 from bin i: `[o][i]`, by depth.
    kernel: [[f64; BINS]; BINS],
}

/// Scattered radiance in the coat.
pub struct Solution {
    /// Depths from the top.
    depths: Vec<f64>,
    /// `[depth][light][bin that it comes from]` for an irradiance of 1.
    radiance: Vec<Vec<[f64; BINS]>>,
}

/// Edges of the bins: half way between even in the cosine and even in the angle.
pub fn edges() -> [f64; BINS + 1] {
    std::array::from_fn(|k| {
        let x = (k as f64 - HALF as f64) / HALF as f64;
        0.5 * (x + (x * std::f64::consts::FRAC_PI_2).sin())
    })
}

/// Widths of the bins in the cosine.
pub fn widths() -> [f64; BINS] {
    let e = edges();
    std::array::from_fn(|k| e[k + 1] - e[k])
}

pub(super) fn centre(bin: usize) -> f64 {
    let e = edges();
    0.5 * (e[bin] + e[bin + 1])
}

/// The two bins around a cosine and the second one's weight.
fn around(mu: f64) -> (usize, usize, f64) {
    let after = (0..BINS).find(|k| centre(*k) > mu).unwrap_or(BINS);
    if after == 0 || after == BINS {
        let k = if after == 0 { 0 } else { BINS - 1 };
        return (k, k, 0.0);
    }
    let (a, b) = (centre(after - 1), centre(after));
    (after - 1, after, (mu - a) / (b - a))
}

impl Operators {
    /// Extinction by depth along a direction of cosine `mu`.
    pub fn extinction_at(&self, mu: f64) -> f64 {
        let (a, b, x) = around(mu);
        self.extinction[a] + (self.extinction[b] - self.extinction[a]) * x
    }

    /// Radiance sent towards cosine `mu` by depth for a radiance of 1 from `bin`.
    pub fn kernel_at(&self, mu: f64, bin: usize) -> f64 {
        let (a, b, x) = around(mu);
        self.kernel[a][bin] + (self.kernel[b][bin] - self.kernel[a][bin]) * x
    }

    /// Radiance sent into bin `o` by depth for an irradiance of 1 from cosine `mu`.
    fn beam(&self, o: usize, mu: f64) -> f64 {
        let (a, b, x) = around(mu);
        let w = widths();
        let of = |i: usize| self.kernel[o][i] / (std::f64::consts::TAU * w[i]);
        of(a) + (of(b) - of(a)) * x
    }
}

impl Solution {
    /// Radiance at `depth` from `bin` under light `light`.
    pub fn radiance(&self, depth: f64, light: usize, bin: usize) -> f64 {
        let after = self.depths.partition_point(|d| *d < depth).clamp(1, self.depths.len() - 1);
        let (a, b) = (self.depths[after - 1], self.depths[after]);
        let x = ((depth - a) / (b - a)).clamp(0.0, 1.0);
        let of = |k: usize| self.radiance[k][light][bin];
        of(after - 1) + (of(after) - of(after - 1)) * x
    }
}

impl Medium {
    /// Extinction and scattering for hairs of brightness `tint`: exit directions even in their bin, the light's drawn by the model.
    pub fn operators(&self, tint: f32) -> Operators {
        let (edges, widths) = (edges(), widths());
        let mut extinction = [0.0; BINS];
        let mut kernel = [[0.0; BINS]; BINS];
        for o in 0..BINS {
            for k in 0..SAMPLES {
                let seed = hash2(hash2(self.seed, o as u32), k);
                let mu = edges[o] + widths[o] * (f64::from(k) + 0.5) / f64::from(SAMPLES);
                let pick = (random(seed, 0) * self.tangents.len() as f32) as usize;
                let turn = glam::Quat::from_rotation_z(std::f32::consts::TAU * random(seed, 1));
                let tangent = turn * self.tangents[pick.min(self.tangents.len() - 1)];
                let w = Vec3::new((1.0 - mu * mu).sqrt() as f32, 0.0, mu as f32);
                let (y, z) = tangent.any_orthonormal_pair();
                let local = |v: Vec3| Vec3::new(tangent.dot(v), y.dot(v), z.dot(v));
                let wo = local(w);
                let shown = f64::from((1.0 - wo.x * wo.x).max(0.0).sqrt() / tangent.z.max(0.2));
                extinction[o] += shown / f64::from(SAMPLES);
                let hit = Hit { tint: Vec3::splat(tint), glint_angle: 0.65, h: 2.0 * random(seed, 2) - 1.0 };
                let u = [3, 4, 5, 6].map(|k| random(seed, k));
                if let Some(s) = self.fibre.sample(&hit, wo, u) {
                    let up = f64::from(s.direction.dot(local(Vec3::Z)));
                    let bin = edges.partition_point(|e| *e <= up).clamp(1, BINS) - 1;
                    kernel[o][bin] += shown * f64::from(s.weight.x) / f64::from(SAMPLES);
                }
            }
        }
        // Artists' lobes may send out more than comes in, and light that is scattered again and again would grow without end.
        for (row, extinction) in kernel.iter_mut().zip(extinction) {
            let albedo = row.iter().sum::<f64>() / extinction;
            if albedo > LARGEST_ALBEDO {
                row.iter_mut().for_each(|k| *k /= albedo);
            }
        }
        Operators { extinction, kernel }
    }

    /// Boundaries of the layers: thin at the top, where the light changes.
    fn layers(&self) -> Vec<f64> {
        let mut depths = vec![0.0];
        let mut step = 0.08;
        while let Some(last) = depths.last().copied().filter(|d| *d < self.depth) {
            depths.push((last + step).min(self.depth));
            step = (step * 1.15f64).min(1.5);
        }
        depths
    }

    /// Scattered radiance under directional lights of the given cosines to the normal, all above the horizon.
    ///
    /// Layers have a source that is even in them; they are added from the skin upwards, and the radiances found from the top
    /// downwards, so that no order of scattering is cut off.
    pub fn solve(&self, op: &Operators, skin: f64, lights: &[f64]) -> Solution {
        let depths = self.layers();
        let (n, cells) = (HALF, depths.len() - 1);
        // Streams: 0..n go up, n..2n go down, each from flat to steep. A stream that goes up comes from below.
        let leaving = |k: usize| if k < n { n + k } else { BINS - 1 - k };
        let arriving = |k: usize| if k < n { n - 1 - k } else { k };
        let mu: Vec<f64> = (0..BINS).map(|k| centre(leaving(k)).abs()).collect();
        let flux: Vec<f64> =
            (0..n).map(|k| std::f64::consts::TAU * widths()[n + k] * centre(n + k)).collect();
        let sigma: Vec<f64> = (0..BINS).map(|k| op.extinction[leaving(k)].max(1e-6)).collect();
        let kernel = Mat::from_fn(BINS, BINS, |o, i| op.kernel[leaving(o)][arriving(i)]);
        let beams = Mat::from_fn(BINS, lights.len(), |o, l| op.beam(leaving(o), lights[l]));
        let slant: Vec<f64> = lights.iter().map(|m| op.extinction_at(*m) / m).collect();

        struct Layer {
            down: Mat<f64>,
            back: Mat<f64>,
            source: Mat<f64>,
            factor: Mat<f64>,
            reflects: Mat<f64>,
            emits: Mat<f64>,
        }
        let mut reflects = Mat::from_fn(n, n, |_, i| skin / std::f64::consts::PI * flux[i]);
        let mut emits = Mat::from_fn(n, lights.len(), |_, l| {
            skin / std::f64::consts::PI * lights[l] * (-slant[l] * self.depth).exp()
        });
        let mut stack = Vec::new();
        for k in (0..cells).rev() {
            let (top, thick) = (depths[k], depths[k + 1] - depths[k]);
            let x: Vec<f64> = (0..BINS).map(|s| sigma[s] * thick / mu[s]).collect();
            let mean: Vec<f64> = x.iter().map(|x| -(-x).exp_m1() / x).collect();
            let source = Mat::from_fn(BINS, lights.len(), |o, l| {
                let y = slant[l] * thick;
                beams[(o, l)] * (-slant[l] * top).exp() * -(-y).exp_m1() / y
            });
            // Mean radiance in the layer: (1 - G K) I = G s + H in.
            let g = |o: usize| (1.0 - mean[o]) / sigma[o];
            let unit = |o, i| if o == i { 1.0 } else { 0.0 };
            let system = Mat::from_fn(BINS, BINS, |o, i| unit(o, i) - g(o) * kernel[(o, i)]);
            let right = Mat::from_fn(BINS, BINS + lights.len(), |o, i| match i.checked_sub(BINS) {
                None => unit(o, i) * mean[o],
                Some(l) => g(o) * source[(o, l)],
            });
            let scattered = &kernel * system.partial_piv_lu().solve(&right);
            let q = |o: usize| x[o] * mean[o] / sigma[o];
            let out = Mat::from_fn(BINS, BINS, |o, i| unit(o, i) * (-x[o]).exp() + q(o) * scattered[(o, i)]);
            let sent =
                Mat::from_fn(BINS, lights.len(), |o, l| q(o) * (source[(o, l)] + scattered[(o, BINS + l)]));
            let block = |m: &Mat<f64>, o: usize, i: usize, columns: usize| {
                Mat::from_fn(n, columns, |a, b| m[(o + a, i + b)])
            };
            let (up, turned) = (block(&out, 0, 0, n), block(&out, 0, n, n));
            let (back, down) = (block(&out, n, 0, n), block(&out, n, n, n));
            let (sent_up, sent_down) = (block(&sent, 0, 0, lights.len()), block(&sent, n, 0, lights.len()));
            // Between the layer and what lies below: u = P d + q, d = down d' + back u + s.
            let loop_matrix = Mat::from_fn(n, n, unit) - &reflects * &back;
            let factor = loop_matrix.partial_piv_lu().solve(Mat::from_fn(n, n, unit));
            let below = &factor * (&reflects * &sent_down + &emits);
            let next_emits = sent_up + &up * below;
            let next_reflects = turned + &up * (&factor * (&reflects * &down));
            stack.push(Layer {
                down,
                back,
                source: sent_down,
                factor,
                reflects: std::mem::replace(&mut reflects, next_reflects),
                emits: std::mem::replace(&mut emits, next_emits),
            });
        }
        let collect = |up: &Mat<f64>, down: &Mat<f64>| {
            (0..lights.len())
                .map(|l| {
                    let mut bins = [0.0; BINS];
                    for k in 0..n {
                        bins[arriving(k)] = up[(k, l)];
                        bins[arriving(n + k)] = down[(k, l)];
                    }
                    bins
                })
                .collect::<Vec<_>>()
        };
        let mut down = Mat::zeros(n, lights.len());
        let mut radiance = vec![collect(&emits, &down)];
        for layer in stack.iter().rev() {
            let through = &layer.down * &down + &layer.source;
            let up = &layer.factor * (&layer.reflects * &through + &layer.emits);
            down = through + &layer.back * &up;
            radiance.push(collect(&up, &down));
        }
        Solution { depths, radiance }
    }
}
