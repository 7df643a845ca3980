//! The guard hairs that the renderer draws, grown by the CPU twins of its shaders.

use super::patch::Patch;
use super::strands::{Hair, Strands};
use glam::{Vec3, Vec4};
use pelage_fur::Layer;
use pelage_fur::groom::PackedGroom;
use pelage_fur::guard_strands::strand;
use pelage_fur::hair_roots::Roots;
use pelage_fur::parameters::{Maps, Parameter, skin_point};
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
            let [l1, l2] = root.lambda;
            let at = skin_point(shell, prism, Vec3::new(1.0 - l1 - l2, l1, l2));
            // The variation of colour from strand to strand, as in guard_shade.
            let tone = 1.0 + groom.color_variation * (2.0 * random(root.seed, 6) - 1.0);
            hairs.push(Hair {
                color_root: maps.color(Parameter::GuardColorRoot, &at) * tone,
                color_tip: maps.color(Parameter::GuardColorTip, &at) * tone,
                glint_angle: pelage_fur::fibre::glint_angle(random(root.seed, 7)),
                present,
            });
            points.extend(strand.vertices(groom).into_iter().map(|v| position(v).extend(radius(v))));
        }
        (points, hairs)
    };
    let grown: Vec<(Vec<Vec4>, Vec<Hair>)> =
        (0..shell.prisms.len() as u32).into_par_iter().map(of_triangle).collect();
    let opacity: Vec<f32> = (0..=groom.segments)
        .map(|k| groom.opacity * (-groom.tip_fade * k as f32 / groom.segments as f32).exp())
        .collect();
    let opaque = opacity.iter().all(|a| *a >= 1.0);
    Strands {
        opacity: if opaque { Vec::new() } else { opacity },
        color_transition: groom.color_transition,
        ..Strands::joined(Layer::Guard, groom.segments as usize, grown)
    }
}
