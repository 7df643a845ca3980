//! `undercoat_march` against its CPU twin: the fragments of every sample.

use crate::common::gpu;
use crate::common::marched::Marched;
use crate::common::worlds::world;
use pelage_core::World;
use pelage_core::scene::{Blend, FibreModel, FurLayers, Scene, Shape, Storage};
use pelage_fur::view::sample_ray;
use pelage_render::twin::resolve::Kind;
use pelage_render::twin::undercoat_march::{first_phase, fragments, steps};

/// A torus: rays enter its shell twice, graze it, or start within its hole.
fn torus(edit: impl FnOnce(&mut Scene)) -> World {
    world(|s| {
        s.mesh.shape = Some(Shape::Torus);
        s.mesh.scale = Some(0.2);
        s.camera.eye = [0.0, 1.6, 6.0];
        s.camera.fov = 26.0;
        s.render.fur = FurLayers::Implicit;
        edit(s);
    })
}

/// Compares lists; returns the part of the samples with an undercoat in which they agree.
fn agreement(world: World) -> (f64, usize) {
    let Some(gpu) = gpu::open() else { return (1.0, 1000) };
    let m = Marched::new(gpu, world, [96, 64], [0, 0], [96, 64]);
    let entries = m.nodes();
    m.march();
    let (made, bases) = (m.nodes(), m.bases());
    let inputs = m.inputs();
    let (mut seen, mut good, mut worst) = (0, 0, 0f32);
    for (i, xy) in m.places() {
        let into: Vec<(f32, u32)> =
            entries[i].iter().filter(|n| n.kind() == Kind::Entry).map(|n| (n.z, n.id())).collect();
        let z_base = bases[i].map_or(f32::INFINITY, |b| b.z);
        let ray = sample_ray(&m.tile.frame, xy);
        let wanted = fragments(&inputs, ray, first_phase(&m.tile.frame, xy), &into, z_base);
        let found: Vec<_> = made[i].iter().filter(|n| n.kind() == Kind::Volume).collect();
        if into.is_empty() {
            assert!(found.is_empty(), "{xy:?}: fragments without an entry");
            continue;
        }
        seen += 1;
        // A step at the border of a subelement may read its neighbour: then the sample's opacity
        // still agrees on the whole.
        let same = found.len() == wanted.len()
            && found.iter().zip(&wanted).all(|(a, b)| {
                worst = worst.max((a.color - b.color).abs().max_element().min(0.01));
                (a.z - b.z).abs() < 2e-3 && (a.color - b.color).abs().max_element() < 2e-3
            });
        good += usize::from(same);
    }
    println!("{good} of {seen} samples agree; largest difference of those that do is below {worst:.5}");
    (good as f64 / seen as f64, seen)
}

#[test]
fn shell_fragments_agree() {
    let (part, seen) = agreement(torus(|s| s.render.blend = Blend::Simplified));
    assert!(seen > 900 && part > 0.99, "{part} of {seen}");
}

#[test]
fn virtual_fragments_agree() {
    let (part, seen) = agreement(torus(|s| {
        s.render.blend = Blend::Virtual;
        s.render.virtual_fragments = 7;
    }));
    assert!(seen > 900 && part > 0.99, "{part} of {seen}");
}

#[test]
fn fragments_of_evaluated_densities_agree() {
    let (part, seen) = agreement(torus(|s| {
        s.render.blend = Blend::Simplified;
        s.undercoat.storage = Storage::Evaluated;
    }));
    // The twin's noise is in double precision.
    assert!(seen > 900 && part > 0.99, "{part} of {seen}");
}

#[test]
fn fragments_of_other_models_agree() {
    for model in [FibreModel::Sadeghi, FibreModel::Chiang, FibreModel::Medulla] {
        let (part, seen) = agreement(torus(|s| {
            s.render.blend = Blend::Simplified;
            s.undercoat.fibre.model = Some(model);
        }));
        assert!(seen > 900 && part > 0.99, "{model:?}: {part} of {seen}");
    }
}

#[test]
fn another_seed_does_not_agree() {
    let Some(gpu) = gpu::open() else { return };
    let m = Marched::new(gpu, torus(|s| s.render.blend = Blend::Simplified), [96, 64], [0, 0], [96, 64]);
    let entries = m.nodes();
    m.march();
    let made = m.nodes();
    let inputs = m.inputs();
    let mut frame = m.tile.frame;
    frame.seed += 1; // another phase
    let differing = m.places().filter(|(i, xy)| {
        let Some(entry) = entries[*i].iter().find(|n| n.kind() == Kind::Entry) else { return false };
        let wanted = fragments(
            &inputs,
            sample_ray(&frame, *xy),
            first_phase(&frame, *xy),
            &[(entry.z, entry.id())],
            1e30,
        );
        let found = made[*i].iter().find(|n| n.kind() == Kind::Volume);
        found.zip(wanted.first()).is_some_and(|(a, b)| (a.color - b.color).abs().max_element() > 2e-3)
    });
    assert!(differing.count() > 100, "the comparison does not notice another phase");
}

/// No ray is lost, and the medium of a ray ends where it leaves the shell.
#[test]
fn steps_join_and_stay_in_the_shell() {
    let Some(gpu) = gpu::open() else { return };
    let m = Marched::new(gpu, torus(|_| ()), [96, 64], [0, 0], [96, 64]);
    let (inputs, nodes) = (m.inputs(), m.nodes());
    let mut count = 0;
    for (i, xy) in m.places() {
        for entry in nodes[i].iter().filter(|n| n.kind() == Kind::Entry) {
            let ray = sample_ray(&m.tile.frame, xy);
            let (steps, lost) = steps(&inputs, ray, entry.id(), entry.z, first_phase(&m.tile.frame, xy));
            assert!(!lost, "{xy:?}: lost");
            assert!(steps.first().is_none_or(|s| s.z == entry.z));
            for pair in steps.windows(2) {
                assert_eq!(pair[0].z_end, pair[1].z, "{xy:?}: a gap");
            }
            for s in &steps {
                assert!(s.z_end > s.z && s.sigma >= 0.0 && s.radiance.is_finite(), "{xy:?}: {s:?}");
                assert!((-1e-3..=1.02).contains(&s.place.t), "{xy:?}: {s:?}");
                count += 1;
            }
        }
    }
    assert!(count > 5000, "{count}");
}
