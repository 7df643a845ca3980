//! The guard hairs that the renderer draws, grown by the CPU twins of its shaders.

use super::patch::Patch;
use super::strands::{Hair, Strands};
use pelage_fur::Layer;
use pelage_fur::groom::PackedGroom;
use pelage_fur::guard_strands::opacity as opacity_at;
use pelage_fur::guard_strands::{Strand, end_colors, strand};
use pelage_fur::hair_roots::Roots;
use pelage_fur::layout::GuardHairs;
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
    // Without parts, all hairs have the same.
    let own_shapes = groom.count > 1;
    let present = u64::MAX >> (64 - groom.segments.clamp(1, 64));
    let of_triangle = |prism: u32| {
        let (mut points, mut hairs, mut shapes) = (Vec::new(), Vec::new(), Vec::new());
        if patch.is_some_and(|p| !p.reaches(shell, prism)) {
            return (points, hairs, shapes);
        }
        for root in roots.of(prism) {
            let strand = strand(shell, &maps, &root);
            if patch.is_some_and(|p| !p.holds(strand.root)) {
                continue;
            }
            let [color_root, color_tip] = end_colors(&maps, &root_point(shell, &root), root.seed);
            shapes.extend(own_shapes.then(|| shape(&strand)));
            hairs.push(Hair {
                color_root,
                color_tip,
                glint_angle: pelage_fur::fibre::glint_angle(random(root.seed, 7)),
                present,
            });
            points.extend(strand.vertices(groom).into_iter().map(|v| position(v).extend(radius(v))));
        }
        (points, hairs, shapes)
    };
    let grown: Vec<_> = (0..shell.prisms.len() as u32).into_par_iter().map(of_triangle).collect();
    let (mut joined, mut shapes) = (Vec::with_capacity(grown.len()), Vec::new());
    for (points, hairs, of_triangle) in grown {
        joined.push((points, hairs));
        shapes.extend(of_triangle);
    }
    let opacity = |[opacity, tip_fade, ..]: &Shape| {
        let hairs = GuardHairs { opacity: *opacity, tip_fade: *tip_fade, ..groom.coats[0].hairs };
        (0..=groom.segments).map(move |k| opacity_at(&hairs, k as f32 / groom.segments as f32))
    };
    let own = groom.coats[0].hairs;
    let opacity: Vec<f32> = match own_shapes {
        true => shapes.iter().flat_map(opacity).collect(),
        false => opacity(&[own.opacity, own.tip_fade, 0.0, 0.0]).collect(),
    };
    let opaque = opacity.iter().all(|a| *a >= 1.0);
    Strands {
        opacity: if opaque { Vec::new() } else { opacity },
        color_transition: own.color_transition,
        color_transitions: shapes.iter().map(|[_, _, middle, width]| [*middle, *width]).collect(),
        ..Strands::joined(Layer::Guard, groom.segments as usize, joined)
    }
}

/// What may differ between the hairs of parts: opacity and its decay, and the colour transition.
type Shape = [f32; 4];

fn shape(strand: &Strand) -> Shape {
    let GuardHairs { opacity, tip_fade, color_transition: [middle, width], .. } = strand.hairs;
    [opacity, tip_fade, middle, width]
}
