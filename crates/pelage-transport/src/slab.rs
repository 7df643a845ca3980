//! Radiative transfer in a plane-parallel coat by the adding method.
//!
//! **Model.** A coat is a stack of layers, each of one mixture of hairs, on a Lambertian skin. It
//! is lit by directional lights of irradiance 1. The beams of the lights are followed apart,
//! attenuated only; I is the radiance that was scattered at least once, by hairs or by the skin. It
//! depends on the depth z, which grows downwards, and on the inclination; azimuth is averaged out.
//! With the cosine μ > 0 between the direction and the normal's line, the extinction σ and the
//! scattering kernel K of the hairs, and the emission s of light scattered from the beams,
//!
//! ```text
//!  μ dI/dz = -σ I + K I + s   for light that goes down,
//! -μ dI/dz = -σ I + K I + s   for light that goes up.
//! ```
//!
//! **Streams.** Directions are the 48 [bins](crate::bins). The solver orders them as *streams*:
//! 0..24 go up, 24..48 go down, each half from grazing to steep. Emitted light is binned by where
//! it goes to, arriving light by where it comes from. So a stream has two bins, `leaving_bin` and
//! `arriving_bin`.
//!
//! **One layer.** The emission K I + s is taken as constant within a layer (in neutron transport:
//! step characteristics). The mean radiance along a stream of optical thickness x is then
//!
//! ```text
//! I = H in + G (K I + s),    H = (1 - exp(-x)) / x,    G = (1 - H) / σ,    H and G diagonal,
//! ```
//!
//! where `in` is the radiance that enters. So (1 - G K) I = H in + G s. This system is solved for
//! each layer, because (1 - G K)⁻¹ = 1 + G K + (G K)² + ... is the sum over all orders of
//! scattering within the layer. What leaves the layer is the radiance that met no hair, and the
//! emission along the stream. As a map from entering to leaving streams, that is a block of
//! transmission T and one of reflection R for light that leaves upwards (T↑, R↑) and downwards (T↓,
//! R↓), with source vectors s↑ and s↓.
//!
//! **Adding, from the skin upwards.** All that lies below a boundary is known by its reflection P
//! and its emission q: for the radiance d that falls on it, it sends u = P d + q upwards. At first,
//! that is the skin. A layer is put on top, on which the radiance d' falls:
//!
//! ```text
//! d = T↓ d' + R↓ u + s↓   and   u = P d + q,   so   u = (1 - P R↓)⁻¹ (P (T↓ d' + s↓) + q)
//! ```
//!
//! at the boundary between the two. The inverse is the sum over all reflections to and fro. What
//! lies below the layer's upper boundary sends R↑ d' + T↑ u + s↑ upwards, so its reflection and
//! emission are
//!
//! ```text
//! P' = R↑ + T↑ (1 - P R↓)⁻¹ P T↓,    q' = s↑ + T↑ (1 - P R↓)⁻¹ (P s↓ + q).
//! ```
//!
//! **Back substitution, from the top downwards.** No scattered light falls on the coat from
//! outside, so d = 0 at the top. The equations above, whose inverses are kept, then give u and d at
//! each boundary in turn. No order of scattering is cut off.
//!
//! **Convergence.** G K and P R↓ have no negative entries. For such a matrix A the Neumann series
//! `1 + A + A² + ...` converges if and only if 1 - A is a nonsingular M-matrix, that is, if its
//! inverse exists and has no negative entry. If a model scatters more light than it receives, light
//! in a deep coat may grow without bound. The linear system then still has a solution, but not one
//! that is the sum of a series: the inverse has negative entries. This is how such coats are
//! recognised.
// [GrantHunt1969] adding and back substitution; [BermanPlemmons1994] ch. 6, nonsingular M-matrices

use crate::bins::{BINS, HALF, centre, interpolate, neighbours, widths};
use crate::operators::Operators;
use faer::{Mat, linalg::solvers::Solve};
use std::f64::consts::{PI, TAU};

/// A layer of a coat: the [`Operators`] of the mixture of its hairs, the same throughout.
pub struct Layer {
    /// Its extent in depth, as [`crate::coat`] counts it.
    pub thickness: f64,
    operators: Operators,
}

/// Scattered radiance in the coat.
pub struct Solution {
    /// Depths of the layers' boundaries, from the top.
    depths: Vec<f64>,
    /// Optical depths towards the lights there as the optical-depth lattice counts them:
    /// `[boundary][light]`.
    lattice_depths: Vec<Vec<f64>>,
    /// Radiance for an irradiance of 1: `[boundary][light][bin that it arrives from]`.
    radiance: Vec<Vec<[f64; BINS]>>,
}

impl Layer {
    /// A layer without hairs.
    pub fn empty(thickness: f64) -> Self {
        Self { thickness, operators: Operators::none() }
    }

    /// Adds hairs that make up the share `weight` of the layer's thickness.
    pub fn add(&mut self, hairs: &Operators, weight: f64) {
        self.operators.add(hairs, weight);
    }

    /// Extinction for a depth of 1 along a direction of cosine `mu`.
    #[cfg(test)]
    pub fn extinction_at(&self, mu: f64) -> f64 {
        interpolate(&self.operators.extinction, mu)
    }

    /// Radiance sent towards the cosine `mu` by a depth of 1 for a radiance of 1 from `bin`.
    #[cfg(test)]
    pub fn kernel_at(&self, mu: f64, bin: usize) -> f64 {
        let (a, b, x) = neighbours(mu);
        let of = |o: usize| self.operators.kernel[o][bin];
        of(a) + (of(b) - of(a)) * x
    }
}

/// Where `x` lies between two of `count` increasing `values`: the index of the first and the weight
/// of the second.
fn between(values: impl Fn(usize) -> f64, count: usize, x: f64) -> (usize, f64) {
    let after = (1..count - 1).find(|k| values(*k) >= x).unwrap_or(count - 1);
    let (a, b) = (values(after - 1), values(after));
    (after - 1, ((x - a) / (b - a).max(1e-12)).clamp(0.0, 1.0))
}

impl Solution {
    /// Radiance at `depth` that arrives from `bin`, for light number `light`.
    pub fn radiance(&self, depth: f64, light: usize, bin: usize) -> f64 {
        let (k, x) = between(|k| self.depths[k], self.depths.len(), depth);
        let of = |k: usize| self.radiance[k][light][bin];
        of(k) + (of(k + 1) - of(k)) * x
    }

    /// Depth at which the optical-depth lattice counts the optical depth `tau` towards a light.
    pub fn depth(&self, tau: f64, light: usize) -> f64 {
        let (k, x) = between(|k| self.lattice_depths[k][light], self.depths.len(), tau);
        self.depths[k] + (self.depths[k + 1] - self.depths[k]) * x
    }

    /// No scattered light.
    fn dark(lights: usize) -> Self {
        Self {
            depths: vec![0.0, 1.0],
            lattice_depths: vec![vec![0.0; lights]; 2],
            radiance: vec![vec![[0.0; BINS]; lights]; 2],
        }
    }
}

/// Scattered radiance in `layers`, from the top down, on a Lambertian skin of reflectance `skin`,
/// for directional lights of irradiance 1 whose cosines to the normal are given, all above the
/// horizon.
///
/// Artists' lobes may send out more light than they receive. If light then grows without bound, the
/// coat is solved again with all directional albedos limited to 1; should rounding spoil that too,
/// the result is dark.
pub fn solve(mut layers: Vec<Layer>, skin: f64, lights: &[f64]) -> Solution {
    solve_unlimited(&layers, skin, lights)
        .or_else(|| {
            layers.iter_mut().for_each(|layer| layer.operators.limit_albedo());
            solve_unlimited(&layers, skin, lights)
        })
        .unwrap_or_else(|| Solution::dark(lights.len()))
}

/// Bin that a stream's light leaves into.
fn leaving_bin(stream: usize) -> usize {
    if stream < HALF { HALF + stream } else { BINS - 1 - stream }
}

/// Bin that a stream's light arrives from: light that goes up comes from below.
fn arriving_bin(stream: usize) -> usize {
    if stream < HALF { HALF - 1 - stream } else { stream }
}

/// What lies below a boundary: it sends `reflection` d + `emission` upwards for the radiance d that
/// falls on it.
struct Below {
    /// `[stream up][stream down]`
    reflection: Mat<f64>,
    /// `[stream up][light]`
    emission: Mat<f64>,
}

/// What a layer does with radiance at its boundaries: `[stream that leaves][stream that enters]`,
/// and for sources `[stream that leaves][light]`.
struct Response {
    transmission_up: Mat<f64>,
    transmission_down: Mat<f64>,
    /// Light from above, sent back upwards.
    reflection_up: Mat<f64>,
    /// Light from below, sent back downwards.
    reflection_down: Mat<f64>,
    source_up: Mat<f64>,
    source_down: Mat<f64>,
}

/// What back substitution needs of a layer.
struct Eliminated {
    transmission_down: Mat<f64>,
    reflection_down: Mat<f64>,
    source_down: Mat<f64>,
    /// Sum over all reflections between the layer and what lies below it: (1 - P R↓)⁻¹.
    bounces: Mat<f64>,
    /// What lies below it.
    below: Below,
}

/// Lights above a stack of layers.
struct Beams<'a> {
    /// Cosines to the normal.
    cosines: &'a [f64],
    /// Optical depths along the beams: `[boundary][light]`.
    depths: Vec<Vec<f64>>,
}

/// [`solve`] with the albedos as they are; `None` where light grows without bound.
fn solve_unlimited(layers: &[Layer], skin: f64, lights: &[f64]) -> Option<Solution> {
    let beams = Beams { cosines: lights, depths: beam_depths(layers, lights, |op| &op.extinction) };
    let mut below = on_skin(skin, &beams);
    // From the skin upwards, each layer is added to what lies below it.
    let mut stack = Vec::new();
    for (k, layer) in layers.iter().enumerate().rev() {
        let response = layer_response(layer, &beams, k)?;
        let (eliminated, above) = put_on(response, below)?;
        stack.push(eliminated);
        below = above;
    }
    // From the top downwards, the radiance at each boundary follows from that above.
    let mut down = Mat::zeros(HALF, lights.len());
    let mut radiance = vec![by_bin(&below.emission, &down)];
    for layer in stack.iter().rev() {
        let (up, next) = layer.radiance_below(&down);
        radiance.push(by_bin(&up, &next));
        down = next;
    }
    let mut depths = vec![0.0];
    layers.iter().for_each(|layer| depths.push(depths[depths.len() - 1] + layer.thickness));
    let lattice_depths = beam_depths(layers, lights, |op| &op.lattice_extinction);
    Some(Solution { depths, lattice_depths, radiance })
}

/// Optical depths of the layers' boundaries along the lights' beams: `[boundary][light]`.
fn beam_depths(
    layers: &[Layer],
    lights: &[f64],
    extinction: fn(&Operators) -> &[f64; BINS],
) -> Vec<Vec<f64>> {
    let mut sums = vec![vec![0.0; lights.len()]];
    for layer in layers {
        let tau = |mu: f64| interpolate(extinction(&layer.operators), mu) / mu * layer.thickness;
        let last = &sums[sums.len() - 1];
        sums.push(last.iter().zip(lights).map(|(sum, mu)| sum + tau(*mu)).collect());
    }
    sums
}

/// The Lambertian skin below all layers, lit by what is left of the beams.
fn on_skin(skin: f64, beams: &Beams) -> Below {
    let flux: Vec<f64> = (0..HALF).map(|k| TAU * widths()[HALF + k] * centre(HALF + k)).collect();
    let slants = &beams.depths[beams.depths.len() - 1];
    Below {
        reflection: Mat::from_fn(HALF, HALF, |_, i| skin / PI * flux[i]),
        emission: Mat::from_fn(HALF, beams.cosines.len(), |_, l| {
            skin / PI * beams.cosines[l] * (-slants[l]).exp()
        }),
    }
}

/// Emission by scattering from the beams in layer `k`, a mean over the layer: `[stream][light]`.
fn beam_emission(layer: &Layer, beams: &Beams, k: usize) -> Mat<f64> {
    let kernel = &layer.operators.kernel;
    let widths = widths();
    let around: Vec<_> = beams.cosines.iter().map(|mu| neighbours(*mu)).collect();
    Mat::from_fn(BINS, beams.cosines.len(), |o, l| {
        let slant = beams.depths[k + 1][l] - beams.depths[k][l];
        let (a, b, x) = around[l];
        // The kernel is for radiance from a whole bin; for an irradiance from one direction it is
        // divided by the bin's solid angle.
        let of = |i: usize| kernel[leaving_bin(o)][i] / (TAU * widths[i]);
        let beam = of(a) + (of(b) - of(a)) * x;
        beam * (-beams.depths[k][l]).exp() * -(-slant).exp_m1() / slant.max(1e-12)
    })
}

/// Transmission, reflection and sources of layer `k`; `None` where scattering within it does not
/// converge.
fn layer_response(layer: &Layer, beams: &Beams, k: usize) -> Option<Response> {
    let op = &layer.operators;
    let lights = beams.cosines.len();
    let sigma: Vec<f64> = (0..BINS).map(|s| op.extinction[leaving_bin(s)].max(1e-6)).collect();
    let kernel = Mat::from_fn(BINS, BINS, |o, i| op.kernel[leaving_bin(o)][arriving_bin(i)]);
    // Optical thickness along each stream.
    let x: Vec<f64> = (0..BINS).map(|s| sigma[s] * layer.thickness / centre(leaving_bin(s)).abs()).collect();
    // H: mean over the layer of the transmittance from where a stream enters.
    let h: Vec<f64> = x.iter().map(|x| -(-x).exp_m1() / x).collect();
    let source = beam_emission(layer, beams, k);

    // Mean radiance in the layer, of unit radiance that enters each stream and of each light: (1 -
    // G K) I = [H | G s].
    let g = |o: usize| (1.0 - h[o]) / sigma[o];
    let system = Mat::from_fn(BINS, BINS, |o, i| unit(o, i) - g(o) * kernel[(o, i)]);
    let right = Mat::from_fn(BINS, BINS + lights, |o, i| match i.checked_sub(BINS) {
        None => unit(o, i) * h[o],
        Some(l) => g(o) * source[(o, l)],
    });
    let mean_radiance = system.partial_piv_lu().solve(&right);
    // H is diagonal and positive and G s is not negative: they leave the signs of the inverse.
    if !no_negative_entry(&mean_radiance) {
        return None;
    }

    // What leaves: radiance that met no hair, and emission K I + s along the stream, (1 - exp(-x))
    // / σ of it.
    let scattered = &kernel * &mean_radiance;
    let along = |o: usize| x[o] * h[o] / sigma[o];
    let out = Mat::from_fn(BINS, BINS, |o, i| unit(o, i) * (-x[o]).exp() + along(o) * scattered[(o, i)]);
    let sent = Mat::from_fn(BINS, lights, |o, l| along(o) * (source[(o, l)] + scattered[(o, BINS + l)]));

    let block = |m: &Mat<f64>, row: usize, column: usize, columns: usize| {
        Mat::from_fn(HALF, columns, |o, i| m[(row + o, column + i)])
    };
    let (up, down) = (0, HALF);
    Some(Response {
        transmission_up: block(&out, up, up, HALF),
        transmission_down: block(&out, down, down, HALF),
        reflection_up: block(&out, up, down, HALF),
        reflection_down: block(&out, down, up, HALF),
        source_up: block(&sent, up, 0, lights),
        source_down: block(&sent, down, 0, lights),
    })
}

/// Puts a layer on what lies `below`: what back substitution needs, and what then lies below the
/// layer's upper boundary. `None` where light grows without bound between the two.
fn put_on(layer: Response, below: Below) -> Option<(Eliminated, Below)> {
    let Response {
        transmission_up,
        transmission_down,
        reflection_up,
        reflection_down,
        source_up,
        source_down,
    } = layer;
    let identity = || Mat::from_fn(HALF, HALF, unit);
    let system = identity() - &below.reflection * &reflection_down;
    let bounces = system.partial_piv_lu().solve(identity());
    if !no_negative_entry(&bounces) {
        return None;
    }
    let emitted = &bounces * (&below.reflection * &source_down + &below.emission);
    let above = Below {
        emission: source_up + &transmission_up * emitted,
        reflection: reflection_up + &transmission_up * (&bounces * (&below.reflection * &transmission_down)),
    };
    Some((Eliminated { transmission_down, reflection_down, source_down, bounces, below }, above))
}

impl Eliminated {
    /// Radiance up and down at the layer's lower boundary, for radiance `down` at its upper one:
    /// `[stream][light]`.
    fn radiance_below(&self, down: &Mat<f64>) -> (Mat<f64>, Mat<f64>) {
        let through = &self.transmission_down * down + &self.source_down;
        let up = &self.bounces * (&self.below.reflection * &through + &self.below.emission);
        let down = through + &self.reflection_down * &up;
        (up, down)
    }
}

fn unit(o: usize, i: usize) -> f64 {
    if o == i { 1.0 } else { 0.0 }
}

/// Whether a matrix that solves a system 1 - A has no negative entry but for rounding: only then
/// does the series over A converge.
fn no_negative_entry(inverse: &Mat<f64>) -> bool {
    let entries = (0..inverse.ncols()).flat_map(|i| (0..inverse.nrows()).map(move |o| inverse[(o, i)]));
    entries.fold(f64::INFINITY, f64::min) > -1e-9
}

/// Radiance at a boundary by light and by the bin that it arrives from, from that by stream and
/// light.
fn by_bin(up: &Mat<f64>, down: &Mat<f64>) -> Vec<[f64; BINS]> {
    (0..up.ncols())
        .map(|l| {
            let mut bins = [0.0; BINS];
            for k in 0..HALF {
                bins[arriving_bin(k)] = up[(k, l)];
                bins[arriving_bin(HALF + k)] = down[(k, l)];
            }
            bins
        })
        .collect()
}
