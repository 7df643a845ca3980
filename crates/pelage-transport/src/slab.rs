//! Radiative transfer in a plane-parallel coat of fibres, by bins of the cosine to the normal and the adding method.
//!
//! Depth is that of [`super::coat`]. Along direction ω the extinction by it is the mean of sin(T, ω) over the tangents T, and of what
//! each shows.

use super::coat::{HeightLevel, Orientation};
use faer::{Mat, linalg::solvers::Solve};
use glam::Vec3;
use pelage_fur::fibre::table::MEAN_GLINT;
use pelage_fur::fibre::{Fibre, Hit};
use pelage_fur::random::hash2;
use sobol_burley::sample;
use std::sync::LazyLock;

/// Bins of the cosine in a hemisphere. Fibres send light into cones: fewer bins spread it over inclinations by themselves.
pub const HALF: usize = 24;
/// Bins in the sphere, from straight down to straight up.
pub const BINS: usize = 2 * HALF;

/// Samples of the kernel for each bin, a power of two: of a scrambled Sobol sequence.
const SAMPLES: u32 = 1024;

/// Extinction and scattering for hairs of one brightness, by their depth.
pub struct Operators {
    /// For each bin.
    pub extinction: [f64; BINS],
    /// Radiance sent into bin o for a radiance of 1 from bin i: `[o][i]`.
    pub kernel: Vec<[f64; BINS]>,
    /// Extinction as the light lattice counts it.
    pub counted: [f64; BINS],
}

/// An even layer of a coat: what [`Operators`] are, for the mixture of its hairs.
pub struct Layer {
    /// Its depth.
    pub thick: f64,
    operators: Operators,
}

/// Scattered radiance in the coat.
pub struct Solution {
    /// Depths of the layers' boundaries from the top.
    depths: Vec<f64>,
    /// Optical depths towards the lights there, as the light lattice counts them: `[boundary][light]`.
    counted: Vec<Vec<f64>>,
    /// `[depth][light][bin that it comes from]` for an irradiance of 1.
    radiance: Vec<Vec<[f64; BINS]>>,
}

/// Edges of the bins: half way between even in the cosine and even in the angle.
pub fn edges() -> [f64; BINS + 1] {
    static EDGES: LazyLock<[f64; BINS + 1]> = LazyLock::new(|| {
        std::array::from_fn(|k| {
            let x = (k as f64 - HALF as f64) / HALF as f64;
            0.5 * (x + (x * std::f64::consts::FRAC_PI_2).sin())
        })
    });
    *EDGES
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
pub(super) fn around(mu: f64) -> (usize, usize, f64) {
    let e = edges();
    let centre = |k: usize| 0.5 * (e[k] + e[k + 1]);
    let after = (0..BINS).find(|k| centre(*k) > mu).unwrap_or(BINS);
    if after == 0 || after == BINS {
        let k = if after == 0 { 0 } else { BINS - 1 };
        return (k, k, 0.0);
    }
    let (a, b) = (centre(after - 1), centre(after));
    (after - 1, after, (mu - a) / (b - a))
}

/// Two low-discrepancy numbers.
pub(super) fn even_samples(i: u32) -> [f32; 2] {
    [0, 1].map(|dimension| sample(i, dimension, 0))
}

/// Extinction by depth along a direction of cosine `mu`.
pub(super) fn extinction_at(extinction: &[f64; BINS], mu: f64) -> f64 {
    let (a, b, x) = around(mu);
    extinction[a] + (extinction[b] - extinction[a]) * x
}

impl Operators {
    /// Of hairs with these directions: exit directions even in their bin, the light's drawn by the model.
    pub fn new(fibre: &Fibre, level: &HeightLevel, tint: f32, seed: u32) -> Self {
        let hairs = &level.hairs;
        let (edges, widths) = (edges(), widths());
        let mut extinction = [0.0; BINS];
        let mut kernel = vec![[0.0; BINS]; BINS];
        for o in 0..BINS {
            // Other errors in each bin, so that they do not add up.
            let of_bin = hash2(seed, o as u32);
            for k in 0..SAMPLES {
                let random = |dimension| sample(k, dimension, of_bin);
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
                let hit = Hit { tint: Vec3::splat(tint), glint_angle: MEAN_GLINT, h: 2.0 * random(3) - 1.0 };
                if let Some(s) = fibre.sample(&hit, wo, [4, 5, 6, 7].map(random)) {
                    let up = f64::from(s.direction.dot(local(Vec3::Z)));
                    let bin = edges.partition_point(|e| *e <= up).clamp(1, BINS) - 1;
                    kernel[o][bin] += projected * f64::from(s.weight.x);
                }
            }
        }
        Self { extinction, kernel, counted: level.counted.unwrap_or(extinction) }
    }
}

impl Layer {
    /// Without hairs.
    pub fn empty(thick: f64) -> Self {
        let none = [0.0; BINS];
        Self { thick, operators: Operators { extinction: none, kernel: vec![none; BINS], counted: none } }
    }

    /// Adds hairs, `weight` of the layer's depth.
    pub fn add(&mut self, hairs: &Operators, weight: f64) {
        for o in 0..BINS {
            self.operators.extinction[o] += weight * hairs.extinction[o];
            self.operators.counted[o] += weight * hairs.counted[o];
            for i in 0..BINS {
                self.operators.kernel[o][i] += weight * hairs.kernel[o][i];
            }
        }
    }

    /// No more out than in.
    fn cap(&mut self) {
        let Operators { extinction, kernel, .. } = &mut self.operators;
        for (row, extinction) in kernel.iter_mut().zip(extinction) {
            let albedo = row.iter().sum::<f64>() / extinction.max(1e-12);
            row.iter_mut().for_each(|k| *k /= albedo.max(1.0));
        }
    }

    /// Extinction by depth along a direction of cosine `mu`.
    #[cfg(test)]
    pub fn extinction_at(&self, mu: f64) -> f64 {
        extinction_at(&self.operators.extinction, mu)
    }

    /// Radiance sent towards cosine `mu` by depth for a radiance of 1 from `bin`.
    #[cfg(test)]
    pub fn kernel_at(&self, mu: f64, bin: usize) -> f64 {
        let (a, b, x) = around(mu);
        let of = |o: usize| self.operators.kernel[o][bin];
        of(a) + (of(b) - of(a)) * x
    }
}

/// Place of `x` between two of `values`, which grow: the first's index and the second's weight.
fn between(values: impl Fn(usize) -> f64, count: usize, x: f64) -> (usize, f64) {
    let after = (1..count - 1).find(|k| values(*k) >= x).unwrap_or(count - 1);
    let (a, b) = (values(after - 1), values(after));
    (after - 1, ((x - a) / (b - a).max(1e-12)).clamp(0.0, 1.0))
}

impl Solution {
    /// Radiance at `depth` from `bin` under light `light`.
    pub fn radiance(&self, depth: f64, light: usize, bin: usize) -> f64 {
        let (k, x) = between(|k| self.depths[k], self.depths.len(), depth);
        let of = |k: usize| self.radiance[k][light][bin];
        of(k) + (of(k + 1) - of(k)) * x
    }

    /// Depth at which the light lattice finds the optical depth `tau` towards a light.
    pub fn depth(&self, tau: f64, light: usize) -> f64 {
        let (k, x) = between(|k| self.counted[k][light], self.depths.len(), tau);
        self.depths[k] + (self.depths[k + 1] - self.depths[k]) * x
    }
}

/// Scattered radiance in layers, from the top down, on a skin, under directional lights of the given cosines to the normal, all above the
/// horizon.
///
/// Layers have a source that is even in them; they are added from the skin upwards, and the radiances found from the top
/// downwards, so that no order of scattering is cut off. Artists' lobes may send out more than comes in, and light
/// that is scattered again and again in a deep coat of them would grow without end: then no hair sends out more than it takes.
pub fn solve(mut layers: Vec<Layer>, skin: f64, lights: &[f64]) -> Solution {
    if let Some(solution) = add(&layers, skin, lights) {
        return solution;
    }
    layers.iter_mut().for_each(Layer::cap);
    add(&layers, skin, lights).unwrap_or_else(|| Solution {
        depths: vec![0.0, 1.0],
        counted: vec![vec![0.0; lights.len()]; 2],
        radiance: vec![vec![[0.0; BINS]; lights.len()]; 2],
    })
}

/// Whether a series 1 + A + A^2 + ... of a matrix A without negative entries has this sum: it has one if and only if the inverse of
/// 1 - A has no negative entry.
fn converges(inverse: &Mat<f64>) -> bool {
    let least = (0..inverse.ncols()).flat_map(|i| (0..inverse.nrows()).map(move |o| inverse[(o, i)]));
    least.fold(f64::INFINITY, f64::min) > -1e-9
}

/// [`solve`]; `None` where light would grow without end.
fn add(layers: &[Layer], skin: f64, lights: &[f64]) -> Option<Solution> {
    let n = HALF;
    // Streams: 0..n go up, n..2n go down, each from flat to steep. A stream that goes up comes from below.
    let leaving = |k: usize| if k < n { n + k } else { BINS - 1 - k };
    let arriving = |k: usize| if k < n { n - 1 - k } else { k };
    let mu: Vec<f64> = (0..BINS).map(|k| centre(leaving(k)).abs()).collect();
    let flux: Vec<f64> = (0..n).map(|k| std::f64::consts::TAU * widths()[n + k] * centre(n + k)).collect();
    let mut depths = vec![0.0];
    layers.iter().for_each(|layer| depths.push(depths[depths.len() - 1] + layer.thick));
    let added = |of: fn(&Operators) -> &[f64; BINS]| {
        let mut sums = vec![vec![0.0; lights.len()]];
        for layer in layers {
            let tau = |mu: f64| extinction_at(of(&layer.operators), mu) / mu * layer.thick;
            let last = &sums[sums.len() - 1];
            sums.push(last.iter().zip(lights).map(|(sum, mu)| sum + tau(*mu)).collect());
        }
        sums
    };
    let slants = added(|op| &op.extinction);
    let counted = added(|op| &op.counted);

    struct Added {
        down: Mat<f64>,
        back: Mat<f64>,
        source: Mat<f64>,
        factor: Mat<f64>,
        reflects: Mat<f64>,
        emits: Mat<f64>,
    }
    let mut reflects = Mat::from_fn(n, n, |_, i| skin / std::f64::consts::PI * flux[i]);
    let mut emits = Mat::from_fn(n, lights.len(), |_, l| {
        skin / std::f64::consts::PI * lights[l] * (-slants[layers.len()][l]).exp()
    });
    let lit: Vec<_> = lights.iter().map(|mu| (around(*mu), widths())).collect();
    let mut stack = Vec::new();
    for (k, layer) in layers.iter().enumerate().rev() {
        let thick = layer.thick;
        let op = &layer.operators;
        let sigma: Vec<f64> = (0..BINS).map(|k| op.extinction[leaving(k)].max(1e-6)).collect();
        let kernel = Mat::from_fn(BINS, BINS, |o, i| op.kernel[leaving(o)][arriving(i)]);
        let x: Vec<f64> = (0..BINS).map(|s| sigma[s] * thick / mu[s]).collect();
        let mean: Vec<f64> = x.iter().map(|x| -(-x).exp_m1() / x).collect();
        // Radiance sent by the beams, a mean over the layer.
        let source = Mat::from_fn(BINS, lights.len(), |o, l| {
            let y = slants[k + 1][l] - slants[k][l];
            let ((a, b, x), w) = &lit[l];
            let of = |i: usize| op.kernel[leaving(o)][i] / (std::f64::consts::TAU * w[i]);
            let beam = of(*a) + (of(*b) - of(*a)) * x;
            beam * (-slants[k][l]).exp() * -(-y).exp_m1() / y.max(1e-12)
        });
        // Mean radiance in the layer: (1 - G K) I = G s + H in.
        let g = |o: usize| (1.0 - mean[o]) / sigma[o];
        let unit = |o, i| if o == i { 1.0 } else { 0.0 };
        let system = Mat::from_fn(BINS, BINS, |o, i| unit(o, i) - g(o) * kernel[(o, i)]);
        let right = Mat::from_fn(BINS, BINS + lights.len(), |o, i| match i.checked_sub(BINS) {
            None => unit(o, i) * mean[o],
            Some(l) => g(o) * source[(o, l)],
        });
        let mean_radiance = system.partial_piv_lu().solve(&right);
        let scattered = &kernel * &mean_radiance;
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
        if !converges(&mean_radiance) || !converges(&factor) {
            return None;
        }
        let below = &factor * (&reflects * &sent_down + &emits);
        let next_emits = sent_up + &up * below;
        let next_reflects = turned + &up * (&factor * (&reflects * &down));
        stack.push(Added {
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
    Some(Solution { depths, counted, radiance })
}
