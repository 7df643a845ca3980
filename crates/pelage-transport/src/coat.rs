//! A flat coat of one or two kinds of hairs, whose density, colour and directions change with the
//! height.
//!
//! *Depth* measures how much hair lies above a point: 0 at the tips of the longest hairs, growing
//! downwards by the projected area of hairs of all kinds (length times diameter) per area of skin.
//! It is the optical depth that these hairs would have if each were seen perpendicular to its axis.
//! It has no unit, and neither has extinction, which counts for a depth of 1.
//!
//! *Albedo* is one channel of a hair's colour ([`pelage_fur::fibre::Hit::tint`]), from which its
//! fibre model derives what it absorbs; a diffuse hair's single-scattering albedo is just that. A
//! coat has one mean albedo for each colour; its parts are darker or brighter by a fixed power of
//! it.

use crate::bins::{BINS, centre, interpolate, neighbours};
use crate::grid::{ALBEDOS, albedo, albedo_fraction};
use crate::operators::Operators;
use crate::slab::Layer;
use glam::Vec3;
use pelage_fur::fibre::Fibre;
use rayon::prelude::*;
use sobol_burley::sample;

/// Hairs of one scattering model: the undercoat or the guard hairs.
#[derive(Debug, Clone)]
pub struct Hairs {
    /// Their scattering model.
    pub fibre: Fibre,
    /// Their directions at levels from the top down.
    pub levels: Vec<HeightLevel>,
}

/// The directions of hairs at one height.
#[derive(Debug, Clone)]
pub struct HeightLevel {
    /// Sampled directions, all of equal weight.
    pub hairs: Vec<Orientation>,
    /// Their extinction along each bin's directions as the optical-depth lattice counts it; `None`
    /// where it counts the true one.
    pub lattice_extinction: Option<[f64; BINS]>,
}

/// The direction of a piece of hair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orientation {
    /// Unit, root to tip; z is the skin's normal.
    pub tangent: Vec3,
    /// Projected area, perpendicular to the hair, for a depth of 1: more than 1 where depth was
    /// measured along the skin's normal and the hair, leaning, is longer than the layer is high.
    pub projected: f32,
}

impl Orientation {
    /// A hair of the undercoat, whose hairs per area of skin do not depend on their lean. A hair
    /// that lies nearly flat is limited as in the undercoat's volume (`Place::crowding`).
    pub fn leaning(tangent: Vec3) -> Self {
        Self { tangent, projected: 1.0 / tangent.z.max(0.3) }
    }
}

/// Hairs of one kind in a slice or a layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// The depth that they contribute.
    pub depth: f64,
    /// Where they are between [`Hairs::levels`]: an index with a fraction.
    pub level: f64,
    /// Their albedo is the coat's mean albedo to this power, for each colour.
    pub power: [f32; 3],
}

/// A coat on a skin.
#[derive(Debug, Clone)]
pub struct Medium {
    /// The undercoat first, guard hairs last; there may be only one of them.
    pub kinds: Vec<Hairs>,
    /// From the top down, each with a part for each kind.
    pub slices: Vec<Vec<Part>>,
    /// Reflectance of the skin, linear RGB.
    pub skin: [f64; 3],
    /// Seed of the sampled operators.
    pub seed: u32,
}

/// Operators of a medium's hairs.
pub struct OperatorTable {
    /// `[kind][level][albedo]`, the albedos those of [`crate::grid`].
    operators: Vec<Vec<Vec<Operators>>>,
}

impl Medium {
    /// A uniform coat of one kind of hairs.
    pub fn even(fibre: Fibre, orientations: Vec<Orientation>, depth: f64, skin: [f64; 3], seed: u32) -> Self {
        let kinds = vec![Hairs {
            fibre,
            levels: vec![HeightLevel { hairs: orientations, lattice_extinction: None }],
        }];
        let slices = vec![vec![Part { depth, level: 0.0, power: [1.0; 3] }]];
        Self { kinds, slices, skin, seed }
    }

    /// Depth of the whole coat.
    pub fn depth(&self) -> f64 {
        self.slices.iter().flatten().map(|part| part.depth).sum()
    }

    /// Samples the operators of all kinds, levels and albedos.
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
                            .map(|i| Operators::new(&hairs.fibre, level, albedo(i), self.seed))
                            .collect()
                    })
                    .collect()
            })
            .collect();
        OperatorTable { operators }
    }

    /// Composition between two depths: a part for each kind, the mean over the slices that overlap
    /// them. A kind that has no hairs there gets a depth of 0 and the properties of its nearest
    /// part.
    fn parts_at(&self, from: f64, to: f64) -> Vec<Part> {
        let mut sums = vec![Part { depth: 0.0, level: 0.0, power: [0.0; 3] }; self.kinds.len()];
        let mut top = 0.0;
        let last = self.slices.len() - 1;
        for (k, slice) in self.slices.iter().enumerate() {
            let whole: f64 = slice.iter().map(|p| p.depth).sum();
            // Depths beyond the skin by rounding belong to the last slice.
            let bottom = if k == last { f64::INFINITY } else { top + whole };
            let common = to.min(bottom) - from.max(top);
            top = bottom;
            if common <= 0.0 || whole <= 0.0 {
                continue;
            }
            for (sum, part) in sums.iter_mut().zip(slice) {
                let depth = part.depth * common / whole;
                sum.depth += depth;
                sum.level += depth * part.level;
                (0..3).for_each(|c| sum.power[c] += depth as f32 * part.power[c]);
            }
        }
        for (kind, sum) in sums.iter_mut().enumerate() {
            if sum.depth > 0.0 {
                sum.level /= sum.depth;
                sum.power = sum.power.map(|p| p / sum.depth as f32);
            } else if let Some(nearest) = self.nearest(kind, 0.5 * (from + to)) {
                *sum = Part { depth: 0.0, ..nearest };
            }
        }
        sums
    }

    /// The part of a kind in the slice nearest to a depth in which it has hairs.
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

    /// Thicknesses of the layers, from the top down: thinnest at the top, where the light changes
    /// fastest.
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

    /// Layers of the coat, from the top down, where its mean albedo is `albedo` and stands for
    /// colour number `color`.
    pub fn layers(&self, operators: &OperatorTable, albedo: f32, color: usize) -> Vec<Layer> {
        let mut top = 0.0;
        let of_layer = |thickness: f64| {
            let mut layer = Layer::empty(thickness);
            let parts = self.parts_at(top, top + thickness);
            top += thickness;
            for (kind, part) in parts.iter().enumerate().filter(|(_, part)| part.depth > 0.0) {
                for (operators, weight) in operators.around(kind, part.level, albedo.powf(part.power[color]))
                {
                    layer.add(operators, part.depth / thickness * weight);
                }
            }
            layer
        };
        self.thicknesses().into_iter().map(of_layer).collect()
    }

    /// How each kind of hairs scatters at `depth`, in a coat as that of [`Medium::layers`].
    pub fn responses<'a>(
        &self,
        operators: &'a OperatorTable,
        albedo: f32,
        depth: f64,
        color: usize,
    ) -> Vec<Responses<'a>> {
        let of_kind = |(kind, part): (usize, Part)| {
            Responses(operators.around(kind, part.level, albedo.powf(part.power[color])).collect())
        };
        self.parts_at(depth - 1e-6, depth + 1e-6).into_iter().enumerate().map(of_kind).collect()
    }
}

/// How hairs of one kind at one depth scatter: operators and their weights.
pub struct Responses<'a>(Vec<(&'a Operators, f64)>);

impl Responses<'_> {
    /// Radiance sent towards the cosine `mu` over the hairs' extinction (a source function), for a
    /// radiance of 1 from each bin.
    pub fn at(&self, mu: f64) -> [f64; BINS] {
        let (a, b, x) = neighbours(mu);
        let mut response = [0.0; BINS];
        for (op, weight) in &self.0 {
            let scale = weight / interpolate(&op.extinction, mu);
            for (bin, sum) in response.iter_mut().enumerate() {
                *sum += scale * (op.kernel[a][bin] + (op.kernel[b][bin] - op.kernel[a][bin]) * x);
            }
        }
        response
    }
}

impl OperatorTable {
    /// The up to four operators of a kind around a level and an albedo, with the weights of a
    /// bilinear interpolation.
    fn around(&self, kind: usize, level: f64, albedo: f32) -> impl Iterator<Item = (&Operators, f64)> {
        let levels = &self.operators[kind];
        let level = level.clamp(0.0, (levels.len() - 1) as f64);
        let above = (level as usize).min(levels.len().saturating_sub(2));
        let x = level - above as f64;
        let place = f64::from(albedo_fraction(albedo).clamp(0.0, 1.0)) * (ALBEDOS - 1) as f64;
        let darker = (place as usize).min(ALBEDOS - 2);
        let y = place - darker as f64;
        [(0, 0), (0, 1), (1, 0), (1, 1)].into_iter().filter_map(move |(s, c)| {
            let weight = [1.0 - x, x][s] * [1.0 - y, y][c];
            (weight > 0.0).then(|| (&levels[above + s][darker + c], weight))
        })
    }
}

/// Directions of the undercoat's hairs at the height `t` (0 at the skin, 1 at the tips), z being
/// the skin's normal: they lean by `lean * t` (tangent of the angle to the normal) and are turned
/// by a random vector of length `jitter * t^exponent`.
pub fn orientations(lean: f32, jitter: f32, exponent: f32, t: f32) -> Vec<Orientation> {
    (0..512)
        .map(|i| {
            let [u, v] = [0, 1].map(|dimension| sample(i, dimension, 0));
            let z = 1.0 - 2.0 * u;
            let (sin, cos) = (std::f32::consts::TAU * v).sin_cos();
            let r = (1.0 - z * z).max(0.0).sqrt();
            let turn = jitter * t.powf(exponent) * Vec3::new(r * cos, r * sin, z);
            let tangent = (Vec3::new(lean * t, 0.0, 1.0) + turn).normalize();
            Orientation::leaning(tangent)
        })
        .collect()
}

/// Extinction along each bin's directions by hairs of one inclination, a mean over all azimuths.
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
