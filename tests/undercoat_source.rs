//! `undercoat_source` against its CPU twin: every node of the lattice, and the light of the skin.

use crate::common::gpu;
use crate::common::lit::Lit;
use crate::common::worlds::ball;
use glam::Vec3;
use pelage_core::scene::{DirectionalLight, FibreModel, MultipleModel};
use pelage_render::twin::film::halves;
use pelage_render::twin::undercoat_source::unpack;

#[test]
fn source_and_skin_agree_with_the_twin() {
    // Halves of up to 24: 2^-6 at most; of logarithms.
    agreement(FibreModel::KajiyaKay, MultipleModel::Similarity, 0.02);
}

#[test]
fn colored_scattering_agrees_with_the_twin() {
    agreement(FibreModel::Sadeghi, MultipleModel::Similarity, 0.02);
    agreement(FibreModel::Chiang, MultipleModel::Similarity, 0.05);
    agreement(FibreModel::Medulla, MultipleModel::Similarity, 0.05);
}

#[test]
fn dual_scattering_agrees_with_the_twin() {
    // Tables are filtered with eight bits.
    agreement(FibreModel::KajiyaKay, MultipleModel::Dual, 0.02);
    agreement(FibreModel::Chiang, MultipleModel::Dual, 0.05);
}

#[test]
fn transport_agrees_with_the_twin() {
    agreement(FibreModel::KajiyaKay, MultipleModel::Transport, 0.02);
    agreement(FibreModel::Chiang, MultipleModel::Transport, 0.05);
}

fn agreement(model: FibreModel, multiple: MultipleModel, tolerance: f32) {
    let Some(gpu) = gpu::open() else { return };
    let lit = Lit::new(
        gpu,
        ball(|s| {
            // Two key lights and two that are summed.
            s.lights.push(DirectionalLight { direction: [0.1, -0.9, 0.2], irradiance: [0.3, 0.5, 0.4] });
            s.lights.push(DirectionalLight { direction: [0.0, 0.2, -1.0], irradiance: [0.6, 0.5, 0.4] });
            s.undercoat.fibre.specular = 0.4;
            s.render.multiple.model = multiple;
            s.undercoat.fibre.model = Some(model);
            s.undercoat.lean = 0.5;
            s.guard.comb_direction = [1.0, 0.0, 0.0];
        }),
    );
    let fur = &lit.fixture.fur;
    let light = lit.lattice();
    let source: Vec<[u32; 4]> = lit.fixture.read("node_light", lit.nodes());
    let base: Vec<[u32; 2]> = lit.fixture.read("base_light", fur.lattice.columns as usize);
    let (mut brightest, mut worst, mut on_guard) = (0f32, 0f32, 0f32);
    for column in 0..fur.lattice.columns {
        for level in 0..=fur.lattice.levels {
            let place = lit.place(column, level);
            let wanted = light.source(column, level, &place);
            let found = unpack(source[(column * (fur.lattice.levels + 1) + level) as usize]);
            // Of logarithms; where little is scattered towards the camera, a table's error is
            // relative to its peak.
            let dim = if matches!(model, FibreModel::Chiang | FibreModel::Medulla) { -5.0 } else { -30.0 };
            let log = |s: Vec3| s.max(Vec3::splat(dim));
            let ambient = (log(found.log_ambient) - log(wanted.log_ambient)).abs().max_element();
            worst = worst.max(ambient);
            assert!(ambient < tolerance, "column {column}, level {level}: {found:?} is not {wanted:?}");
            assert_eq!(found.key_tau, wanted.key_tau, "column {column}, level {level}");
            assert!((found.albedo - wanted.albedo).abs().max_element() < 1.1 / 1023.0);
            assert!((found.density - wanted.density).abs() < 1e-3);
            if multiple == MultipleModel::Transport {
                let node = column * (fur.lattice.levels + 1) + level;
                for (found, wanted) in
                    light.scattered(node).iter().zip(&light.sent(column, level, &place)[1..])
                {
                    let error = (*found - *wanted).abs().max_element();
                    assert!(
                        error < 5e-3 * (0.1 + wanted.max_element()),
                        "guard hairs: {found} is not {wanted}"
                    );
                    on_guard = on_guard.max(wanted.max_element());
                }
            }
            brightest = brightest.max(wanted.log_ambient.max_element());
        }
        let wanted = light.base_light(column, &lit.place(column, 0));
        let [r, g] = halves(base[column as usize][0]);
        let found = glam::Vec3::new(r, g, halves(base[column as usize][1])[0]);
        assert!(
            (found - wanted).abs().max_element() < 1e-3 * (1.0 + wanted.max_element()),
            "column {column}: {found} {wanted}"
        );
    }
    println!("brightest ambient 2^{brightest:.2}, largest difference of logarithms {worst:.4}");
    assert_eq!(on_guard > 0.1, multiple == MultipleModel::Transport, "{on_guard}");
    assert!(brightest > -6.0, "nothing is lit by the lights that are summed");
}
