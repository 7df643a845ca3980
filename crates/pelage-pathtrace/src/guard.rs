//! The guard hairs that the renderer draws, grown by the CPU twins of its shaders.

use super::patch::Patch;
use super::strands::{Hair, Strands};
use glam::Vec4;
use pelage_fur::Layer;
use pelage_fur::groom::PackedGroom;
use pelage_fur::guard_strands::{end_colors, opacity, strand};
use pelage_fur::hair_roots::Roots;
use pelage_fur::parameters::{Maps, root_point};
use pelage_fur::random::random;
use pelage_fur::shell::Shell;
use pelage_fur::strands::{position, radius};
use rayon::prelude::*;

/// All guard hairs whose roots lie in `patch`, triangle by triangle, in the order in which
/// `hair_roots` emits them.
pub(super) fn grow(
    shell: &Shell,
    packed: &PackedGroom,
    density: f32,
    seed: u32,
    patch: Option<&Patch>,
) -> Strands {
    let groom = &packed.groom;
    let maps = Maps { groom, texels: &packed.texels };
    let roots = Roots { shell, maps, density, seed };
    let present = u64::MAX >> (64 - groom.segments.clamp(1, 64));
    let of_triangle = |prism: u32| {
        let mut points = Vec::new();
        let mut hairs = Vec::new();
        if patch.is_some_and(|p| !p.reaches(shell, prism)) {
            return (points, hairs);
        }
        for root in roots.of(prism) {
            let strand = strand(shell, &maps, &root);
            if patch.is_some_and(|p| !p.holds(strand.root)) {
                continue;
            }
            let [color_root, color_tip] = end_colors(&maps, &root_point(shell, &root), root.seed);
            hairs.push(Hair {
                color_root,
                color_tip,
                glint_angle: pelage_fur::fibre::glint_angle(random(root.seed, 7)),
                present,
            });
            points.extend(strand.vertices(groom).into_iter().map(|v| position(v).extend(radius(v))));
        }
        (points, hairs)
    };
    let grown: Vec<(Vec<Vec4>, Vec<Hair>)> =
        (0..shell.prisms.len() as u32).into_par_iter().map(of_triangle).collect();
    let opacity: Vec<f32> =
        (0..=groom.segments).map(|k| opacity(groom, k as f32 / groom.segments as f32)).collect();
    let opaque = opacity.iter().all(|a| *a >= 1.0);
    Strands {
        opacity: if opaque { Vec::new() } else { opacity },
        color_transition: groom.color_transition,
        ..Strands::joined(Layer::Guard, groom.segments as usize, grown)
    }
}
