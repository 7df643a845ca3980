//! The adding method against Monte Carlo in the same medium.

use crate::bins::{BINS, HALF, centre, widths};
use crate::coat::{Medium, orientations};
use crate::operators::Operators;
use crate::slab::{Layer, Solution, solve};
use glam::Vec3;
use pelage_fur::fibre::{Chiang, Fibre, Hit, KajiyaKay};
use pelage_fur::random::{hash2, random};
use std::f64::consts::PI;

/// Reflectance of the skin.
const SKIN: f64 = 0.3;

fn solved(m: &Medium, albedo: f32, light: f64) -> (Solution, Layer) {
    // Operators of just this albedo: interpolation between those of a table has errors of its own.
    let op = Operators::new(&m.kinds[0].fibre, &m.kinds[0].levels[0], albedo, m.seed);
    let layer = |thickness: f64| {
        let mut layer = Layer::empty(thickness);
        layer.add(&op, 1.0);
        layer
    };
    let layers = m.thicknesses().into_iter().map(layer).collect();
    (solve(layers, SKIN, &[light]), layer(1.0))
}

fn diffuse() -> Fibre {
    Fibre::KajiyaKay(KajiyaKay::new(1.0, 0.0, 1.0))
}

fn chiang() -> Fibre {
    Fibre::Chiang(Chiang::new([0.3, 0.3], 2f32.to_radians(), 1.55, None))
}

fn medium(fibre: Fibre, depth: f64) -> Medium {
    Medium::even(fibre, orientations(0.2, 0.4, 1.0, 0.6), depth, [SKIN; 3], 7)
}

fn toward(degrees: f32) -> Vec3 {
    Vec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos())
}

/// The adding method knows inclinations only: azimuths of the light are averaged.
fn around_normal(seed: u32, light: Vec3) -> Vec3 {
    glam::Quat::from_rotation_z(std::f32::consts::TAU * random(seed, 30)) * light
}

/// Random walks from the view: radiance sent to `view` for an irradiance of 1 from `light`, all
/// orders of scattering.
fn monte_carlo(m: &Medium, albedo: f32, light: Vec3, view: Vec3, walks: u32) -> f64 {
    let (fibre, depth) = (&m.kinds[0].fibre, m.depth());
    let orientations = &m.kinds[0].levels[0].hairs;
    let hairs: Vec<(Vec3, f32)> = orientations.iter().map(|s| (s.tangent, s.projected)).collect();
    let turned = |seed: u32, k: u32| {
        let pick = (random(seed, k) * hairs.len() as f32) as usize;
        let turn = glam::Quat::from_rotation_z(std::f32::consts::TAU * random(seed, k + 1));
        (turn * hairs[pick].0, hairs[pick].1)
    };
    let most = hairs.iter().map(|h| h.1).fold(0.0, f32::max);
    // Mean extinction by cosine to the normal.
    let table: Vec<f64> = (0..=64u32)
        .map(|i| {
            let w = toward((f64::from(i) / 64.0 * 90.0) as f32);
            let of = |k: u32| {
                let (t, weight) = turned(hash2(i, k), 0);
                f64::from(weight * (1.0 - t.dot(w).powi(2)).max(0.0).sqrt())
            };
            (0..4000).map(of).sum::<f64>() / 4000.0
        })
        .collect();
    let extinction = |w: Vec3| {
        let x = f64::from(w.z.abs().min(1.0).acos().to_degrees()) / 90.0 * 64.0;
        let k = (x as usize).min(63);
        table[k] + (table[k + 1] - table[k]) * (x - k as f64)
    };
    let slant = extinction(light) / f64::from(light.z);
    let mut sum = 0.0;
    for walk in 0..walks {
        let light = around_normal(hash2(98, walk), light);
        let (mut w, mut at, mut weight) = (-view, 0.0f64, 1.0f64);
        for step in 0..2000u32 {
            let seed = hash2(hash2(99, walk), step);
            let free = -(1.0 - f64::from(random(seed, 0))).ln() / extinction(w);
            at -= f64::from(w.z) * free;
            if at <= 0.0 {
                break;
            }
            if at >= depth {
                at = depth - 1e-9;
                sum += weight * SKIN / PI * f64::from(light.z) * (-slant * depth).exp();
                weight *= SKIN;
                let d = pelage_fur::random::random_direction(seed, 1) + Vec3::Z;
                w = d.normalize_or(Vec3::Z);
            } else {
                // A hair drawn in proportion to its projected area.
                let mut k = 10;
                let (tangent, projected) = loop {
                    let (t, of) = turned(seed, k);
                    let projected = of * (1.0 - t.dot(w).powi(2)).max(0.0).sqrt();
                    if random(seed, k + 2) * most < projected {
                        break (t, projected);
                    }
                    k += 3;
                };
                assert!(projected > 0.0);
                let (y, z) = tangent.any_orthonormal_pair();
                let local = |v: Vec3| Vec3::new(tangent.dot(v), y.dot(v), z.dot(v));
                let h = 2.0 * random(seed, 4) - 1.0;
                let hit = Hit { tint: Vec3::splat(albedo), glint_angle: 0.65, h };
                let (wo, wi) = (local(-w), local(light));
                let cos = (1.0 - wi.x * wi.x).max(0.0).sqrt();
                sum += weight * f64::from(fibre.evaluate(&hit, wi, wo).x * cos) * (-slant * at).exp();
                let Some(s) = fibre.sample(&hit, wo, [5, 6, 7, 8].map(|k| random(seed, k))) else { break };
                weight *= f64::from(s.weight.x);
                w = tangent * s.direction.x + y * s.direction.y + z * s.direction.z;
            }
            if weight < 0.1 {
                if random(seed, 9) > 0.5 {
                    break;
                }
                weight *= 2.0;
            }
        }
    }
    sum / f64::from(walks)
}

/// The same by the adding method: light scattered once is evaluated as in the walks, the rest from
/// the solution's bins.
fn by_adding(m: &Medium, albedo: f32, light: Vec3, view: Vec3) -> f64 {
    let (l, v) = (f64::from(light.z), f64::from(view.z));
    let (solution, op) = solved(m, albedo, l);
    let (fibre, orientations, depth) = (&m.kinds[0].fibre, &m.kinds[0].levels[0].hairs, m.depth());
    let steps = 4000;
    let dz = depth / f64::from(steps);
    let once = (0..20_000u32)
        .map(|k| {
            let seed = hash2(5, k);
            let turn = glam::Quat::from_rotation_z(std::f32::consts::TAU * random(seed, 0));
            let hair = orientations[(random(seed, 1) * orientations.len() as f32) as usize];
            let t = turn * hair.tangent;
            let (y, z) = t.any_orthonormal_pair();
            let local = |v: Vec3| Vec3::new(t.dot(v), y.dot(v), z.dot(v));
            let (wi, wo) = (local(around_normal(seed, light)), local(view));
            let hit = Hit { tint: Vec3::splat(albedo), glint_angle: 0.65, h: 2.0 * random(seed, 2) - 1.0 };
            let sines = ((1.0 - wi.x * wi.x) * (1.0 - wo.x * wo.x)).max(0.0).sqrt();
            f64::from(fibre.evaluate(&hit, wi, wo).x * sines * hair.projected)
        })
        .sum::<f64>()
        / 20_000.0;
    let (sl, sv) = (op.extinction_at(l) / l, op.extinction_at(v) / v);
    let mut sum = 0.0;
    for i in 0..steps {
        let at = (f64::from(i) + 0.5) * dz;
        let often: f64 = (0..BINS).map(|bin| op.kernel_at(v, bin) * solution.radiance(at, 0, bin)).sum();
        sum += (-sv * at).exp() / v * (often + once * (-sl * at).exp()) * dz;
    }
    // The skin, seen through the coat, by the irradiance on it.
    let falling: f64 = (HALF..BINS)
        .map(|bin| 2.0 * PI * widths()[bin] * centre(bin) * solution.radiance(depth, 0, bin))
        .sum();
    sum + SKIN / PI * (falling + l * (-sl * depth).exp()) * (-sv * depth).exp()
}

fn agrees(fibre: fn() -> Fibre, albedo: f32, depth: f64, bound: f64) {
    for (light, view) in [(20.0, 50.0), (70.0, 30.0)] {
        let m = medium(fibre(), depth);
        let wanted = monte_carlo(&m, albedo, toward(light), toward(view), 20_000);
        let found = by_adding(&m, albedo, toward(light), toward(view));
        println!(
            "{:?}, albedo {albedo}, depth {depth}, light {light}, view {view}: {found:.4}, walks {wanted:.4}, ratio {:.3}",
            std::mem::discriminant(&m.kinds[0].fibre),
            found / wanted
        );
        assert!((found / wanted - 1.0).abs() < bound, "{found} {wanted}");
    }
}

#[test]
fn adding_agrees_with_monte_carlo_for_hairs_that_scatter_all_round() {
    for (albedo, depth) in [(0.5, 20.0), (0.9, 20.0), (0.9, 1.0)] {
        agrees(diffuse, albedo, depth, 0.06);
    }
    // The comparison notices hairs that are too bright.
    let m = medium(diffuse(), 20.0);
    let wanted = monte_carlo(&m, 0.5, toward(20.0), toward(50.0), 6000);
    assert!(by_adding(&m, 0.6, toward(20.0), toward(50.0)) > 1.1 * wanted);
}

#[test]
fn adding_agrees_with_monte_carlo_for_hairs_that_scatter_into_cones() {
    for (albedo, depth) in [(0.5, 20.0), (0.9, 20.0), (0.9, 1.0)] {
        agrees(chiang, albedo, depth, 0.1);
    }
}

#[test]
fn a_lossless_coat_on_a_white_skin_loses_nothing() {
    // All light that enters comes out again: the flux at the top is that of the light.
    let m = medium(diffuse(), 5.0);
    let light = 0.7;
    let operators = m.operators();
    let solution = solve(m.layers(&operators, 1.0, 0), 1.0, &[light]);
    let out: f64 =
        (0..HALF).map(|bin| -2.0 * PI * widths()[bin] * centre(bin) * solution.radiance(0.0, 0, bin)).sum();
    println!("out {out:.4}, in {light}");
    assert!((out / light - 1.0).abs() < 0.03, "{out}");
}
