//! Light probes: angular maps and photographs of mirror balls as environment maps.

use crate::common::{Folder, assets, cases, gpu, pelage};
use glam::{DVec3, Vec3};
use pelage_core::assets::Assets;
use pelage_core::film::composite::Backdrop;
use pelage_core::film::{Film, io};
use pelage_core::light::environment::Panorama;
use pelage_core::light::probe::Probe;
use pelage_core::scene::{Background, Environment, Projection};
use pelage_core::{Scene, World};
use proptest::prelude::*;
use std::f64::consts::PI;
use std::path::Path;

const BOTH: [Probe; 2] = [Probe::Angular, Probe::MirrorBall];

/// A smooth radiance that is different in all directions.
fn radiance(d: DVec3) -> [f32; 3] {
    let red = 1.0 + 0.5 * d.x + 0.3 * d.y * d.z;
    let green = 0.8 + 0.4 * d.y - 0.2 * d.x * d.z;
    let blue = 1.2 - 0.6 * d.z + 0.3 * d.x * d.y;
    [red as f32, green as f32, blue as f32]
}

/// The integral of [`radiance`]: odd terms and products of two axes vanish.
const TOTAL: DVec3 = DVec3::new(4.0 * PI, 0.8 * 4.0 * PI, 1.2 * 4.0 * PI);

fn place(side: usize, i: usize) -> [f64; 2] {
    let at = |i: usize| (i as f64 + 0.5) / side as f64 * 2.0 - 1.0;
    [at(i % side), -at(i / side)]
}

/// The image of a radiance as a probe, with `around` outside the circle.
fn image(probe: Probe, side: usize, of: impl Fn(DVec3) -> [f32; 3], around: f32) -> Vec<[f32; 3]> {
    let texel = |i: usize| {
        let [x, y] = place(side, i);
        if x.hypot(y) > 1.0 { [around; 3] } else { of(probe.direction_of([x, y])) }
    };
    (0..side * side).map(texel).collect()
}

/// Evenly spread directions.
fn directions(n: usize) -> impl Iterator<Item = DVec3> {
    (0..n).map(move |i| {
        let y = 1.0 - (2.0 * i as f64 + 1.0) / n as f64;
        let (sin, cos) = (2.399_963 * i as f64).sin_cos();
        let r = (1.0 - y * y).sqrt();
        DVec3::new(r * cos, y, r * sin)
    })
}

/// The largest relative difference between a map and [`radiance`], in directions that are at least
/// `blind` rad from the probe's rim.
fn difference(map: &Panorama, blind: f64) -> f32 {
    let seen = directions(5000).filter(|d| d.angle_between(DVec3::NEG_Z) > blind);
    seen.map(|d| {
        let (found, right) = (map.radiance(d.as_vec3()), Vec3::from(radiance(d)));
        ((found - right) / right).abs().max_element()
    })
    .fold(0.0, f32::max)
}

#[test]
fn a_probe_shows_the_same_radiance_in_every_direction() {
    for probe in BOTH {
        for side in [64, 255] {
            // What is around the ball does not count, however bright it is.
            let map = probe.panorama(side, &image(probe, side, radiance, 1e6)).unwrap();
            assert_eq!((map.width, map.height), (2 * side, side));
            let blind = match probe {
                Probe::Angular => 9.0 / side as f64,
                Probe::MirrorBall => 4.8 / (side as f64).sqrt(),
            };
            let found = difference(&map, blind);
            println!("{probe:?} {side}: {found}");
            assert!(found < if side > 200 { 0.01 } else { 0.04 }, "{probe:?} {side}: {found}");
            // In the blind spot: what is nearest to it.
            assert!(difference(&map, 0.0) < 0.6, "{probe:?} {side}");
            let sum = (map.total() / TOTAL - 1.0).abs().max_element();
            println!("{probe:?} {side}: total {sum}");
            assert!(sum < 0.01, "{probe:?} {side}: total {sum}");
        }
    }
}

/// The comparison of the test above fails if a probe is read as the other kind, or as the mirror
/// image.
#[test]
fn a_wrong_projection_is_another_light() {
    let side = 128;
    for (probe, wrong) in [(Probe::Angular, Probe::MirrorBall), (Probe::MirrorBall, Probe::Angular)] {
        let texels = image(probe, side, radiance, 0.0);
        let map = wrong.panorama(side, &texels).unwrap();
        assert!(difference(&map, 0.5) > 0.1, "{probe:?}");
        let flipped: Vec<_> =
            (0..side * side).map(|i| texels[i / side * side + side - 1 - i % side]).collect();
        assert!(difference(&probe.panorama(side, &flipped).unwrap(), 0.5) > 0.3, "{probe:?}");
    }
}

/// One lit texel has the power of its solid angle wherever it is: the map's area is the probe's.
#[test]
fn a_small_light_keeps_its_power() {
    let side = 200;
    for probe in BOTH {
        for at in [[0.0, 0.0], [0.31, -0.2], [-0.5, 0.5], [0.0, 0.8], [-0.9, 0.1]] {
            let texel = |v: f64| ((v + 1.0) * 0.5 * side as f64) as usize;
            let i = texel(-at[1]) * side + texel(at[0]);
            let mut texels = vec![[0.0; 3]; side * side];
            texels[i] = [1000.0; 3];
            let [x, y] = place(side, i);
            let radius = x.hypot(y);
            let area = (2.0 / side as f64).powi(2);
            let solid_angle = match probe {
                Probe::Angular => area * PI * (PI * radius).sin() / radius,
                Probe::MirrorBall => 4.0 * area,
            };
            let map = probe.panorama(side, &texels).unwrap();
            let ratio = map.total().x / (1000.0 * solid_angle);
            println!("{probe:?} at {at:?}: {ratio}");
            assert!((ratio - 1.0).abs() < 0.03, "{probe:?} at {at:?}: {ratio}");
            // And it is where it should be.
            let brightest =
                (0..map.texels.len()).max_by(|a, b| map.texels[*a][0].total_cmp(&map.texels[*b][0]));
            let b = brightest.unwrap();
            let found = map.direction_of([(b % map.width) as f64 + 0.5, (b / map.width) as f64 + 0.5]);
            assert!(found.angle_between(probe.direction_of([x, y])) < 0.04, "{probe:?} at {at:?}");
        }
    }
}

proptest! {
    #![proptest_config(cases(200))]

    #[test]
    fn places_and_directions_invert(radius in 0.001f64..0.999, azimuth in 0.0f64..6.2) {
        for probe in BOTH {
            let place = [radius * azimuth.cos(), radius * azimuth.sin()];
            let direction = probe.direction_of(place);
            prop_assert!((direction.length() - 1.0).abs() < 1e-12);
            let back = probe.place_of(direction);
            prop_assert!((back[0] - place[0]).hypot(back[1] - place[1]) < 1e-9, "{place:?} {back:?}");
        }
    }

    /// A ball of radius 1 at the origin, seen by a camera that looks to -z: what its surface at a
    /// place of the image mirrors.
    #[test]
    fn a_mirror_ball_mirrors(radius in 0.001f64..0.999, azimuth in 0.0f64..6.2) {
        let [x, y] = [radius * azimuth.cos(), radius * azimuth.sin()];
        let normal = DVec3::new(x, y, (1.0 - x * x - y * y).sqrt());
        let seen = DVec3::NEG_Z;
        let mirrored = seen - 2.0 * seen.dot(normal) * normal;
        prop_assert!(Probe::MirrorBall.direction_of([x, y]).distance(mirrored) < 1e-9);
    }

    /// Debevec's formula for his light probes: (x r, y r) with r = acos(z) / (pi sqrt(x² + y²)).
    #[test]
    fn angular_maps_are_those_of_debevec(i in 0usize..5000) {
        let d = directions(5000).nth(i).unwrap();
        let r = d.z.acos() / (PI * d.x.hypot(d.y));
        let [x, y] = Probe::Angular.place_of(d);
        prop_assert!((x - d.x * r).hypot(y - d.y * r) < 1e-6);
    }
}

fn film(side: [u32; 2], texels: &[[f32; 3]]) -> Film {
    let pixels: Vec<_> = texels.iter().map(|[r, g, b]| [*r, *g, *b, 1.0]).collect();
    let mut film = Film::from_premultiplied(side[0], side[1], &pixels);
    film.planes.iter_mut().for_each(|p| p.full_precision = true);
    film
}

#[test]
fn what_an_image_may_be() {
    let read = |film: &Film, projection| {
        let mut notes = Vec::new();
        Panorama::from_film(film, projection, &mut notes).map(|map| (map, notes))
    };
    let (angular, mirror) = (Some(Projection::Angular), Some(Projection::MirrorBall));
    let oblong = film([40, 30], &[[1.0; 3]; 1200]);
    for (projection, name) in [(angular, "\"angular\""), (mirror, "\"mirror_ball\"")] {
        let error = read(&oblong, projection).unwrap_err();
        assert!(error.contains("40 x 30") && error.contains(name), "{error}");
        assert!(read(&film([2, 2], &[[1.0; 3]; 4]), projection).unwrap_err().contains("2 x 2"));
    }
    let probe = film([32, 32], &image(Probe::Angular, 32, radiance, 0.0));
    let error = read(&probe, None).unwrap_err();
    assert!(error.contains("32 x 32") && error.contains("environment.projection"), "{error}");
    // A named projection is never questioned.
    let (map, notes) = read(&probe, Some(Projection::Equirectangular)).unwrap();
    assert!(notes.is_empty() && map.width == 32);
    let (map, notes) = read(&probe, mirror).unwrap();
    assert!(notes.is_empty() && map.width == 64);
    // A square that is lit in its corners is stretched, with a note; a usual map needs none.
    let (map, notes) = read(&film([32, 32], &[[1.0; 3]; 1024]), None).unwrap();
    assert!(notes.len() == 1 && notes[0].contains("32 x 32") && notes[0].contains("angular"), "{notes:?}");
    assert_eq!(map.width, 32);
    assert!(read(&film([32, 16], &[[1.0; 3]; 512]), None).unwrap().1.is_empty());
    assert!(read(&film([32, 32], &[[0.0; 3]; 1024]), None).is_ok(), "a black square is no probe");
    // Only what lies in the circle counts.
    let mut texels = image(Probe::MirrorBall, 32, radiance, f32::NAN);
    texels[16 * 32 + 16] = [-1.0, 0.5, -0.5];
    texels[16 * 32 + 17] = [0.5, -1.0, 0.5];
    let (map, notes) = read(&film([32, 32], &texels), mirror).unwrap();
    assert!(map.texels.iter().flatten().all(|v| v.is_finite() && *v >= 0.0));
    assert!(notes.len() == 1 && notes[0].starts_with("2 of 1024 pixels"), "{notes:?}");
    texels[16 * 32 + 18] = [f32::INFINITY; 3];
    assert!(read(&film([32, 32], &texels), mirror).unwrap_err().contains("1 of 1024"));
}

/// Lights, background and path tracer read the same map.
#[test]
fn a_scene_is_lit_by_a_probe() {
    let folder = Folder::new();
    // A sun towards +x, above the horizon, in a dim sky.
    let sun = DVec3::new(0.8, 0.5, 0.3).normalize();
    let sky = |d: DVec3| {
        let glow = (-(d.angle_between(sun) / 0.12).powi(2)).exp() as f32;
        [0.2 + 500.0 * glow, 0.2 + 450.0 * glow, 0.2 + 400.0 * glow]
    };
    let mut lights = Vec::new();
    for (probe, projection) in BOTH.into_iter().zip([Projection::Angular, Projection::MirrorBall]) {
        let name = format!("{}.exr", probe.name());
        let picture = film([128, 128], &image(probe, 128, sky, 0.0));
        io::write(&picture, folder.at(&name), &Default::default(), &Default::default()).unwrap();
        let assets = Assets { folders: vec![folder.path().to_owned()] };
        let environment =
            Environment { map: name, projection: Some(projection), rotate: 90.0, ..Environment::default() };
        let mut scene = Scene::parse("[mesh]\nshape = \"sphere\"\n", "scene.toml", &[]).unwrap();
        scene.environment = Some(environment);
        scene.film.background = Background::Environment;
        let world = World::load(scene, &assets).unwrap();
        // The sun is wider than three degrees, so it is several lights.
        let brightest: Vec3 = world.lights.iter().map(|l| l.direction * l.irradiance.x).sum();
        // Turned counter-clockwise by 90 degrees, seen from above: +x goes to -z.
        let turned = Vec3::new(sun.z as f32, sun.y as f32, -sun.x as f32);
        assert!(brightest.angle_between(turned) < 0.03, "{probe:?}: {brightest}");
        lights.push(world.lights.iter().map(|l| l.irradiance).sum::<Vec3>());
        let Backdrop::Environment { panorama: Some(map), .. } =
            Backdrop::load(&world.scene, &assets).unwrap()
        else {
            panic!("no map behind the fur")
        };
        assert_eq!((map.width, map.height), (256, 128));
        let traced = pelage_pathtrace::light::Sky::load(&world, &assets).unwrap().unwrap();
        assert!(traced.evaluate(turned).0.x > 400.0 && traced.evaluate(-turned).0.x < 1.0, "{probe:?}");
    }
    let ratio = lights[0] / lights[1];
    assert!((ratio - 1.0).abs().max_element() < 0.03, "{ratio}");
}

/// A measured environment, made a probe and read again, gives the same light.
#[test]
fn real_maps_survive_as_probes() {
    let Some(folder) = assets() else { return };
    for name in ["brown_photostudio_02_1k", "chinese_garden_1k", "noon_grass_1k"] {
        let path = folder.join(format!("env/{name}.hdr"));
        let map = Panorama::load(&path, "", None, &mut Vec::new()).unwrap();
        for probe in BOTH {
            let side = 1024;
            let texels = image(probe, side, |d| map.radiance(d.as_vec3()).into(), 0.0);
            let back = probe.panorama(side, &texels).unwrap();
            let ratio = (back.total() / map.total()).as_vec3();
            println!("{name} {probe:?}: {ratio}");
            assert!((ratio - 1.0).abs().max_element() < 0.05, "{name} {probe:?}: {ratio}");
            let code = |v: Vec3| v.x / (1.0 + v.x);
            let seen = || directions(20_000).filter(|d| d.z > -0.95).map(|d| d.as_vec3());
            let difference =
                seen().map(|d| (code(back.radiance(d)) - code(map.radiance(d))).abs()).sum::<f32>();
            let mean = difference / seen().count() as f32;
            println!("{name} {probe:?}: mean difference {mean}");
            assert!(mean < 0.01, "{name} {probe:?}: {mean}");
        }
    }
}

/// One key shows an environment: where the scene has none, a sky is added, and said.
#[test]
fn a_background_without_an_environment_is_a_sky() {
    let folder = Folder::new();
    let base = "[mesh]\nshape = \"sphere\"\n[[lights]]\n[film]\nbackground = \"environment\"\n";
    let scene = folder.write("scene.toml", base);
    let note = &["note: background: the scene has no [environment] to show; a soft sky is added"];
    pelage(&["check", &scene]).expect(0, note);
    let corner = |out: &str, args: &[&str]| {
        let out = folder.at(out);
        let small = [
            "-o",
            &out,
            "--size",
            "16x10",
            "--spp",
            "1",
            "-D",
            "guard.density=1",
            "-D",
            "undercoat.density=10",
        ];
        pelage(&[args, &[&scene], &small].concat()).expect(0, note);
        let film = io::read(Path::new(&out)).unwrap();
        ["R", "G", "B"].map(|name| film.plane(name).unwrap()[0])
    };
    let sky = corner("reference.exr", &["reference"]);
    assert!((0.3..0.7).contains(&sky[2]) && sky[2] > 1.1 * sky[0], "{sky:?}");
    if gpu::open().is_some() {
        let rendered = corner("render.exr", &["render"]);
        assert!((0..3).all(|k| (rendered[k] - sky[k]).abs() < 1e-3), "{rendered:?} {sky:?}");
    }
}

/// `check` and `render` refuse the same, in the same words.
#[test]
fn check_refuses_what_render_refuses() {
    let folder = Folder::new();
    let oblong = film([12, 8], &[[1.0; 3]; 96]);
    io::write(&oblong, folder.at("oblong.exr"), &Default::default(), &Default::default()).unwrap();
    folder.write("plate.png", "no picture");
    let out = folder.at("out.exr");
    for (text, parts) in [
        (
            "[mesh]\nshape = \"sphere\"\n[film]\nbackground = \"plate\"\nplate = \"plate.png\"\n",
            &["plate.png", "cannot be read as an image"][..],
        ),
        (
            "[mesh]\nshape = \"sphere\"\n[environment]\nmap = \"oblong.exr\"\nprojection = \"angular\"\n",
            &["oblong.exr", "12 x 8", "environment.projection is \"angular\""],
        ),
        (
            "[mesh]\nshape = \"sphere\"\n[environment]\nmap = \"oblong.exr\"\nprojection = \"mirrorball\"\n",
            &["scene.toml:5:14", "did you mean \"mirror_ball\"?"],
        ),
    ] {
        let scene = folder.write("scene.toml", text);
        let checked = pelage(&["check", &scene]).expect(3, parts);
        let rendered =
            pelage(&["render", &scene, "-o", &out, "--size", "16x10", "--spp", "1"]).expect(3, parts);
        let faults = |text: &str| -> Vec<String> {
            text.lines().filter(|l| !l.starts_with("note: ")).map(str::to_owned).collect()
        };
        assert_eq!(faults(&checked.err), faults(&rendered.err), "{text}");
    }
}
