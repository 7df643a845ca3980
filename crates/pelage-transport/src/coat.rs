//! A flat coat of one or two kinds of hairs, whose density, colour and directions change with the height.
//!
//! Depth is the optical depth that hairs seen square would have, of all kinds together, from the top of the longest hairs.

use super::slab::{BINS, Layer, Operators, around, centre, even_samples, extinction_at};
use super::{ALBEDOS, tint};
use glam::Vec3;
use pelage_fur::fibre::Fibre;
use rayon::prelude::*;

/// Hairs of one model.
#[derive(Debug, Clone)]
pub struct Hairs {
    /// How they scatter.
    pub fibre: Fibre,
    /// Their directions at levels in order of depth.
    pub levels: Vec<HeightLevel>,
}

/// Hairs of one height.
#[derive(Debug, Clone)]
pub struct HeightLevel {
    /// Equal shares of them.
    pub hairs: Vec<Orientation>,
    /// What the light lattice takes for their extinction by depth, in each bin, where that is not theirs.
    pub counted: Option<[f64; BINS]>,
}

/// The direction of a piece of hair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orientation {
    /// Unit, root to tip; z is the skin's normal.
    pub tangent: Vec3,
    /// What it shows square to itself by depth: more than 1 where depth counts the way along the normal and the hair leans.
    pub projected: f32,
}

/// Hairs of one kind in a slice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// Their depth.
    pub depth: f64,
    /// Place between the levels, in levels.
    pub place: f64,
    /// Their colour is the coat's mean colour to this power.
    pub power: [f32; 3],
}

/// A coat on a skin.
#[derive(Debug, Clone)]
pub struct Medium {
    /// The undercoat comes first, guard hairs last.
    pub kinds: Vec<Hairs>,
    /// From the top down, a part for each kind.
    pub slices: Vec<Vec<Part>>,
    /// Reflectance of the skin, linear RGB.
    pub skin: [f64; 3],
    /// Seed of the sampling.
    pub seed: u32,
}

/// Operators of all hairs of a medium by kind, level and brightness.
pub struct OperatorTable {
    operators: Vec<Vec<Vec<Operators>>>,
}

impl Medium {
    /// An even coat of one kind of hairs.
    pub fn even(fibre: Fibre, orientations: Vec<Orientation>, depth: f64, skin: [f64; 3], seed: u32) -> Self {
        let kinds = vec![Hairs { fibre, levels: vec![HeightLevel { hairs: orientations, counted: None }] }];
        let slices = vec![vec![Part { depth, place: 0.0, power: [1.0; 3] }]];
        Self { kinds, slices, skin, seed }
    }

    /// Depth of the whole coat.
    pub fn depth(&self) -> f64 {
        self.slices.iter().flatten().map(|part| part.depth).sum()
    }

    /// Samples the operators.
    pub fn operators(&self) -> OperatorTable {
        let operators = self
            .kinds
            .iter()
            .map(|hairs| {
                hairs
                    .levels
                    .par_iter()
                    .map(|level| {
                        (0..ALBEDOS)
                            .into_par_iter()
                            .map(|i| Operators::new(&hairs.fibre, level, tint(i), self.seed))
                            .collect()
                    })
                    .collect()
            })
            .collect();
        OperatorTable { operators }
    }

    /// Composition at a depth: where that lies in the slices; the weights of the kinds there, with the mean of their parts.
    fn parts_at(&self, from: f64, to: f64) -> Vec<Part> {
        let mut sums = vec![Part { depth: 0.0, place: 0.0, power: [0.0; 3] }; self.kinds.len()];
        let mut top = 0.0;
        let last = self.slices.len() - 1;
        for (k, slice) in self.slices.iter().enumerate() {
            let whole: f64 = slice.iter().map(|p| p.depth).sum();
            // Whatever lies below by rounding belongs to the last.
            let bottom = if k == last { f64::INFINITY } else { top + whole };
            let common = to.min(bottom) - from.max(top);
            top = bottom;
            if common <= 0.0 || whole <= 0.0 {
                continue;
            }
            for (sum, part) in sums.iter_mut().zip(slice) {
                let depth = part.depth * common / whole;
                sum.depth += depth;
                sum.place += depth * part.place;
                (0..3).for_each(|c| sum.power[c] += depth as f32 * part.power[c]);
            }
        }
        for (kind, sum) in sums.iter_mut().enumerate() {
            if sum.depth > 0.0 {
                sum.place /= sum.depth;
                sum.power = sum.power.map(|p| p / sum.depth as f32);
            } else if let Some(nearest) = self.nearest(kind, 0.5 * (from + to)) {
                *sum = Part { depth: 0.0, ..nearest };
            }
        }
        sums
    }

    /// The part of a kind that lies nearest to a depth, where it has none.
    fn nearest(&self, kind: usize, depth: f64) -> Option<Part> {
        let mut top = 0.0;
        let mut best: Option<(f64, Part)> = None;
        for slice in &self.slices {
            let whole: f64 = slice.iter().map(|p| p.depth).sum();
            let distance = (top + 0.5 * whole - depth).abs();
            if slice[kind].depth > 0.0 && best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, slice[kind]));
            }
            top += whole;
        }
        best.map(|(_, part)| part)
    }

    /// Thicknesses of the layers: thin at the top, where the light changes.
    pub(super) fn thicknesses(&self) -> Vec<f64> {
        let (mut rest, mut step) = (self.depth(), 0.08f64);
        let mut all = Vec::new();
        while rest > 0.0 {
            all.push(if rest < 1.25 * step { rest } else { step });
            rest -= all[all.len() - 1];
            step = (step * 1.15).min(1.5);
        }
        all
    }

    /// Layers for hairs of mean brightness `tint` in colour `color`.
    pub fn layers(&self, operators: &OperatorTable, tint: f32, color: usize) -> Vec<Layer> {
        let mut top = 0.0;
        let of_layer = |thick: f64| {
            let mut layer = Layer::empty(thick);
            let parts = self.parts_at(top, top + thick);
            top += thick;
            for (kind, part) in parts.iter().enumerate().filter(|(_, part)| part.depth > 0.0) {
                for (operators, weight) in operators.around(kind, part.place, tint.powf(part.power[color])) {
                    layer.add(operators, part.depth / thick * weight);
                }
            }
            layer
        };
        self.thicknesses().into_iter().map(of_layer).collect()
    }

    /// What each kind of hairs does at `depth`, where the coat has mean brightness `tint` in colour `color`.
    pub fn responses<'a>(
        &self,
        operators: &'a OperatorTable,
        tint: f32,
        depth: f64,
        color: usize,
    ) -> Vec<Responses<'a>> {
        let of_kind = |(kind, part): (usize, Part)| {
            Responses(operators.around(kind, part.place, tint.powf(part.power[color])).collect())
        };
        self.parts_at(depth - 1e-6, depth + 1e-6).into_iter().enumerate().map(of_kind).collect()
    }
}

/// Operators with their weights.
pub struct Responses<'a>(Vec<(&'a Operators, f64)>);

impl Responses<'_> {
    /// Radiance sent towards cosine `mu` by the hairs' extinction for a radiance of 1 from each bin.
    pub fn at(&self, mu: f64) -> [f64; BINS] {
        let (a, b, x) = around(mu);
        let mut response = [0.0; BINS];
        for (op, weight) in &self.0 {
            let scale = weight / extinction_at(&op.extinction, mu);
            for (bin, sum) in response.iter_mut().enumerate() {
                *sum += scale * (op.kernel[a][bin] + (op.kernel[b][bin] - op.kernel[a][bin]) * x);
            }
        }
        response
    }
}

impl OperatorTable {
    /// Operators of a kind around a place and a brightness, with their weights.
    fn around(&self, kind: usize, place: f64, tint: f32) -> impl Iterator<Item = (&Operators, f64)> {
        let levels = &self.operators[kind];
        let place = place.clamp(0.0, (levels.len() - 1) as f64);
        let low = (place as usize).min(levels.len().saturating_sub(2));
        let x = place - low as f64;
        let at = f64::from((1.0 - (1.0 - tint).max(0.0).sqrt()).clamp(0.0, 1.0)) * (ALBEDOS - 1) as f64;
        let t = (at as usize).min(ALBEDOS - 2);
        let y = at - t as f64;
        [(0, 0), (0, 1), (1, 0), (1, 1)].into_iter().filter_map(move |(s, c)| {
            let weight = [1.0 - x, x][s] * [1.0 - y, y][c];
            (weight > 0.0).then(|| (&levels[low + s][t + c], weight))
        })
    }
}

/// Directions of the undercoat's hairs at height `t` (0..1) around a normal, which is z: they lean by `lean` (tangent of the angle) at
/// the tip and are turned by `jitter`.
pub fn orientations(lean: f32, jitter: f32, exponent: f32, t: f32) -> Vec<Orientation> {
    (0..512)
        .map(|i| {
            let [u, v] = even_samples(i);
            let z = 1.0 - 2.0 * u;
            let (sin, cos) = (std::f32::consts::TAU * v).sin_cos();
            let r = (1.0 - z * z).max(0.0).sqrt();
            let turn = jitter * t.powf(exponent) * Vec3::new(r * cos, r * sin, z);
            let tangent = (Vec3::new(lean * t, 0.0, 1.0) + turn).normalize();
            // As dense across the skin whichever way they lean, as far as the volume's hairs do.
            Orientation { tangent, projected: 1.0 / tangent.z.max(0.3) }
        })
        .collect()
}

/// Mean extinction in each bin by hairs of one direction, turned to all azimuths.
pub fn extinction(hair: Orientation) -> [f64; BINS] {
    const AZIMUTHS: u32 = 64;
    std::array::from_fn(|bin| {
        let mu = centre(bin) as f32;
        let sine = |k: u32| {
            let (sin, cos) = (std::f32::consts::TAU * (k as f32 + 0.5) / AZIMUTHS as f32).sin_cos();
            let r = (1.0 - mu * mu).sqrt();
            let along = hair.tangent.dot(Vec3::new(r * cos, r * sin, mu));
            (1.0 - along * along).max(0.0).sqrt()
        };
        f64::from(hair.projected * (0..AZIMUTHS).map(sine).sum::<f32>() / AZIMUTHS as f32)
    })
}
