//! `guard_shade` against its CPU twin: the radiance of every strand vertex.

use crate::common::gpu;
use crate::common::lit::Lit;
use crate::common::worlds::ball;
use glam::Vec3;
use pelage_core::scene::{FibreModel, MultipleModel, Scene, Shading};
use pelage_fur::fibre::Fibre;
use pelage_fur::layout::Root;
use pelage_gpu::Gpu;
use pelage_render::twin::film::halves;
use pelage_render::twin::guard_shade::{HIDDEN, shade};

/// Compares all strands; `fibre_factor` disturbs the twin's fibre.
fn agreement(gpu: &'static Gpu, edit: impl FnOnce(&mut Scene), fibre_factor: f32, tolerance: f32) -> f64 {
    let lit = Lit::new(gpu, ball(edit));
    let segments = lit.fixture.prepared.segments as usize;
    let count = lit.fixture.strands();
    let roots: Vec<Root> = lit.fixture.read("roots", count);
    let vertices = lit.fixture.strand_vertices();
    let shades: Vec<[u32; 2]> = lit.fixture.read("shades", count * (segments + 1));
    let (light, maps) = (lit.lattice(), lit.fixture.maps());
    let mut fibre = lit.fixture.packed.guard_fibre.clone();
    if let Fibre::Sadeghi(model) = &mut fibre {
        model.width[0] *= fibre_factor;
    } else if let Fibre::Chiang(model) = &mut fibre {
        model.variance = model.variance.map(|v| v * fibre_factor);
    }
    let (mut good, mut lit_up, mut hidden) = (0, 0, 0);
    for (i, root) in roots.iter().enumerate() {
        let range = i * (segments + 1)..(i + 1) * (segments + 1);
        let wanted = shade(&light, &maps, &fibre, root, &vertices[range.clone()]);
        for (found, wanted) in shades[range].iter().zip(&wanted) {
            let [[r, g], [b, out]] = found.map(halves);
            let found = Vec3::new(r, g, b);
            if (wanted.eye_tau - HIDDEN).abs() > 0.1 {
                assert_eq!(out > 0.5, wanted.eye_tau > HIDDEN, "strand {i}: {wanted:?}");
            }
            if out > 0.5 {
                hidden += 1;
                continue;
            }
            lit_up += 1;
            good += usize::from(
                (found - wanted.radiance).abs().max_element()
                    < tolerance * (0.05 + wanted.radiance.max_element()),
            );
        }
    }
    println!("{good} of {lit_up} vertices agree, {hidden} hidden");
    assert!(lit_up > 5000 && hidden > 100, "{lit_up} {hidden}");
    f64::from(good as u32) / f64::from(lit_up as u32)
}

#[test]
fn shades_agree_with_the_twin() {
    let Some(gpu) = gpu::open() else { return };
    // At the border of a lattice cell single precision may choose the other side: continuous, but
    // not to the last digit.
    assert!(agreement(gpu, |_| (), 1.0, 2e-3) > 0.995);
}

#[test]
fn paper_shading_agrees_with_the_twin() {
    let Some(gpu) = gpu::open() else { return };
    assert!(agreement(gpu, |s| s.render.shading = Shading::Paper, 1.0, 2e-3) > 0.995);
}

#[test]
fn dual_scattering_agrees_with_the_twin() {
    let Some(gpu) = gpu::open() else { return };
    assert!(agreement(gpu, |s| s.render.multiple.model = MultipleModel::Dual, 1.0, 2e-3) > 0.99);
}

#[test]
fn transport_agrees_with_the_twin() {
    let Some(gpu) = gpu::open() else { return };
    assert!(agreement(gpu, |s| s.render.multiple.model = MultipleModel::Transport, 1.0, 2e-3) > 0.99);
}

#[test]
fn another_fibre_does_not_agree() {
    let Some(gpu) = gpu::open() else { return };
    assert!(agreement(gpu, |_| (), 1.05, 2e-3) < 0.9);
}

#[test]
fn other_models_agree_with_the_twin() {
    let Some(gpu) = gpu::open() else { return };
    // Tables are read where models depend on the offset across the hair.
    for (model, tolerance) in [
        (FibreModel::KajiyaKay, 2e-3),
        (FibreModel::SadeghiNormalised, 4e-3),
        (FibreModel::Chiang, 0.02),
        (FibreModel::Medulla, 0.02),
    ] {
        let part = agreement(gpu, |s| s.guard.fibre.model = Some(model), 1.0, tolerance);
        assert!(part > 0.99, "{model:?}: {part}");
    }
    assert!(agreement(gpu, |s| s.guard.fibre.model = Some(FibreModel::Chiang), 2.0, 0.02) < 0.9);
}

#[test]
fn paper_shading_has_the_paper_s_models() {
    let paper = |s: &mut Scene| {
        s.render.shading = Shading::Paper;
        s.guard.fibre.model = Some(FibreModel::Chiang);
        s.undercoat.fibre.model = Some(FibreModel::Chiang);
    };
    let world = ball(paper);
    assert!(matches!(Fibre::guard(&world.scene), Fibre::Sadeghi(_)));
    assert!(matches!(Fibre::undercoat(&world.scene), Fibre::KajiyaKay(_)));
}
