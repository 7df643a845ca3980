//! `undercoat_light`, and the lookup of light in its lattice, against separate marches.

use crate::common::gpu;
use crate::common::lit::Lit;
use crate::common::marched::Marched;
use crate::common::worlds::ball;
use glam::Vec3;
use pelage_core::scene::FurLayers;
use pelage_fur::random::hash2;
use pelage_fur::undercoat::{color, scatter};
use pelage_fur::view::sample_ray;
use pelage_render::twin::resolve::Kind;
use pelage_render::twin::undercoat_light::Attenuator;
use pelage_render::twin::undercoat_march::{first_phase, look_up, steps};

/// Transmittances at the nodes against fine marches through the medium; returns mean and mean
/// absolute difference.
fn node_errors(factor: f32) -> Option<(f64, f64)> {
    let lit = Lit::new(gpu::open()?, ball(|_| ()));
    let fur = lit.fixture.fur;
    let guard: Vec<f32> = lit.guard.iter().map(|g| g * factor).collect();
    let medium =
        Attenuator { fur: &fur, undercoat: lit.undercoat(), densities: &lit.densities, guard: &guard };
    let light = lit.lattice();
    let (mut sum, mut absolute, mut count) = (0f64, 0f64, 0);
    for column in (0..fur.lattice.columns).filter(|c| hash2(*c, 1).is_multiple_of(8)) {
        for level in 0..=fur.lattice.levels {
            let place = lit.place(column, level);
            let x = place.point(place.t, place.lambda);
            for j in 0..fur.lights.count {
                let w = Vec3::from(lit.fixture.packed.lights[j as usize].direction);
                // Where the skin blocks the light, the lookup is more exact; the ball is convex, so
                // that its shell is never entered twice.
                let wanted = medium.optical_depth(&place, x, w, fur.undercoat.light_step / 6.0);
                let d = f64::from(
                    (-light.tau(column * (fur.lattice.levels + 1) + level, j)).exp() - (-wanted).exp(),
                );
                sum += d;
                absolute += d.abs();
                count += 1;
            }
        }
    }
    assert!(count > 1000, "{count}");
    println!(
        "transmittance at {count} nodes: mean difference {:+.5}, mean absolute {:.5}",
        sum / f64::from(count),
        absolute / f64::from(count)
    );
    Some((sum / f64::from(count), absolute / f64::from(count)))
}

#[test]
fn nodes_agree_with_marches_through_the_medium() {
    let Some((mean, absolute)) = node_errors(1.0) else { return };
    assert!(mean.abs() < 0.01 && absolute < 0.03, "{mean} {absolute}");
    let Some((wrong, _)) = node_errors(2.0) else { return };
    assert!(wrong - mean > 0.005, "twice the guard hairs make no difference: {wrong}");
}

/// The image of the undercoat with a nested march, from each step of the view ray to each light,
/// against the lookup.
#[test]
fn look_up_stands_for_the_nested_march() {
    let Some(gpu) = gpu::open() else { return };
    let m = Marched::new(gpu, ball(|s| s.render.fur = FurLayers::Implicit), [48, 32], [0, 0], [48, 32]);
    let fur = m.fixture.fur;
    let densities = vec![1.0; fur.lattice.columns as usize];
    let guard = vec![0.0; (fur.lattice.columns * (fur.lattice.levels + 1)) as usize];
    let inputs = m.inputs();
    let medium = Attenuator { fur: &fur, undercoat: inputs.undercoat, densities: &densities, guard: &guard };
    let luminance = |c: Vec3| f64::from(c.dot(Vec3::new(0.2126, 0.7152, 0.0722)));
    let (mut looked_up, mut nested, mut squares, mut count) = (0f64, 0f64, 0f64, 0);
    let nodes = m.nodes();
    for (i, xy) in m.places() {
        let Some(entry) = nodes[i].iter().find(|n| n.kind() == Kind::Entry) else { continue };
        let ray = sample_ray(&m.tile.frame, xy);
        let view = -ray.normalize();
        let (steps, _) = steps(&inputs, ray, entry.id(), entry.z, first_phase(&m.tile.frame, xy));
        let (mut through, mut a, mut b) = (1f32, Vec3::ZERO, Vec3::ZERO);
        for s in steps.iter().filter(|s| s.sigma > 0.0) {
            let rest = (-s.sigma * (s.z_end - s.z)).exp();
            let x = s.place.point(s.place.t, s.place.lambda);
            let albedo = look_up(&inputs, &s.place).albedo;
            let tangent = inputs.undercoat.at(&s.place).tangent;
            let mut exact = Vec3::ZERO;
            for light in &m.fixture.packed.lights[..fur.lights.count as usize] {
                let l = Vec3::from(light.direction);
                let tau = medium.optical_depth(&s.place, x, l, fur.undercoat.light_step / 4.0);
                let seen = (-tau * (1.0 - fur.undercoat.forward_scattering * albedo)).exp();
                exact += Vec3::from(light.irradiance)
                    * seen
                    * scatter(inputs.undercoat_fibre, tangent, l, view, albedo)
                    * color(inputs.undercoat_fibre, albedo);
            }
            a += through * (1.0 - rest) * s.radiance;
            b += through * (1.0 - rest) * exact;
            through *= rest;
            if through < 0.005 {
                break;
            }
        }
        looked_up += luminance(a);
        nested += luminance(b);
        squares += (luminance(a) - luminance(b)).powi(2);
        count += 1;
    }
    let n = f64::from(count);
    let (ratio, rmse, mean) = (looked_up / nested, (squares / n).sqrt(), nested / n);
    println!(
        "{count} rays: mean luminance {mean:.5} by nested marches, look-up {ratio:.4} of it, RMSE {rmse:.5} ({:.1} %)",
        100.0 * rmse / mean
    );
    assert!(count > 300 && mean > 0.005);
    assert!((ratio - 1.0).abs() < 0.06 && rmse < 0.12 * mean, "{ratio} {rmse}");
}
