//! The flat coat that stands for that of a world.

use super::slab::Medium;
use super::{Table, Terms, tangents};
use crate::World;
use crate::groom::{self, PackedGroom};
use crate::prepare::vertex_uv;
use crate::reference::groom::{Maps, Parameter, SkinPoint};
use crate::reference::noise::Field;
use crate::reference::shell::Shell;
use crate::reference::undercoat::Undercoat;
use glam::{Vec2, Vec3};

/// Points of the skin at which the coat is looked at.
const POINTS: usize = 64;
/// Heights above each.
const HEIGHTS: u32 = 8;

impl Table {
    /// The table for the fur of `world`, whose groom is `packed`.
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

/// The mean of a world's coat over its skin. Without undercoat it consists of guard hairs.
fn medium(world: &World, packed: &PackedGroom) -> Medium {
    let surface = &world.skin;
    let maps = Maps { groom: &packed.groom, texels: &packed.texels };
    let uv = vertex_uv(surface);
    let points: Vec<SkinPoint> = (0..surface.positions.len())
        .step_by((surface.positions.len() / POINTS).max(1))
        .map(|v| SkinPoint {
            position: surface.positions[v],
            normal: surface.normals[v],
            uv: Vec2::from(uv[v]),
            color: surface.colors.get(v).copied().unwrap_or(Vec3::ONE),
        })
        .collect();
    let mean = |of: &dyn Fn(&SkinPoint) -> f32| {
        f64::from(points.iter().map(of).sum::<f32>()) / points.len().max(1) as f64
    };
    let fur = &packed.fur;
    let scene = &world.scene;
    let skin = [0, 1, 2].map(|c| mean(&|p| maps.color(Parameter::BaseColor, p)[c]).clamp(0.0, 1.0));
    let (fibre, tangents, depth) = if groom::has_undercoat(scene) {
        let shell = Shell::default();
        let coat = Undercoat { fur, noise: Field::new(fur.seed), shell: &shell, cells: &[] };
        let relative = |p: &SkinPoint| {
            let domain = if fur.noise_domain == 1 { p.uv.extend(0.0) } else { p.position };
            let at = |k: u32| coat.clump_density(domain, domain, (k as f32 + 0.5) / HEIGHTS as f32);
            (0..HEIGHTS).map(at).sum::<f32>() / HEIGHTS as f32
        };
        let thick = |p: &SkinPoint| {
            let density = maps.scalar(Parameter::UndercoatDensity, p) / scene.undercoat.density.max();
            density * maps.scalar(Parameter::UndercoatHeight, p) * relative(p)
        };
        let lean = Vec3::from(fur.lean).length();
        let standing = tangents(lean, fur.tangent_jitter, fur.jitter_exponent, fur.seed);
        (&packed.coat_fibre, standing, f64::from(fur.extinction) * mean(&thick))
    } else {
        let of_guard =
            |p: &SkinPoint| maps.scalar(Parameter::GuardDensity, p) * maps.scalar(Parameter::GuardLength, p);
        let [root, widest, tip] = packed.groom.diameter;
        let diameter = f64::from(0.25 * root + 0.5 * widest + 0.25 * tip);
        let lean = mean(&|p| maps.scalar(Parameter::GuardComb, p)) as f32;
        let standing = tangents(lean, packed.groom.spread, 1.0, fur.seed);
        (&packed.guard_fibre, standing, diameter * mean(&of_guard))
    };
    Medium { fibre: fibre.clone(), tangents, depth: depth.max(0.05), skin, seed: fur.seed }
}
