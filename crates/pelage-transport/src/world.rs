//! The flat coat that represents the fur of a world: its mean over the skin.

use crate::bins::BINS;
use crate::coat::{Hairs, HeightLevel, Medium, Orientation, Part, extinction, orientations};
use crate::{Table, Terms};
use glam::{Vec2, Vec3};
use pelage_core::World;
use pelage_fur::groom;
use pelage_fur::groom::PackedGroom;
use pelage_fur::guard_strands::{diameter, strand_at_point};
use pelage_fur::layout::{Prism, Root, ShellVertex};
use pelage_fur::parameters::{Maps, MeshPlace, Parameter, SkinPoint, pack_color, root_point};
use pelage_fur::random::{even_barycentric, hash2, random};
use pelage_fur::shell::Shell;
use pelage_fur::simplex::Field;
use pelage_fur::strand_curve::color_at;
use pelage_fur::surface::vertex_uv;
use pelage_fur::undercoat::{Undercoat, mean_color};
use std::f32::consts::FRAC_PI_4;

/// About as many points of the skin at which the groom is sampled.
const POINTS: usize = 64;
/// Slices between the tips of the longest hairs and the skin, of equal height.
const SLICES: usize = 32;
/// Levels at which the directions of each kind of hairs are sampled.
const LEVELS: usize = 4;
/// Guard hairs that are sampled on each chosen triangle.
const GUARD_HAIRS: u32 = 8;

impl Table {
    /// The table for the fur of `world`, whose groom is `packed`, with the terms that the scene
    /// asks for.
    pub fn of_world(world: &World, packed: &PackedGroom) -> Self {
        let multiple = &world.scene.render.multiple;
        let terms = Terms {
            forward: f32::from(u8::from(multiple.forward)),
            backward: f32::from(u8::from(multiple.backward)),
            density: multiple.density,
        };
        Self::new(&medium(world, packed), &packed.guard_fibre, &terms)
    }
}

/// A segment of a sampled guard hair.
struct Piece {
    /// Height of its middle above the skin, cm.
    height: f32,
    /// Length times diameter per area of skin, for all hairs that it represents.
    depth: f32,
    /// Unit, root to tip; z is the skin's normal.
    tangent: Vec3,
    /// Linear RGB.
    color: Vec3,
}

/// The mean of a world's coat over its skin. The coat's mean albedo is that of the undercoat, also
/// where guard hairs alone grow.
pub(super) fn medium(world: &World, packed: &PackedGroom) -> Medium {
    let samples = SkinSamples::new(world, packed);
    let (fur, scene) = (&packed.undercoat, &world.scene);
    let skin = samples.mean_color(Parameter::BaseColor).to_array().map(|x| f64::from(x.clamp(0.0, 1.0)));
    let ends =
        [Parameter::UndercoatColorRoot, Parameter::UndercoatColorTip].map(|which| samples.mean_color(which));
    let whole = mean_color(&packed.undercoat_fibre, ends[0], ends[1]);
    let power = |color: Vec3| {
        let log = |x: f32| x.clamp(1e-3, 0.995).ln();
        [0, 1, 2].map(|c| log(color[c]) / log(whole[c]))
    };

    let coated = groom::has_undercoat(scene);
    let height = if coated { samples.mean_scalar(Parameter::UndercoatHeight) } else { 0.0 };
    let pieces = if groom::has_guard(scene) { guard_pieces(world, packed) } else { Vec::new() };
    let top = pieces.iter().map(|p| p.height).fold(height, f32::max).max(1e-3);
    let mut kinds = Vec::new();
    // By kind, then by slice.
    let mut parts: Vec<Vec<Part>> = Vec::new();
    if coated {
        let power = |t: f32| power(ends[0].lerp(ends[1], t));
        kinds.push(Hairs { fibre: packed.undercoat_fibre.clone(), levels: undercoat_levels(packed) });
        parts.push(undercoat_parts(&samples, height, top, &power));
    }
    if !pieces.is_empty() {
        let (levels, of_slice) = guard_parts(pieces, top, &power);
        kinds.push(Hairs { fibre: packed.guard_fibre.clone(), levels });
        parts.push(of_slice);
    }
    let slices: Vec<Vec<Part>> =
        (0..SLICES).map(|k| parts.iter().map(|of_kind| of_kind[k]).collect()).collect();
    if kinds.is_empty() || slices.iter().flatten().all(|p| p.depth <= 0.0) {
        // Nothing to scatter: the skin alone, below a few hairs that hardly count.
        return Medium::even(
            packed.undercoat_fibre.clone(),
            orientations(0.0, 0.0, 1.0, 0.0),
            0.05,
            skin,
            fur.seed,
        );
    }
    Medium { kinds, slices, skin, seed: fur.seed }
}

/// Points of the skin over which parameters of the groom are averaged.
struct SkinSamples<'a> {
    packed: &'a PackedGroom,
    maps: Maps<'a>,
    points: Vec<SkinPoint>,
}

impl<'a> SkinSamples<'a> {
    fn new(world: &World, packed: &'a PackedGroom) -> Self {
        let surface = &world.skin;
        let uv = vertex_uv(surface);
        let points = (0..surface.positions.len())
            .step_by((surface.positions.len() / POINTS).max(1))
            .map(|v| SkinPoint {
                position: surface.positions[v],
                normal: surface.normals[v],
                uv: Vec2::from(uv[v]),
                color: surface.vertex_color(v),
                place: MeshPlace::Vertex(v as u32),
            })
            .collect();
        Self { packed, maps: Maps { groom: &packed.groom, texels: &packed.texels }, points }
    }

    fn mean(&self, of: impl Fn(&SkinPoint) -> f32) -> f32 {
        self.points.iter().map(of).sum::<f32>() / self.points.len().max(1) as f32
    }

    fn mean_scalar(&self, which: Parameter) -> f32 {
        self.mean(|p| self.maps.scalar(which, p))
    }

    fn mean_color(&self, which: Parameter) -> Vec3 {
        Vec3::from_array([0, 1, 2].map(|c| self.mean(|p| self.maps.color(which, p)[c])))
    }
}

/// Height of the middle of slice `k`, cm, where the longest hairs reach up to `top`.
fn slice_middle(k: usize, top: f32) -> f32 {
    top - (k as f32 + 0.5) * (top / SLICES as f32)
}

/// Directions of the undercoat's hairs at levels, from the top down.
fn undercoat_levels(packed: &PackedGroom) -> Vec<HeightLevel> {
    let fur = &packed.undercoat;
    let lean = Vec3::from(fur.lean).length();
    (0..LEVELS)
        .map(|k| 1.0 - k as f32 / (LEVELS - 1) as f32)
        .map(|t| {
            // The optical-depth lattice knows the lean, but not the jitter.
            let leaning = Orientation::leaning(Vec3::new(lean * t, 0.0, 1.0).normalize());
            let isotropic = [f64::from(FRAC_PI_4 * leaning.projected); BINS];
            HeightLevel {
                hairs: orientations(lean, fur.tangent_jitter, fur.jitter_exponent, t),
                lattice_extinction: Some(if fur.isotropic == 1 { isotropic } else { extinction(leaning) }),
            }
        })
        .collect()
}

/// The undercoat's part of each slice, where it is `height` cm high and the longest hairs reach up
/// to `top`. `power` is [`Part::power`] at a relative height.
fn undercoat_parts(
    samples: &SkinSamples,
    height: f32,
    top: f32,
    power: &dyn Fn(f32) -> [f32; 3],
) -> Vec<Part> {
    let (fur, maps) = (&samples.packed.undercoat, &samples.maps);
    let shell = Shell::default();
    let undercoat = Undercoat { parameters: fur, noise: Field::new(fur.seed), shell: &shell, cells: &[] };
    let slice = top / SLICES as f32;
    let part = |k: usize| {
        let t = slice_middle(k, top) / height.max(1e-6);
        let density = |p: &SkinPoint| {
            let domain =
                if fur.noise_domain == 1 { p.uv.extend(0.0) } else { p.position - Vec3::from(fur.origin) };
            let density = maps.scalar(Parameter::UndercoatDensity, p) / fur.density;
            density * undercoat.clump_density(domain, domain, t)
        };
        let depth = if t < 1.0 { fur.extinction * samples.mean(density) * slice } else { 0.0 };
        let t = t.min(1.0);
        Part { depth: f64::from(depth), level: f64::from(1.0 - t) * (LEVELS - 1) as f64, power: power(t) }
    };
    (0..SLICES).map(part).collect()
}

/// Segments of guard hairs that are sampled on about [`POINTS`] triangles.
fn guard_pieces(world: &World, packed: &PackedGroom) -> Vec<Piece> {
    let (surface, groom) = (&world.skin, &packed.groom);
    let uv = vertex_uv(surface);
    let step = (surface.triangles.len() / POINTS).max(1);
    let chosen: Vec<[u32; 3]> = surface.triangles.iter().copied().step_by(step).collect();
    // A shell of these triangles alone, in which the roots are placed.
    let corners = || chosen.iter().flatten().map(|v| *v as usize);
    let vertex = |v: usize| ShellVertex {
        position: surface.positions[v].into(),
        height: 0.0,
        normal: surface.normals[v].into(),
        color: pack_color(surface.vertex_color(v)),
    };
    let prism = |k: u32| Prism { vertices: [3 * k, 3 * k + 1, 3 * k + 2], ..bytemuck::Zeroable::zeroed() };
    let shell = Shell {
        vertices: corners().map(vertex).collect(),
        prisms: (0..chosen.len() as u32).map(prism).collect(),
        corner_uv: corners().map(|v| uv[v]).collect(),
        light_reach: 1.0,
    };
    let maps = Maps { groom, texels: &packed.texels };
    let roots = chosen.len() as u32 * GUARD_HAIRS;
    let mut pieces = Vec::new();
    for k in 0..roots {
        let seed = hash2(packed.undercoat.seed, k);
        let lambda = even_barycentric(Vec2::new(random(seed, 100), random(seed, 101)));
        let root = Root { prism: k / GUARD_HAIRS, seed, lambda: [lambda.y, lambda.z] };
        let mut at = root_point(&shell, &root);
        // The shell has the chosen triangles alone.
        at.place = MeshPlace::Triangle(root.prism * step as u32, lambda);
        let density = maps.scalar(Parameter::GuardDensity, &at) / roots as f32;
        let strand = strand_at_point(&maps, &at, root.seed);
        let thickness = maps.scalar(Parameter::GuardThickness, &at);
        let colors = [Parameter::GuardColorRoot, Parameter::GuardColorTip].map(|p| maps.color(p, &at));
        let (side, other) = strand.normal.any_orthonormal_pair();
        for k in 0..groom.segments {
            let [a, b] = [k, k + 1].map(|k| k as f32 / groom.segments as f32);
            let s = 0.5 * (a + b);
            let along = strand.point(b) - strand.point(a);
            let above = strand.point(s) - strand.root;
            pieces.push(Piece {
                height: above.dot(strand.normal).max(0.0),
                depth: density * along.length() * thickness * diameter(&strand.hairs, s) * strand.opacity(s),
                tangent: Vec3::new(along.dot(side), along.dot(other), along.dot(strand.normal))
                    .normalize_or(Vec3::Z),
                color: color_at(strand.hairs.color_transition, colors, s),
            });
        }
    }
    pieces
}

/// Directions of guard hairs at levels, from the top down, and their part of each slice. `power` is
/// [`Part::power`] of a colour.
fn guard_parts(
    mut pieces: Vec<Piece>,
    top: f32,
    power: &dyn Fn(Vec3) -> [f32; 3],
) -> (Vec<HeightLevel>, Vec<Part>) {
    pieces.sort_by(|a, b| b.height.total_cmp(&a.height));
    let whole: f32 = pieces.iter().map(|p| p.depth).sum();
    // Each level represents an equal share of the depth, by as many hairs, drawn in proportion to
    // their depth.
    let per_level = 256;
    let mut levels = vec![Vec::new(); LEVELS];
    let mut heights = [0.0; LEVELS];
    let (mut passed, mut taken) = (0.0, 0);
    for piece in &pieces {
        passed += piece.depth;
        while taken < LEVELS * per_level
            && (taken as f32 + 0.5) / (LEVELS * per_level) as f32 * whole <= passed
        {
            let level = taken / per_level;
            levels[level].push(Orientation { tangent: piece.tangent, projected: 1.0 });
            heights[level] += piece.height / per_level as f32;
            taken += 1;
        }
    }
    let last = pieces.last().map_or(Vec3::Z, |p| p.tangent);
    for level in levels.iter_mut().filter(|s| s.is_empty()) {
        level.push(Orientation { tangent: last, projected: 1.0 });
    }
    // Position between the levels of a height above the skin.
    let level_at = |z: f32| {
        let k = (1..LEVELS - 1).find(|k| heights[*k] <= z).unwrap_or(LEVELS - 1);
        let x = (heights[k - 1] - z) / (heights[k - 1] - heights[k]).max(1e-6);
        (k - 1) as f64 + f64::from(x.clamp(0.0, 1.0))
    };
    let slice = top / SLICES as f32;
    let mut sums = vec![(0.0f32, Vec3::ZERO); SLICES];
    for piece in &pieces {
        let k = (((top - piece.height) / slice) as usize).min(SLICES - 1);
        sums[k].0 += piece.depth;
        sums[k].1 += piece.depth * piece.color;
    }
    let parts = sums
        .iter()
        .enumerate()
        .map(|(k, (depth, color))| Part {
            depth: f64::from(*depth),
            level: level_at(slice_middle(k, top)),
            power: power(*color / depth.max(1e-12)),
        })
        .collect();
    // The optical-depth lattice does not keep the directions of guard hairs: it takes the mean sine
    // of the angle to a ray.
    let lattice_extinction = Some([f64::from(FRAC_PI_4); BINS]);
    (levels.into_iter().map(|hairs| HeightLevel { hairs, lattice_extinction }).collect(), parts)
}
