//! Light transport among traced hairs: lossless hairs in a uniform sky, analytic radiance and
//! coverage, shadows, sampling strategies.

use crate::common::hairs::*;
use glam::{Vec3, Vec4};
use pelage_core::film::Film;
use pelage_core::light::environment::Panorama;
use pelage_core::scene::{DirectionalLight, Scene};
use pelage_fur::Layer;
use pelage_pathtrace::light::Sky;
use pelage_pathtrace::strands::Strands;
use pelage_pathtrace::{Accumulator, Integrator, LightModel, Strategy, Tracer};

const WHITE: Vec3 = Vec3::ONE;

/// A thick tuft of leaning, tapered hairs in front of a camera above it.
fn tuft(color: Vec3) -> Strands {
    strands(Layer::Undercoat, 6, coat(900, 0.8, 0.6, 0.008, 0.4, 6, 3), color)
}

fn tuft_camera(scene: &mut Scene) {
    scene.camera.eye = [1.0, 5.0, 3.0];
    scene.camera.target = [0.0, 0.25, 0.0];
    scene.camera.fov = 6.0;
}

/// Least and largest radiance over alpha of pixels that hairs cover, and their mean.
fn over_alpha(film: &Film) -> [f64; 3] {
    let (radiance, alpha) = (film.plane("G").unwrap(), film.plane("A").unwrap());
    let covered: Vec<f64> =
        radiance.iter().zip(alpha).filter(|(_, a)| **a > 0.9).map(|(r, a)| f64::from(r / a)).collect();
    assert!(covered.len() > 100, "only {} pixels are covered", covered.len());
    let fold = |f: fn(f64, f64) -> f64| covered.iter().copied().reduce(f).unwrap();
    [fold(f64::min), fold(f64::max), covered.iter().sum::<f64>() / covered.len() as f64]
}

#[test]
fn white_hairs_in_an_even_sky_vanish() {
    let world = empty_world(|s| {
        s.environment = Some(sky());
        tuft_camera(s);
    });
    let of = |color: Vec3| {
        over_alpha(&trace(&world, vec![tuft(color)], &options(Integrator::Path, LightModel::Map, 64)))
    };
    let [low, high, mean] = of(WHITE);
    println!("white: {low:.4} to {high:.4}, mean {mean:.5}");
    assert!((mean - 1.0).abs() < 0.004, "mean {mean}");
    assert!(low > 0.7 && high < 1.3, "{low} {high}");
    let [_, _, grey] = of(0.9 * WHITE);
    println!("tint 0.9: mean {grey:.5}");
    assert!(grey < 0.85, "a tint of 0.9 is not noticed: {grey}");
}

#[test]
fn one_hair_shines_and_covers_as_computed() {
    // A level hair of 2 cm, 0.05 cm thick, across the view; light from the camera's side, 60
    // degrees off the hair's normal plane.
    let (radius, length) = (0.05, 2.0);
    let elevation = 60f32.to_radians();
    let world = empty_world(|s| {
        s.camera.fov = 20.0;
        s.camera.eye = [0.0, 0.0, 10.0];
        s.lights = vec![DirectionalLight {
            direction: [elevation.sin(), 0.0, elevation.cos()],
            irradiance: [3.0, 2.0, 1.0],
        }];
    });
    let points = straight(Vec3::new(-0.5 * length, 0.0, 0.0), Vec3::new(0.5 * length, 0.0, 0.0), radius, 4);
    let hair = strands(Layer::Guard, 4, points, Vec3::new(0.5, 1.0, 0.25));
    let film = trace(&world, vec![hair], &options(Integrator::Single, LightModel::Scene, 4096));
    // The hair seen from its middle: the silhouettes are on the part of its girth nearer to the
    // camera.
    let extent = 10.0 * 10f64.to_radians().tan();
    let r = f64::from(radius);
    let half_height = r / (100.0 - r * r).sqrt() * 10.0;
    // Its ends bulge towards the camera, by π/4 of the radius on average.
    let ends = f64::from(length) * 0.5 * (1.0 + 0.25 * std::f64::consts::PI * r / 10.0);
    let expected = (2.0 * half_height) * (2.0 * ends) / (2.0 * extent).powi(2);
    let alpha = mean(&film, "A");
    println!("coverage {alpha:.6}, expected {expected:.6}");
    assert!((alpha / expected - 1.0).abs() < 0.001, "{alpha} {expected}");
    // Albedo / π² times cos θ_i times the irradiance.
    let pi = std::f64::consts::PI;
    for (name, wanted) in [("R", 0.5 * 3.0), ("G", 2.0), ("B", 0.25)] {
        let radiance = mean(&film, name) / alpha;
        let wanted = wanted / (pi * pi) * 0.5;
        assert!((radiance / wanted - 1.0).abs() < 1e-3, "{name}: {radiance} is not {wanted}");
    }
    assert!((mean(&film, "guard.R") - mean(&film, "R")).abs() < 1e-6);
    assert_eq!(mean(&film, "undercoat.R"), 0.0);
    // Colour and direction of the hair, and the normal of its ribbon, almost along the view.
    for (name, wanted) in
        [("Albedo.R", 0.5), ("Albedo.G", 1.0), ("Albedo.B", 0.25), ("Tangent.X", 1.0), ("N.Z", 1.0)]
    {
        assert!((mean(&film, name) / alpha - wanted).abs() < 2e-3, "{name}");
    }
}

/// A square hair of length 1 under a light from above, with or without a hair over its left half.
fn shadowed(blocker: bool, opacity: Option<f32>) -> f64 {
    let world = empty_world(|s| {
        s.camera.fov = 3.0;
        s.lights = vec![DirectionalLight { direction: [0.0, 1.0, 0.0], irradiance: [1.0; 3] }];
    });
    let mut points = straight(Vec3::new(-0.2, 0.0, 0.0), Vec3::new(0.2, 0.0, 0.0), 0.02, 2);
    if blocker {
        points.extend(straight(Vec3::new(-0.5, 5.0, 0.0), Vec3::new(0.0, 5.0, 0.0), 0.1, 2));
    }
    let mut hairs = strands(Layer::Guard, 2, points, WHITE);
    if let Some(opacity) = opacity {
        hairs.opacity = vec![opacity; 3];
    }
    let film = trace(&world, vec![hairs], &options(Integrator::Single, LightModel::Scene, 1024));
    mean(&film, "G") / mean(&film, "A")
}

#[test]
fn hairs_shadow_each_other_as_far_as_they_are_opaque() {
    let lit = 1.0 / std::f64::consts::PI.powi(2);
    assert!((shadowed(false, None) / lit - 1.0).abs() < 1e-3);
    assert!((shadowed(true, None) / lit - 0.5).abs() < 0.01, "half of it lies in shadow");
    let through = shadowed(true, Some(0.4)) / lit;
    assert!((through - 0.8).abs() < 0.02, "a hair of opacity 0.4 lets 0.6 through: {through}");
}

#[test]
fn skin_is_lambertian_and_shadowed() {
    let world = empty_world(|s| {
        s.mesh.scale = Some(1.0);
        s.mesh.translate = [0.0; 3];
        s.camera.eye = [0.0, 10.0, 0.0];
        s.camera.up = [0.0, 0.0, -1.0];
        s.camera.fov = 20.0;
        s.base.color = [0.5, 0.25, 1.0].into();
        s.lights = vec![DirectionalLight { direction: [0.0, 1.0, 1.0], irradiance: [2.0; 3] }];
    });
    let film = trace(&world, vec![], &options(Integrator::Single, LightModel::Scene, 16));
    for (name, color) in [("R", 0.5), ("G", 0.25), ("B", 1.0)] {
        let wanted = color * 2.0 * 0.5f64.sqrt() / std::f64::consts::PI;
        assert!((mean(&film, name) / wanted - 1.0).abs() < 1e-4, "{name}");
    }
    assert!((mean(&film, "A") - 1.0).abs() < 1e-6 && (mean(&film, "N.Y") - 1.0).abs() < 1e-5);
    assert!((mean(&film, "depth.Z") - 10.0).abs() < 1e-3);
    for (name, wanted) in [("Albedo.R", 0.5), ("Albedo.G", 0.25), ("Albedo.B", 1.0), ("Tangent.Y", 0.0)] {
        assert!((mean(&film, name) - wanted).abs() < 1e-4, "{name}");
    }
    // A hair over the skin, seen from above, throws its shadow aside: twice its width is dark or
    // hair.
    let points = straight(Vec3::new(-9.0, 0.5, 0.0), Vec3::new(9.0, 0.5, 0.0), 0.05, 2);
    let dark = trace(
        &world,
        vec![strands(Layer::Guard, 2, points, Vec3::ZERO)],
        &options(Integrator::Single, LightModel::Scene, 64),
    );
    let lost = 1.0 - mean(&dark, "G") / mean(&film, "G");
    let extent = 2.0 * 10.0 * 10f64.to_radians().tan();
    let wanted = (0.1 * 10.0 / 9.5 + 0.1 * 2f64.sqrt()) / extent;
    assert!((lost / wanted - 1.0).abs() < 0.02, "{lost} is not {wanted}");
}

/// Mean radiance of a tuft under a map with a small sun, with each of the three strategies for
/// sampling the sky.
fn by_strategy(strategy: Strategy, samples: u32) -> f64 {
    let world = empty_world(|s| {
        s.environment = Some(sky());
        tuft_camera(s);
    });
    let (width, height) = (64, 32);
    let texels = (0..width * height)
        .map(|i| match (i % width, i / width) {
            (20..24, 8..11) => [40.0, 36.0, 30.0],
            (_, y) if y < 16 => [0.4, 0.5, 0.7],
            _ => [0.1, 0.08, 0.05],
        })
        .collect();
    let options = options(Integrator::Path, LightModel::Map, samples);
    let mut tracer = Tracer::new(&world, vec![(tuft(0.8 * WHITE), diffuse())], &options).unwrap();
    tracer.lights.sky = Sky::of(Panorama { width, height, texels }, 20.0, WHITE);
    tracer.strategy = strategy;
    let mut means = Accumulator::new(24, 24);
    tracer.add(&mut means, samples, None).unwrap();
    mean(&means.film(), "G")
}

#[test]
fn all_sampling_strategies_have_the_same_mean() {
    let both = by_strategy(Strategy::Both, 256);
    for (strategy, samples, tolerance) in [(Strategy::Light, 256, 0.005), (Strategy::Scattering, 1024, 0.01)]
    {
        let found = by_strategy(strategy, samples);
        println!("{strategy:?}: {found:.6}, both {both:.6}");
        assert!((found / both - 1.0).abs() < tolerance, "{strategy:?}: {found} is not {both}");
    }
}

/// Transmittance of a slab of random upright hairs seen at `degrees` from its normal, by coverage,
/// and Beer and Lambert's for an optical depth of 1: n (d L tan θ + π r²), the sides and the ends.
fn transmittance(degrees: f32) -> (f64, f64) {
    let (radius, height) = (0.001f32, 0.1f32);
    let (sin, cos) = degrees.to_radians().sin_cos();
    let area = 2.0 * radius * height * sin / cos + std::f32::consts::PI * radius * radius;
    let world = empty_world(|s| {
        // 2 x 2 cm across the view.
        s.camera.fov = 2.0 * 0.01f32.atan().to_degrees();
        s.camera.eye = [100.0 * sin, 0.0, 100.0 * cos];
        s.film.width = 256;
        s.film.height = 256;
    });
    let half = [1.05 / cos + height * (sin / cos), 1.05];
    let count = (4.0 * half[0] * half[1] / area) as u32;
    let mut points: Vec<Vec4> = Vec::new();
    for i in 0..count {
        let r = |k: u32| pelage_fur::random::random(pelage_fur::random::hash2(41, i), k);
        let (x, y) = ((2.0 * r(0) - 1.0) * half[0], (2.0 * r(1) - 1.0) * half[1]);
        points.extend(straight(Vec3::new(x, y, -0.5 * height), Vec3::new(x, y, 0.5 * height), radius, 2));
    }
    let hairs = strands(Layer::Undercoat, 2, points, WHITE);
    let film = trace(&world, vec![hairs], &options(Integrator::Single, LightModel::Scene, 4));
    (1.0 - mean(&film, "A"), (-1f64).exp())
}

#[test]
fn random_parallel_hairs_follow_beer_and_lambert() {
    for degrees in [10.0, 20.0, 45.0, 60.0, 80.0] {
        let (found, wanted) = transmittance(degrees);
        println!("{degrees} degrees: {found:.4}, Beer and Lambert {wanted:.4}");
        assert!((found / wanted - 1.0).abs() < 0.02, "{degrees} degrees: {found} is not {wanted}");
        // Hairs that are 5 % thicker would be detected.
        assert!((found / (-1.05f64).exp() - 1.0).abs() > 0.02);
    }
}
