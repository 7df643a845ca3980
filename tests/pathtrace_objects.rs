//! Objects in the path tracer: furnaces, analytic radiance and shadows, shadow catchers.

use crate::common::hairs::*;
use crate::common::{Folder, message, pelage};
use glam::{Vec3, Vec4};
use pelage_core::film::Film;
use pelage_core::light::environment::Panorama;
use pelage_core::scene::{
    Color, DirectionalLight, Environment, MeshSpec, ObjectMaterial, ObjectSpec, Scene, Shape,
};
use pelage_core::{Error, World};
use pelage_fur::Layer;
use pelage_fur::material::Material;
use pelage_fur::random::{hash2, random};
use pelage_pathtrace::light::Sky;
use pelage_pathtrace::strands::Strands;
use pelage_pathtrace::{self as pathtrace, Accumulator, Integrator, LightModel, Strategy, Tracer};
use std::f32::consts::{FRAC_1_SQRT_2, PI, TAU};
use std::path::Path;

const UP: Vec3 = Vec3::Y;

/// A shape as an object, `scale` times its usual size, around `at` (cm).
fn object(shape: Shape, scale: f32, at: [f32; 3], material: ObjectMaterial) -> ObjectSpec {
    let name = format!("{shape:?} at {at:?}");
    let mesh = MeshSpec { shape: Some(shape), scale: Some(scale), translate: at, ..MeshSpec::default() };
    ObjectSpec { name, mesh, material, ..ObjectSpec::default() }
}

/// A ball of `radius` cm, of more triangles than the shape has.
fn ball(radius: f32, at: [f32; 3], material: ObjectMaterial) -> ObjectSpec {
    object(Shape::Sphere, 0.2 * radius, at, material)
}

/// A dielectric of one grey.
fn dielectric(color: f32, roughness: f32) -> ObjectMaterial {
    ObjectMaterial { color: [color; 3].into(), roughness, ..ObjectMaterial::default() }
}

fn catcher(spec: ObjectSpec) -> ObjectSpec {
    ObjectSpec { shadow_catcher: true, ..spec }
}

fn light(direction: Vec3, irradiance: f32) -> DirectionalLight {
    DirectionalLight { direction: direction.into(), irradiance: [irradiance; 3] }
}

fn seen_from(scene: &mut Scene, eye: Vec3, target: Vec3, degrees: f32) {
    (scene.camera.eye, scene.camera.target, scene.camera.fov) = (eye.into(), target.into(), degrees);
    if (eye - target).normalize().dot(UP).abs() > 0.99 {
        scene.camera.up = [0.0, 0.0, -1.0];
    }
}

/// Mean of G over the pixels that are wholly covered, and their number.
fn covered(film: &Film) -> (f64, usize) {
    let (green, alpha) = (film.plane("G").unwrap(), film.plane("A").unwrap());
    let whole: Vec<f64> =
        green.iter().zip(alpha).filter(|(_, a)| **a > 0.9999).map(|(g, _)| f64::from(*g)).collect();
    (whole.iter().sum::<f64>() / whole.len().max(1) as f64, whole.len())
}

/// A ball of a white rough dielectric under an even sky of radiance 1 nearly vanishes, and so does
/// one that stands on a white ground, where most light comes by way of the other.
#[test]
fn white_objects_in_an_even_sky_nearly_vanish() {
    let of = |color: f32, ground: bool, integrator: Integrator| {
        let world = empty_world(|s| {
            s.environment = Some(sky());
            seen_from(s, Vec3::new(0.0, 2.0, 10.0), Vec3::new(0.0, -0.6, 0.0), 16.0);
            s.objects = vec![ball(1.0, [0.0; 3], dielectric(color, 1.0))];
            if ground {
                s.objects.push(object(Shape::Plane, 2.0, [0.0, -1.0, 0.0], dielectric(color, 1.0)));
            }
        });
        let (mean, count) = covered(&trace(&world, vec![], &options(integrator, LightModel::Map, 64)));
        assert!(count > 80, "only {count} pixels are covered");
        mean
    };
    let [alone, standing] = [false, true].map(|ground| of(1.0, ground, Integrator::Path));
    println!("white: alone {alone:.4}, on the ground {standing:.4}");
    // Light that is reflected more than once between microfacets is missing, most of it where the
    // ground is seen edge-on.
    assert!((0.95..1.003).contains(&alone), "{alone}");
    assert!((0.8..1.003).contains(&standing), "{standing}");
    let once = of(1.0, true, Integrator::Single);
    assert!(once < standing - 0.03, "{once}: no light comes by way of the other");
    let grey = of(0.9, false, Integrator::Path);
    assert!(grey < alone - 0.06, "a colour of 0.9 is not noticed: {grey}");
}

fn materials() -> [ObjectMaterial; 3] {
    let metal = ObjectMaterial { metallic: 1.0, ..dielectric(0.8, 0.5) };
    let coated = ObjectMaterial { clearcoat: 1.0, clearcoat_roughness: 0.4, ..dielectric(0.4, 0.6) };
    [dielectric(0.6, 0.4), metal, coated]
}

/// The mean radiance of a ball under a map with a small sun, by the three ways to sample the sky.
#[test]
fn all_sampling_strategies_have_the_same_mean_on_objects() {
    let (width, height) = (64, 32);
    let texels = (0..width * height)
        .map(|i| match (i % width, i / width) {
            (20..24, 8..11) => [40.0, 36.0, 30.0],
            (_, y) if y < 16 => [0.4, 0.5, 0.7],
            _ => [0.1, 0.08, 0.05],
        })
        .collect();
    let panorama = Panorama { width, height, texels };
    for (k, material) in materials().into_iter().enumerate() {
        let world = empty_world(|s| {
            s.environment = Some(sky());
            s.objects = vec![ball(1.0, [0.0; 3], material.clone())];
        });
        let of = |strategy: Strategy, samples: u32| {
            let options = options(Integrator::Path, LightModel::Map, samples);
            let mut tracer = Tracer::new(&world, vec![], &options).unwrap();
            tracer.lights.sky = Sky::of(panorama.clone(), 20.0, Vec3::ONE);
            tracer.strategy = strategy;
            let mut means = Accumulator::new(24, 24);
            tracer.add(&mut means, samples, None).unwrap();
            mean(&means.film(), "G")
        };
        let both = of(Strategy::Both, 128);
        for (strategy, samples, tolerance) in
            [(Strategy::Light, 1024, 0.01), (Strategy::Scattering, 1024, 0.015)]
        {
            let found = of(strategy, samples);
            println!("material {k}, {strategy:?}: {found:.6}, both {both:.6}");
            assert!((found / both - 1.0).abs() < tolerance, "{k}, {strategy:?}: {found} is not {both}");
        }
    }
}

/// Sum of (observed - expected)² / expected over 8 x 16 cells of the hemisphere for directions
/// drawn by `drawn`, against the density of `by`; cells with few are joined.
fn chi_square(drawn: &Material, by: &Material) -> (f64, usize) {
    const SAMPLES: u32 = 100_000;
    const FINE: u32 = 24;
    let (rows, columns) = (8, 16);
    let view = Vec3::new(0.6, 0.0, 0.8);
    let mut observed = vec![0f64; rows * columns];
    for i in 0..SAMPLES {
        let u = [1, 2, 3].map(|k| random(hash2(17, i), k));
        let Some((l, ..)) = drawn.sample(Vec3::Z, view, u) else { continue };
        let row = ((l.z * rows as f32) as usize).min(rows - 1);
        let column = ((l.y.atan2(l.x) / TAU).rem_euclid(1.0) * columns as f32) as usize % columns;
        observed[row * columns + column] += 1.0;
    }
    let cell = |i: usize| {
        let mut sum = 0f64;
        for k in 0..FINE * FINE {
            let at = [k / FINE, k % FINE].map(|j| (j as f32 + 0.5) / FINE as f32);
            let z = ((i / columns) as f32 + at[0]) / rows as f32;
            let (sin, cos) = (((i % columns) as f32 + at[1]) / columns as f32 * TAU).sin_cos();
            let r = (1.0 - z * z).sqrt();
            sum += f64::from(by.pdf(Vec3::Z, view, Vec3::new(r * cos, r * sin, z)));
        }
        sum / f64::from(FINE * FINE) * f64::from(TAU) / (rows * columns) as f64 * f64::from(SAMPLES)
    };
    let (mut chi, mut cells, mut few) = (0.0, 0, [0f64; 2]);
    for (i, observed) in observed.iter().enumerate() {
        let expected = cell(i);
        if expected < 20.0 {
            few = [few[0] + observed, few[1] + expected];
            continue;
        }
        chi += (observed - expected).powi(2) / expected;
        cells += 1;
    }
    (chi + (few[0] - few[1]).powi(2) / few[1].max(1.0), cells + 1)
}

#[test]
fn directions_are_drawn_with_the_density_that_weighs_them() {
    for of in materials() {
        let Color::Constant(color) = of.color else { panic!("a constant colour") };
        let material = Material {
            color: color.into(),
            roughness: of.roughness,
            metallic: of.metallic,
            clearcoat: of.clearcoat,
            clearcoat_roughness: of.clearcoat_roughness,
        };
        let (chi, cells) = chi_square(&material, &material);
        println!("chi² {chi:.0} of {cells} cells");
        let limit = cells as f64 + 5.0 * (2.0 * cells as f64).sqrt();
        assert!(chi < limit, "{material:?}: {chi} in {cells} cells");
        let rougher = Material { roughness: 1.5 * material.roughness, ..material };
        let (chi, _) = chi_square(&rougher, &material);
        assert!(chi > limit, "{material:?}: a rougher lobe is not noticed: {chi}");
    }
}

/// A level plane seen and lit at 45 degrees from opposite sides, by hand.
#[test]
fn a_plane_shines_as_computed() {
    let of = |material: ObjectMaterial, side: f32| {
        let world = empty_world(|s| {
            seen_from(s, Vec3::new(10.0, side * 10.0, 0.0), Vec3::ZERO, 0.5);
            s.lights = vec![light(Vec3::new(-1.0, side, 0.0), 2.0)];
            s.objects = vec![object(Shape::Plane, 1.0, [0.0; 3], material.clone())];
        });
        let film = trace(&world, vec![], &options(Integrator::Single, LightModel::Scene, 16));
        assert!((mean(&film, "A") - 1.0).abs() < 1e-6 && (mean(&film, "N.Y") - f64::from(side)).abs() < 1e-5);
        mean(&film, "G")
    };
    let cos = f64::from(FRAC_1_SQRT_2);
    // Schlick at 45 degrees, and at the half vector, which is the normal.
    let fresnel = 0.04 + 0.96 * (1.0 - cos).powi(5);
    let inside = (1.0 - fresnel).powi(2) / (1.0 - 0.04 - 0.96 / 21.0) / std::f64::consts::PI;
    for (color, roughness) in [(0.5f64, 1.0f64), (0.25, 0.5)] {
        let a2 = roughness.powi(4);
        let density = 1.0 / (std::f64::consts::PI * a2);
        let visible = 0.5 / (2.0 * cos * (cos * cos * (1.0 - a2) + a2).sqrt());
        let wanted = (color * inside + fresnel * density * visible) * 2.0 * cos;
        let material = dielectric(color as f32, roughness as f32);
        for side in [1.0, -1.0] {
            let found = of(material.clone(), side);
            println!("colour {color}, roughness {roughness}, side {side}: {found:.5}, by hand {wanted:.5}");
            assert!((found / wanted - 1.0).abs() < 5e-4, "{found} is not {wanted}");
        }
        let metal = ObjectMaterial { metallic: 1.0, ..material };
        let wanted = (color + (1.0 - color) * (1.0 - cos).powi(5)) * density * visible * 2.0 * cos;
        let found = of(metal, 1.0);
        assert!((found / wanted - 1.0).abs() < 5e-4, "a metal: {found} is not {wanted}");
    }
}

/// Pixel by pixel, a ball is as bright as its material says for its normal, also where light grazes
/// its triangles.
#[test]
fn a_coated_ball_is_as_bright_as_its_material_says() {
    let [.., coated] = materials();
    let spec = ObjectMaterial { roughness: 0.5, color: [0.4, 0.2, 0.1].into(), ..coated };
    let towards = Vec3::new(1.0, 0.7, 0.5).normalize();
    let world = empty_world(|s| {
        s.lights = vec![light(towards, 3.0)];
        seen_from(s, Vec3::new(0.0, 0.0, 60.0), Vec3::ZERO, 2.2);
        (s.film.width, s.film.height) = (64, 64);
        s.objects = vec![ball(1.0, [0.0; 3], spec.clone())];
    });
    let film = trace(&world, vec![], &options(Integrator::Single, LightModel::Scene, 16));
    let plane = |name: &str| film.plane(name).unwrap();
    let (mut bright, mut grazing) = (0, 0);
    for i in (0..plane("G").len()).filter(|i| plane("A")[*i] > 0.9999) {
        let n = Vec3::new(plane("N.X")[i], plane("N.Y")[i], plane("N.Z")[i]).normalize();
        let material = Material {
            color: Vec3::new(plane("Albedo.R")[i], plane("Albedo.G")[i], plane("Albedo.B")[i]),
            roughness: 0.5,
            metallic: 0.0,
            clearcoat: 1.0,
            clearcoat_roughness: spec.clearcoat_roughness,
        };
        assert!(material.color.distance(Vec3::new(0.4, 0.2, 0.1)) < 1e-4);
        let cosine = n.dot(towards);
        let view = (Vec3::new(0.0, 0.0, 60.0) - n).normalize();
        if n.dot(view) < 0.35 {
            continue;
        }
        let wanted = 3.0 * cosine.max(0.0) * material.evaluate(n, view, towards, 0.0);
        let found = Vec3::new(plane("R")[i], plane("G")[i], plane("B")[i]);
        if cosine > 0.3 {
            bright += 1;
            assert!((found / wanted - 1.0).abs().max_element() < 0.03, "{n}: {found} is not {wanted}");
        } else if cosine > 0.08 {
            grazing += 1;
            assert!((found / wanted - 1.0).abs().max_element() < 0.2, "{n}: {found} is not {wanted}");
        }
    }
    assert!(bright > 500 && grazing > 100, "{bright} {grazing}");
}

/// Share of the light on the ground that a ball 3 cm above it takes away, seen from above within 2
/// cm of the middle of the shadow: by radiance, or by alpha of a shadow catcher.
fn umbra(caught: bool) -> f64 {
    let world = empty_world(|s| {
        s.lights = vec![light(Vec3::new(1.0, 1.0, 0.0), 2.0)];
        // 4 x 4 cm of the ground.
        seen_from(
            s,
            Vec3::new(-3.0, 40.0, 0.0),
            Vec3::new(-3.0, 0.0, 0.0),
            2.0 * (0.05f32).atan().to_degrees(),
        );
        (s.film.width, s.film.height) = (96, 96);
        let ground = object(Shape::Plane, 2.0, [0.0; 3], dielectric(0.5, 1.0));
        s.objects = vec![ball(1.0, [0.0, 3.0, 0.0], dielectric(0.5, 1.0))];
        s.objects.push(if caught { catcher(ground) } else { ground });
    });
    let film = trace(&world, vec![], &options(Integrator::Single, LightModel::Scene, 4));
    if caught {
        assert_eq!([mean(&film, "R"), mean(&film, "Albedo.G")], [0.0; 2], "a shadow is black");
        return mean(&film, "A");
    }
    // A corner of the view is lit.
    1.0 - mean(&film, "G") / f64::from(film.plane("G").unwrap()[0])
}

#[test]
fn a_ball_throws_the_shadow_of_a_ball() {
    // An ellipse, √2 times as long as wide, in 4 x 4 cm.
    let wanted = std::f64::consts::PI * 2f64.sqrt() / 16.0;
    for caught in [false, true] {
        let found = umbra(caught);
        println!("caught {caught}: {found:.4}, expected {wanted:.4}");
        // Radiance varies a little over the view.
        assert!((found / wanted - 1.0).abs() < 0.02, "caught {caught}: {found} is not {wanted}");
    }
}

/// Upright random hairs 20 cm above the ground, whose optical depth for light at 45 degrees is
/// `depth`.
fn slab(depth: f32) -> Strands {
    let (radius, height) = (0.001f32, 0.1f32);
    let area = 2.0 * radius * height + PI * radius * radius;
    let half = 1.3;
    let count = (depth * 4.0 * half * half / area) as u32;
    let points: Vec<Vec4> = (0..count)
        .flat_map(|i| {
            let at = [0, 1].map(|k| (2.0 * random(hash2(41, i), k) - 1.0) * half);
            let root = Vec3::new(20.0 + at[0], 20.0, at[1]);
            straight(root, root + height * UP, radius, 2)
        })
        .collect();
    strands(Layer::Undercoat, 2, points, Vec3::ONE)
}

/// Share of the light that the hairs of an optical depth take from the ground.
fn fur_shadow(depth: f32, caught: bool) -> f64 {
    let world = empty_world(|s| {
        s.lights = vec![light(Vec3::new(1.0, 1.0, 0.0), 2.0)];
        // 2 x 2 cm of the ground; the hairs are out of view.
        seen_from(s, 50.0 * UP, Vec3::ZERO, 2.0 * 0.02f32.atan().to_degrees());
        (s.film.width, s.film.height) = (200, 200);
        let ground = object(Shape::Plane, 2.0, [0.0; 3], dielectric(0.5, 1.0));
        s.objects = vec![if caught { catcher(ground) } else { ground }];
    });
    let options = options(Integrator::Single, LightModel::Scene, 4);
    let film = trace(&world, vec![slab(depth)], &options);
    if caught {
        return mean(&film, "A");
    }
    1.0 - mean(&film, "G") / mean(&trace(&world, vec![], &options), "G")
}

#[test]
fn fur_lets_as_much_light_onto_objects_as_its_optical_depth_says() {
    for caught in [false, true] {
        let found = 1.0 - fur_shadow(1.0, caught);
        let wanted = (-1f64).exp();
        println!("caught {caught}: {found:.4}, expected {wanted:.4}");
        assert!((found / wanted - 1.0).abs() < 0.025, "caught {caught}: {found} is not {wanted}");
    }
    let more = 1.0 - fur_shadow(1.08, true);
    assert!((more / (-1f64).exp() - 1.0).abs() > 0.025, "8 % more hairs are not noticed: {more}");
}

/// Alpha of a shadow catcher straight below a ball, under a sky and a light that the ball blocks.
fn caught_below(tint: [f32; 3], irradiance: f32) -> f64 {
    let world = empty_world(|s| {
        s.environment = Some(Environment { tint, ..sky() });
        s.lights = vec![light(UP, irradiance)];
        seen_from(s, Vec3::new(0.0, 1.0, 3.0), Vec3::ZERO, 0.5);
        s.objects = vec![
            ball(1.0, [0.0, 2.5, 0.0], dielectric(0.8, 1.0)),
            catcher(object(Shape::Plane, 2.0, [0.0; 3], dielectric(0.5, 1.0))),
        ];
    });
    let film = trace(&world, vec![], &options(Integrator::Path, LightModel::Map, 128));
    assert_eq!(mean(&film, "G"), 0.0, "a shadow is black");
    mean(&film, "A")
}

#[test]
fn a_shadow_catcher_weighs_the_sky_and_the_lights() {
    // The ball takes up (radius / distance)² of the cosine-weighted sky.
    let of_sky = 0.16;
    let luminance = 0.2126 * 1.0 + 0.7152 * 0.5 + 0.0722 * 0.25;
    for (tint, sky, irradiance) in [([1.0; 3], 1.0, 0.0), ([1.0, 0.5, 0.25], luminance, 1.5)] {
        let sky = sky * std::f64::consts::PI;
        let wanted = (sky * of_sky + f64::from(irradiance)) / (sky + f64::from(irradiance));
        let found = caught_below(tint, irradiance);
        println!("tint {tint:?}, light {irradiance}: {found:.4}, expected {wanted:.4}");
        assert!((found - wanted).abs() < 0.006, "{found} is not {wanted}");
    }
}

/// A shadow catcher above the ground leaves the ground and its light as they are, wherever the
/// camera does not look through it.
#[test]
fn a_shadow_catcher_blocks_no_light() {
    let of = |between: Option<ObjectSpec>| {
        let world = empty_world(|s| {
            s.environment = Some(sky());
            s.lights = vec![light(UP, 2.0)];
            seen_from(s, Vec3::new(0.0, 1.0, 3.0), Vec3::ZERO, 5.0);
            s.objects = vec![object(Shape::Plane, 2.0, [0.0; 3], dielectric(0.7, 1.0))];
            s.objects.extend(between);
        });
        mean(&trace(&world, vec![], &options(Integrator::Path, LightModel::Map, 16)), "G")
    };
    let screen = || object(Shape::Plane, 2.0, [0.0, 1.5, 0.0], dielectric(0.7, 1.0));
    let free = of(None);
    assert!((of(Some(catcher(screen()))) / free - 1.0).abs() < 1e-6);
    assert!(of(Some(screen())) < 0.9 * free, "an ordinary surface blocks light");
}

/// Hairs hide objects and catchers, objects hide hairs, by distance; what is hidden adds nothing.
#[test]
fn hairs_and_objects_hide_each_other() {
    let of = |at: f32, caught: bool| {
        let world = empty_world(|s| {
            s.lights = vec![light(Vec3::Z, 3.0)];
            s.camera.fov = 2.0;
            let mut screen = object(Shape::Plane, 1.0, [0.0, 0.0, at], dielectric(0.5, 1.0));
            screen.mesh.rotate = [90.0, 0.0, 0.0];
            s.objects = vec![if caught { catcher(screen) } else { screen }];
        });
        let hair = straight(Vec3::new(-5.0, 0.0, 0.0), Vec3::new(5.0, 0.0, 0.0), 0.4, 1);
        let hairs = strands(Layer::Guard, 1, hair, Vec3::ONE);
        let film = trace(&world, vec![hairs], &options(Integrator::Single, LightModel::Scene, 4));
        ["guard.G", "base.G", "A"].map(|name| mean(&film, name))
    };
    for caught in [false, true] {
        let [guard, base, alpha] = of(-2.0, caught);
        assert!(guard > 0.1 && base == 0.0 && (alpha - 1.0).abs() < 1e-6, "behind: {guard} {base} {alpha}");
    }
    let [guard, base, alpha] = of(2.0, false);
    assert!(guard == 0.0 && base > 0.1 && (alpha - 1.0).abs() < 1e-6, "in front: {guard} {base} {alpha}");
    // The catcher is lit and hides the hair.
    assert_eq!(of(2.0, true), [0.0; 3]);
}

#[test]
fn vertex_colours_of_objects_are_interpolated() {
    let folder = Folder::new();
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
               property float red\nproperty float green\nproperty float blue\nelement face 1\n\
               property list uchar int vertex_indices\nend_header\n\
               -1 -1 0 1 0 0\n1 -1 0 0 1 0\n0 1 0 0 0 1\n3 0 1 2\n";
    folder.write("colours.ply", ply);
    let path = folder.write(
        "scene.toml",
        "[mesh]\nshape = 'plane'\nscale = 0.001\ntranslate = [0, -500, 0]\n\
         [camera]\neye = [0, 0, 10]\ntarget = [0, 0, 0]\nfov = 0.01\n[film]\nwidth = 8\nheight = 8\n\
         [[objects]]\nname = 'colours'\nmesh = { path = 'colours.ply', scale = 1, up = 'y', vertex_colors = 'linear' }\n\
         material.color = { map = 'vertex_color', value = [0.8, 0.8, 0.4] }\n",
    );
    let (scene, assets) = Scene::load(Path::new(&path), &[]).expect("a scene");
    let world = World::load(scene, &assets).expect("a world");
    let film = trace(&world, vec![], &options(Integrator::Single, LightModel::Scene, 2));
    // Halfway up the triangle: a quarter, a quarter, a half.
    for (name, wanted) in [("Albedo.R", 0.2), ("Albedo.G", 0.2), ("Albedo.B", 0.2)] {
        assert!((mean(&film, name) - wanted).abs() < 1e-3, "{name}: {}", mean(&film, name));
    }
}

fn furred(objects: Vec<ObjectSpec>) -> World {
    crate::common::worlds::square(|s| {
        s.guard.density = 60.0.into();
        s.undercoat.density = 500.0.into();
        s.objects = objects;
    })
}

/// Objects get no hairs, and those of the skin stay where they are.
#[test]
fn hairs_grow_on_the_skin_alone() {
    let grown = |world: &World| {
        let layers = pathtrace::layers(world, &pathtrace::Options::default()).expect("hairs");
        layers.into_iter().map(|(s, _)| s.points).collect::<Vec<_>>()
    };
    let bare = grown(&furred(Vec::new()));
    assert!(bare.iter().all(|points| !points.is_empty()));
    let beside = furred(vec![ball(1.0, [0.0, 1.0, 0.0], dielectric(0.5, 0.5))]);
    assert!(bare == grown(&beside), "an object changes the hairs");
}

#[test]
fn the_memory_of_objects_counts() {
    let bare = furred(Vec::new());
    let with = furred(vec![ball(1.0, [0.0, 3.0, 0.0], dielectric(0.5, 0.5))]);
    let added = (with.triangles() - bare.triangles()) * 128;
    let [needed, more] = [&bare, &with].map(|world| pathtrace::estimate(world, &[]));
    assert!(more > needed + added, "{needed} {more}");
    let options = pathtrace::Options { memory: more - 1, ..pathtrace::Options::default() };
    let refused = message(Tracer::new(&with, vec![], &options).map(|_| ()));
    assert!(refused.contains(&format!("{} triangles", with.triangles())), "{refused}");
    assert!(Tracer::new(&bare, vec![], &options).is_ok());
    assert!(matches!(Tracer::new(&with, vec![], &options).map(|_| ()), Err(Error::Unsupported(_))));
}

/// `pelage reference` traces a scene with objects; that shells cannot show them is
/// said by `pelage check` as well.
#[test]
fn the_commands_agree_on_objects() {
    let folder = Folder::new();
    let small = std::fs::read_to_string(crate::common::root().join("tests/data/small.toml")).unwrap();
    let scene =
        folder.write("scene.toml", format!("{small}\n[[objects]]\nname = 'bell'\nmesh.shape = 'sphere'\n"));
    let out = folder.at("out.exr");
    pelage(&["reference", &scene, "-o", &out, "--size", "16x10", "--spp", "2", "--patch", "0,0,0,0.5"])
        .expect(0, &[]);
    assert!(mean(&pelage_core::film::io::read(Path::new(&out)).unwrap(), "base.G") > 0.01);
    pelage(&["check", &scene]).expect(0, &[]);
    let noted = ["a picture of shells and fins does not show the scene's objects"];
    pelage(&["check", &scene, "--fur", "shells"]).expect(0, &noted);
}

/// The hybrid renderer shows the same objects, and the same shadows on a catcher, as paths that
/// scatter once; under the environment's lights too, which widen the lobes of objects.
#[test]
fn the_hybrid_renderer_shows_the_same_objects() {
    let world = empty_world(|s| {
        s.environment = Some(Environment { lights: 8, intensity: 0.5, ..sky() });
        s.lights = vec![light(Vec3::new(0.5, 1.0, 0.7), 2.0)];
        s.guard.density = 0.0.into();
        s.undercoat.density = 0.0.into();
        seen_from(s, Vec3::new(0.0, 4.0, 9.0), Vec3::new(0.0, 0.3, 0.0), 22.0);
        (s.film.width, s.film.height, s.film.spp) = (96, 64, 16);
        let [.., coated] = materials();
        let metal = ObjectMaterial { metallic: 1.0, ..dielectric(0.8, 0.2) };
        s.objects = vec![
            ball(0.9, [-1.0, 0.0, 0.0], metal),
            ball(0.8, [1.0, -0.1, 0.0], coated),
            catcher(object(Shape::Plane, 2.0, [0.0, -0.9, 0.0], dielectric(0.5, 0.5))),
        ];
    });
    let hybrid = crate::common::worlds::render(&world).film;
    let traced = |spread: Option<f32>| {
        let options = options(Integrator::Single, LightModel::Scene, 64);
        let mut tracer = Tracer::new(&world, vec![], &options).unwrap();
        if let Some(spread) = spread {
            tracer.lights.spreads.fill(spread);
        }
        let mut means = Accumulator::new(96, 64);
        tracer.add(&mut means, 64, None).unwrap();
        means.film()
    };
    let rmse = |film: &Film| crate::common::worlds::rmse(&hybrid, film, &["R", "G", "B", "A"]);
    let film = traced(None);
    for name in ["G", "A", "base.G"] {
        let (found, wanted) = (mean(&hybrid, name), mean(&film, name));
        println!("{name}: hybrid {found:.5}, traced {wanted:.5}");
        assert!(wanted > 0.01 && (found / wanted - 1.0).abs() < 0.003, "{name}: {found} is not {wanted}");
    }
    let (same, points) = (rmse(&film), rmse(&traced(Some(0.0))));
    println!("differences {same:.5}, with lights that are points {points:.5}");
    assert!(same < 0.02 && points > 2.0 * same, "{same} {points}");
}
