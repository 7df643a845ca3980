//! Twin of `shaders/guard_shade.wgsl`: shading of the guard hairs at their vertices.

use crate::twin::lattice::{cell, node_index};
use crate::twin::undercoat_source::Lattice;
use glam::Vec3;
use pelage_core::scene::MultipleModel;
use pelage_fur::Layer;
use pelage_fur::fibre::{Angles, Fibre, Hit};
use pelage_fur::guard_strands::end_colors;
use pelage_fur::layout::Root;
use pelage_fur::parameters::{Maps, root_point};
use pelage_fur::random::random;
use pelage_fur::shell::Located;
use pelage_fur::strand_curve::color_at;
use pelage_fur::strands::{position, tangent};

/// Optical depth towards the camera beyond which a vertex is hidden and not shaded.
pub const HIDDEN: f32 = 14.0;

/// A shaded vertex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shade {
    /// Radiance towards the camera.
    pub radiance: Vec3,
    /// Least optical depth towards the camera at the corners of its lattice cell; beyond [`HIDDEN`]
    /// the shader skips the vertex.
    pub eye_tau: f32,
}

/// Shades the vertices of a strand that grows from `root`.
pub fn shade(
    lattice: &Lattice<'_>,
    maps: &Maps<'_>,
    fibre: &Fibre,
    root: &Root,
    strand: &[[f32; 4]],
) -> Vec<Shade> {
    let (fur, shell, groom) = (lattice.fur, lattice.shell, maps.groom);
    let at = root_point(shell, root);
    let ends = end_colors(maps, &at, root.seed);
    let hairs = maps.hairs_at(&at);
    let glint_angle = pelage_fur::fibre::glint_angle(random(root.seed, 7));
    let mut place = shell.enter(root.prism);
    let mut inside = true;
    let mut shades = Vec::new();
    for (k, vertex) in strand.iter().enumerate() {
        let x = position(*vertex);
        let along = tangent(strand, k);
        let view = (Vec3::from(lattice.frame.eye) - x).normalize();
        let s = k as f32 / (strand.len() - 1) as f32;
        let albedo = color_at(hairs.color_transition, ends, s);
        // A strand that leaves the shell over the border of the skin keeps its last place.
        inside = inside && shell.locate(&mut place, x, along, 3) == Located::Inside;
        let cell = cell(fur, &place);
        let corners = |j: u32| {
            [0, 1, 2].map(|c| {
                let node = node_index(fur, cell.columns[c], cell.level);
                [lattice.tau(node, j), lattice.tau(node + 1, j)]
            })
        };
        let tau = |j: u32| {
            let along = corners(j).map(|[low, high]| low + (high - low) * cell.fraction);
            cell.weights.dot(Vec3::from(along))
        };
        let mut radiance = Vec3::ZERO;
        for (j, l) in (0..fur.lights.count).zip(lattice.lights) {
            let through = match groom.paper {
                0 => (-tau(j) * (1.0 - fur.undercoat.forward_scattering * albedo)).exp(),
                _ => Vec3::ONE,
            };
            let scattered = fibre.scatter_far(
                &Hit { tint: albedo, glint_angle, h: 0.0 },
                &Angles::around(along, Vec3::from(l.direction), view),
            );
            radiance += Vec3::from(l.irradiance) * through * scattered;
            if let (MultipleModel::Dual, Some(table)) = (lattice.multiple, lattice.table) {
                let to_light = Vec3::from(l.direction);
                let of_light = table.dual_scatter(Layer::Guard, albedo, along, to_light, view, tau(j));
                radiance += Vec3::from(l.irradiance) * of_light;
            }
        }
        if let (MultipleModel::Transport, Some(table)) = (lattice.multiple, lattice.table) {
            let mut scattered = [Vec3::ZERO; 2];
            for c in 0..3 {
                let node = node_index(fur, cell.columns[c], cell.level);
                let [low, high] = [node, node + 1].map(|node| lattice.scattered(node));
                (0..2).for_each(|k| scattered[k] += cell.weights[c] * low[k].lerp(high[k], cell.fraction));
            }
            let normal = place.direction(place.lambda);
            radiance += table.guard_response(albedo, along, view, normal, scattered);
        }
        if groom.paper == 1 {
            // [Andersen2016] sec. 3.1
            radiance *= 1.0 - hairs.root_darkening[0] * (-s / hairs.root_darkening[1]).exp();
        }
        let least = corners(fur.lights.count).into_iter().flatten().fold(f32::INFINITY, f32::min);
        shades.push(Shade { radiance, eye_tau: if inside { least } else { 0.0 } });
    }
    shades
}
