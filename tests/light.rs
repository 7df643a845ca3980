//! Environment maps, and the directional lights that replace them.

use crate::common::worlds::{ball, plane, render};
use crate::common::{assets, cases, gpu};
use glam::{DVec3, Quat, Vec3};
use pelage_core::assets::Assets;
use pelage_core::film::Film;
use pelage_core::light::environment::{Panorama, map_from_world, median_cut, uniform_sky};
use pelage_core::light::{Light, lights_of};
use pelage_core::scene::{DirectionalLight, Environment, Shading};
use pelage_core::{Error, Scene};
use proptest::prelude::*;

/// A smooth sky with some structure.
fn sky(width: usize, height: usize, seed: f32) -> Panorama {
    let texels = (0..width * height)
        .map(|i| {
            let x = (i % width) as f32 / width as f32 * std::f32::consts::TAU;
            let y = (i / width) as f32 / height as f32 * std::f32::consts::PI;
            let v = 1.1 + (x + seed).sin() * y.sin() * 0.5 + (3.0 * x - seed).cos() * 0.3 + y.cos() * 0.2;
            [v, v * (0.8 + 0.1 * (2.0 * x).sin()), 0.4 + 0.3 * (x * 2.0 + seed).cos() + 0.2 * y]
        })
        .collect();
    Panorama { width, height, texels }
}

fn sum(lights: &[Light]) -> DVec3 {
    lights.iter().map(|l| l.irradiance.as_dvec3()).sum()
}

fn luminance(v: Vec3) -> f32 {
    pelage_core::film::tonemap::luminance(v)
}

proptest! {
    #![proptest_config(cases(40))]

    #[test]
    fn lights_have_the_energy_of_the_map(n in 1u32..=64, width in 2usize..90, height in 2usize..50, seed in 0f32..6.0) {
        let map = sky(width, height, seed);
        let lights = median_cut(&map, n);
        prop_assert!(lights.len() <= n as usize && !lights.is_empty());
        let (total, lit) = (map.total(), sum(&lights));
        for c in 0..3 {
            prop_assert!((total[c] - lit[c]).abs() <= 1e-6 * total[c], "{} {}", total, lit);
        }
        for light in &lights {
            prop_assert!((light.direction.length() - 1.0).abs() < 1e-5);
            prop_assert!(light.irradiance.min_element() >= 0.0 && light.environment);
        }
    }

    #[test]
    fn texels_and_directions_invert(x in 0.01f64..63.99, y in 0.5f64..31.5) {
        let map = sky(64, 32, 0.0);
        let direction = map.direction_of([x, y]);
        prop_assert!((direction.length() - 1.0).abs() < 1e-12);
        let [bx, by] = map.texel_of(direction);
        prop_assert!((x - bx).abs() < 1e-6 && (y - by).abs() < 1e-6);
    }
}

#[test]
fn the_energies_of_regions_are_even() {
    let map = sky(512, 256, 1.0);
    for n in [2u32, 5, 16, 30, 64] {
        let lights = median_cut(&map, n);
        assert_eq!(lights.len(), n as usize);
        let energies: Vec<f32> = lights.iter().map(|l| luminance(l.irradiance)).collect();
        let (low, high) = energies.iter().fold((f32::MAX, 0f32), |(l, h), e| (l.min(*e), h.max(*e)));
        // Halving the largest: no region has more than twice the energy of another, but for whole
        // columns.
        assert!(high / low < 2.2, "{n}: {low} {high}");
    }
}

#[test]
fn the_whole_sphere_is_four_pi() {
    let white = Panorama { width: 31, height: 17, texels: vec![[1.0; 3]; 31 * 17] };
    let four_pi = 4.0 * std::f64::consts::PI;
    assert!((white.total().x - four_pi).abs() < 1e-9);
    for n in [1, 2, 7, 16, 64] {
        let lights = uniform_sky(Vec3::new(1.0, 2.0, 0.5), n);
        assert_eq!(lights.len(), n as usize);
        assert!((sum(&lights) / four_pi - DVec3::new(1.0, 2.0, 0.5)).abs().max_element() < 1e-6);
        assert!(lights.iter().all(|l| (l.direction.length() - 1.0).abs() < 1e-6));
        if n >= 16 {
            // Spread: the closest pair is nearly as far apart as n equal caps allow, the mean is
            // near the centre.
            let mean = lights.iter().map(|l| l.direction).sum::<Vec3>() / n as f32;
            let closest = (0..lights.len())
                .flat_map(|i| (0..i).map(move |j| (i, j)))
                .map(|(i, j)| lights[i].direction.distance(lights[j].direction))
                .fold(f32::MAX, f32::min);
            assert!(mean.length() < 0.1 && closest > 2.0 / (n as f32).sqrt(), "{n}: {mean} {closest}");
        }
    }
}

#[test]
fn directions_follow_the_convention() {
    // One bright texel each at the centre, right of it, left of it, above.
    let map = |x: usize, y: usize| {
        let mut texels = vec![[0.0; 3]; 64 * 32];
        texels[y * 64 + x] = [1.0; 3];
        Panorama { width: 64, height: 32, texels }
    };
    for (x, y, expected) in
        [(32, 16, Vec3::NEG_Z), (48, 16, Vec3::X), (16, 16, Vec3::NEG_X), (32, 0, Vec3::Y)]
    {
        let lights = median_cut(&map(x, y), 16);
        assert_eq!(lights.len(), 1, "dark regions give no light");
        assert!(lights[0].direction.distance(expected) < 0.08, "{} {expected}", lights[0].direction);
        assert!(map(x, y).radiance(lights[0].direction).x > 0.9);
        assert_eq!(map(x, y).radiance(-lights[0].direction), Vec3::ZERO);
    }
    assert!((map_from_world(90.0).inverse() * Vec3::NEG_Z).distance(Vec3::NEG_X) < 1e-6, "counter-clockwise");
}

#[test]
fn lookup_is_bilinear_and_wraps() {
    let map = sky(128, 64, 2.0);
    let at = |x: f64, y: f64| map.radiance(map.direction_of([x, y]).as_vec3()).x;
    let texel = |x: usize, y: usize| map.texels[y * 128 + x][0];
    assert!((at(10.5, 20.5) - texel(10, 20)).abs() < 1e-4);
    assert!((at(11.0, 20.5) - 0.5 * (texel(10, 20) + texel(11, 20))).abs() < 1e-4);
    assert!((at(0.0, 20.5) - 0.5 * (texel(127, 20) + texel(0, 20))).abs() < 1e-4, "around the back");
    assert!((at(7.5, 0.1) - texel(7, 0)).abs() < 1e-4, "clamped at the pole");
}

#[test]
fn turning_the_map_turns_the_lights() {
    let folder = tempfile::tempdir().unwrap();
    let map = sky(64, 32, 0.5);
    let pixels: Vec<[f32; 4]> = map.texels.iter().map(|[r, g, b]| [*r, *g, *b, 1.0]).collect();
    let mut film = Film::from_premultiplied(64, 32, &pixels);
    film.planes.iter_mut().for_each(|p| p.full_precision = true);
    let path = folder.path().join("sky.exr");
    pelage_core::film::io::write(&film, &path, &Default::default(), &Default::default()).unwrap();
    let assets = Assets { folders: vec![folder.path().to_owned()] };
    let of = |rotate: f32| {
        let environment = Environment {
            map: "sky.exr".into(),
            rotate,
            intensity: 2.0,
            tint: [1.0, 0.5, 0.25],
            ..Default::default()
        };
        lights_of(&Scene { environment: Some(environment), ..Scene::default() }, &assets, &mut Vec::new())
            .unwrap()
    };
    let (still, turned) = (of(0.0), of(70.0));
    assert_eq!(still.len(), 16);
    let turn = Quat::from_rotation_y(70f32.to_radians());
    for (a, b) in still.iter().zip(&turned) {
        assert!((turn * a.direction).distance(b.direction) < 1e-5 && a.irradiance == b.irradiance);
    }
    let expected = map.total() * DVec3::new(2.0, 1.0, 0.5);
    assert!(((sum(&still) - expected) / expected).abs().max_element() < 1e-6);
    // The same as shifting the columns: 64 columns make a full turn, to the left for a positive
    // one.
    let shifted = Panorama {
        texels: (0..64 * 32).map(|i| map.texels[i / 64 * 64 + (i % 64 + 16) % 64]).collect(),
        ..map.clone()
    };
    for world in [Vec3::new(0.3, 0.2, -1.0), Vec3::new(-1.0, 0.5, 0.4), Vec3::new(0.2, -0.7, 0.9)] {
        let difference = map.radiance(map_from_world(90.0) * world) - shifted.radiance(world);
        assert!(difference.abs().max_element() < 1e-4, "{world}: {difference}");
    }
}

#[test]
fn scene_lights_are_normalised_and_flagged() {
    let assets = Assets::default();
    let mut scene = Scene {
        lights: vec![DirectionalLight { direction: [0.0, 3.0, 4.0], irradiance: [1.0, 2.0, 3.0] }],
        environment: Some(Environment { lights: 5, tint: [0.5; 3], ..Default::default() }),
        ..Scene::default()
    };
    let lights = lights_of(&scene, &assets, &mut Vec::new()).unwrap();
    assert_eq!(lights.len(), 6);
    assert_eq!((lights[0].direction, lights[0].environment), (Vec3::new(0.0, 0.6, 0.8), false));
    assert!(lights[0].undercoat && lights[1..].iter().all(|l| l.environment && l.undercoat));
    assert!((sum(&lights[1..]).x - 2.0 * std::f64::consts::PI).abs() < 1e-5);
    scene.render.shading = Shading::Paper;
    let lights = lights_of(&scene, &assets, &mut Vec::new()).unwrap();
    assert!(lights[0].undercoat && lights[1..].iter().all(|l| !l.undercoat));
    scene.render.shading = Shading::Physical;
    scene.environment.as_mut().unwrap().undercoat = false;
    assert!(lights_of(&scene, &assets, &mut Vec::new()).unwrap()[1..].iter().all(|l| !l.undercoat));
}

#[test]
fn bad_lights_are_reported_together() {
    let scene = Scene {
        lights: vec![
            DirectionalLight { direction: [0.0; 3], irradiance: [1.0; 3] },
            DirectionalLight { direction: [1.0, 0.0, 0.0], irradiance: [1.0, -1.0, 0.0] },
        ],
        environment: Some(Environment { lights: 65, intensity: f32::NAN, ..Default::default() }),
        ..Scene::default()
    };
    let error = lights_of(&scene, &Assets::default(), &mut Vec::new()).unwrap_err();
    assert!(matches!(&error, Error::Scene(faults) if faults.len() == 4), "{error}");
    let missing = Scene {
        environment: Some(Environment { map: "none.hdr".into(), ..Default::default() }),
        ..Scene::default()
    };
    let error = lights_of(&missing, &Assets::default(), &mut Vec::new()).unwrap_err();
    assert!(error.exit_code() == 3 && error.to_string().contains("none.hdr"));
    let mut film = Film::new(4, 2);
    film.plane_mut("G").unwrap()[3] = f32::INFINITY;
    assert!(Panorama::from_film(&film, None, &mut Vec::new()).unwrap_err().contains("1 of 8"));
}

#[test]
fn a_black_map_gives_no_light() {
    let map = Panorama { width: 8, height: 4, texels: vec![[0.0; 3]; 32] };
    assert!(median_cut(&map, 16).is_empty() && median_cut(&sky(8, 4, 0.0), 0).is_empty());
    assert_eq!(median_cut(&Panorama { width: 1, height: 1, texels: vec![[1.0; 3]] }, 16).len(), 1);
}

#[test]
fn real_maps_keep_their_energy_and_find_the_sun() {
    let Some(folder) = assets() else { return };
    for name in ["brown_photostudio_02_1k", "chinese_garden_1k", "noon_grass_1k"] {
        let map = Panorama::load(&folder.join(format!("env/{name}.hdr")), "", None, &mut Vec::new()).unwrap();
        let lights = median_cut(&map, 16);
        let (total, lit) = (map.total(), sum(&lights));
        assert!(((total - lit) / total).abs().max_element() < 1e-6, "{name}");
        assert_eq!(lights.len(), 16, "{name}");
        let brightest = lights.iter().max_by(|a, b| a.irradiance.x.total_cmp(&b.irradiance.x)).unwrap();
        let peak =
            (0..map.texels.len()).max_by(|a, b| map.texels[*a][0].total_cmp(&map.texels[*b][0])).unwrap();
        let (x, y) = (peak % map.width, peak / map.width);
        let sun = map.direction_of([x as f64 + 0.5, y as f64 + 0.5]).as_vec3();
        println!(
            "{name}: brightest {:.1} degrees from the peak",
            sun.angle_between(brightest.direction).to_degrees()
        );
        if !name.starts_with("brown") {
            assert!(
                sun.angle_between(brightest.direction) < 0.05,
                "{name}: the sun is one light, in its place"
            );
        }
    }
}

#[test]
fn lights_have_distinct_directions() {
    // A sun of one degree in a smooth sky: every cut passes through it, but it must become one
    // light, and the sky 15.
    let mut map = sky(720, 360, 1.0);
    let sun = map.direction_of([400.0, 100.0]);
    for i in 0..map.texels.len() {
        let texel = map.direction_of([(i % 720) as f64 + 0.5, (i / 720) as f64 + 0.5]);
        if texel.angle_between(sun) < 0.5f64.to_radians() {
            map.texels[i] = [50_000.0; 3];
        }
    }
    let lights = median_cut(&map, 16);
    assert_eq!(lights.len(), 16);
    for i in 0..16 {
        for j in 0..i {
            assert!(lights[i].direction.angle_between(lights[j].direction) > 2f32.to_radians(), "{i} {j}");
        }
    }
    assert!(lights[0].direction.as_dvec3().angle_between(sun) < 0.005);
    assert!(((map.total() - sum(&lights)) / map.total()).abs().max_element() < 1e-6);
}

/// Half floats hold at most 65,504: what is brighter is cut there, and stays a number.
#[test]
fn bright_lights_stay_finite() {
    if gpu::open().is_none() {
        return;
    }
    for irradiance in [1e6, 1e30] {
        let film = render(&ball(|scene| scene.lights[0].irradiance = [irradiance; 3])).film;
        let brightest = ["R", "G", "B", "A"].map(|name| {
            let values = plane(&film, name);
            assert!(values.iter().all(|v| v.is_finite()), "{name} at {irradiance}");
            values.iter().fold(0.0_f32, |a, b| a.max(*b))
        });
        assert!(brightest[0] > 1e4, "{brightest:?} at {irradiance}");
        println!("{irradiance}: {brightest:?}, {} pixels cut", film.cut_pixels());
        assert!(irradiance < 1e20 || film.cut_pixels() > 0, "{brightest:?} at {irradiance}");
    }
}
