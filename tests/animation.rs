//! Frames of animations, and the spring model of moving hair against closed forms.

use crate::common::{Folder, pelage};
use glam::{DVec3, Vec3};
use pelage_core::assets::Assets;
use pelage_core::scene::{Dynamics, Motion};
use pelage_core::{Scene, World, animation, film};
use pelage_render::RenderOptions;
use pelage_shells::dynamics::{self, Spring};
use pelage_shells::shellfin::Pose;

fn scene(text: &str) -> Scene {
    Scene::parse(&format!("[mesh]\nshape = 'sphere'\n{text}"), "animation.toml", &[]).unwrap()
}

#[test]
fn a_turntable_turns_about_the_target_and_closes() {
    let scene = scene(
        "[camera]\neye = [3, 6, 30]\ntarget = [1, 2, 0]\n[animation]\nframes = 8\nfps = 4\nturntable = 360",
    );
    let first = animation::at(&scene, 1);
    assert_eq!((first.camera.clone(), first.time), (scene.camera.clone(), 0.0));
    let quarter = animation::at(&scene, 3);
    assert_eq!(quarter.time, 0.5);
    // A quarter turn takes +z to +x.
    assert!(Vec3::from(quarter.camera.eye).distance(Vec3::new(31.0, 6.0, -2.0)) < 1e-4);
    assert_eq!(quarter.camera.target, scene.camera.target);
    assert!(Vec3::from(animation::at(&scene, 9).camera.eye).distance(Vec3::new(3.0, 6.0, 30.0)) < 1e-5);
    // A million turns later the camera is still on the circle.
    let late = Vec3::from(animation::at(&scene, 8_000_003).camera.eye);
    assert!(late.distance(quarter.camera.eye.into()) < 1e-3);
}

#[test]
fn the_object_swings_and_its_acceleration_fits() {
    let motion = Motion { amplitude: 2.0, frequency: 0.5, axis: [0.0, 0.0, -3.0] };
    assert!(animation::offset(&motion, 0.5).distance(Vec3::new(0.0, 0.0, -2.0)) < 1e-6);
    let dt = 1e-3;
    for time in [0.1, 0.7, 1.9] {
        let [before, now, after] =
            [time - dt, time, time + dt].map(|t| animation::offset(&motion, t).as_dvec3());
        let measured = (before - 2.0 * now + after) / (dt * dt);
        assert!(measured.distance(animation::acceleration(&motion, time).as_dvec3()) < 0.5, "{measured}");
    }
    let scene =
        scene("[animation]\nfps = 4\n[animation.motion]\namplitude = 2\nfrequency = 0.5\naxis = [0, 0, 1]");
    let state = animation::at(&scene, 3);
    let (eye, target) = (Vec3::from(state.camera.eye), Vec3::from(state.camera.target));
    assert!((eye - Vec3::from(scene.camera.eye)).distance(Vec3::new(0.0, 0.0, -2.0)) < 1e-5);
    assert!((target - Vec3::from(scene.camera.target)).distance(Vec3::new(0.0, 0.0, -2.0)) < 1e-5);
}

/// Free swing from b0 at rest: e^(-c t/2) (cos w t + c/(2 w) sin w t).
fn free(d: &Dynamics, b0: f64, t: f64) -> f64 {
    let (k, c) = (f64::from(d.stiffness), f64::from(d.damping));
    let w = (k - 0.25 * c * c).sqrt();
    b0 * (-0.5 * c * t).exp() * ((w * t).cos() + 0.5 * c / w * (w * t).sin())
}

#[test]
fn free_oscillation_matches_the_closed_form() {
    let d = Dynamics { stiffness: 900.0, damping: 8.0, ..Dynamics::default() };
    let dt = 0.01 * dynamics::longest_stable_step(&d);
    let mut spring = Spring { bend: DVec3::X, velocity: DVec3::ZERO };
    for i in 1..=1500 {
        spring.step(&d, DVec3::ZERO, dt, 10.0);
        let expected = free(&d, 1.0, f64::from(i) * dt);
        assert!((spring.bend.x - expected).abs() < 0.01, "{i}: {} and {expected}", spring.bend.x);
    }
    assert!(free(&d, 1.0, 1500.0 * dt).abs() < 0.05, "it was long enough to come to rest");
}

#[test]
fn driven_oscillation_matches_the_closed_form() {
    let motion = Motion { amplitude: 1.5, frequency: 3.0, axis: [0.0, 1.0, 0.0] };
    let d = Dynamics { stiffness: 900.0, damping: 8.0, gravity: [90.0, 0.0, 0.0], ..Dynamics::default() };
    let (k, c) = (900.0_f64, 8.0_f64);
    let w = std::f64::consts::TAU * 3.0;
    let force = 1.5 * w * w;
    // The steady state is p sin(w t) + q cos(w t); the free part makes bend and speed 0 at time 0.
    let size = (k - w * w).powi(2) + (c * w).powi(2);
    let (p, q) = (force * (k - w * w) / size, -force * c * w / size);
    let wd = (k - 0.25 * c * c).sqrt();
    let s = (-p * w - 0.5 * c * q) / wd;
    let mut largest = 0.0_f64;
    for i in 0..=40 {
        let t = f64::from(i) * 0.031;
        let decay = (-0.5 * c * t).exp();
        let expected =
            p * (w * t).sin() + q * (w * t).cos() + decay * (-q * (wd * t).cos() + s * (wd * t).sin());
        let found = dynamics::bend(&d, &motion, 100.0, t);
        largest = largest.max(expected.abs());
        assert!((f64::from(found.y) - expected).abs() < 0.03, "{t}: {found} and {expected}");
        assert!((found.x - 0.1).abs() < 1e-6 && found.z == 0.0, "it hangs as far as gravity bends it");
    }
    assert!(largest > 1.0, "it did swing: {largest}");
}

#[test]
fn the_stable_step_is_stable() {
    for (stiffness, damping) in [(2000.0, 0.0), (2000.0, 12.0), (50.0, 300.0)] {
        let d = Dynamics { stiffness, damping, ..Dynamics::default() };
        let longest = dynamics::longest_stable_step(&d);
        let end = |dt: f64| {
            let mut spring = Spring { bend: DVec3::X, velocity: DVec3::ZERO };
            (0..400).for_each(|_| spring.step(&d, DVec3::ZERO, dt, f64::INFINITY));
            spring.bend.length()
        };
        assert!(end(0.98 * longest) < 20.0);
        assert!(damping > 0.0 || end(1.02 * longest) > 1e6, "no undamped step is longer");
    }
}

#[test]
fn hair_bends_no_further_than_its_length_and_comes_back() {
    let d = Dynamics { gravity: [0.0, -1e6, 0.0], ..Dynamics::default() };
    let still = Motion::default();
    for time in [0.0, 0.3] {
        assert!(dynamics::bend(&d, &still, 0.8, time).distance(Vec3::new(0.0, -0.8, 0.0)) < 1e-5);
    }
    let mut spring = Spring { bend: DVec3::X, velocity: DVec3::X * 1e5 };
    let d = Dynamics::default();
    spring.step(&d, DVec3::ZERO, 1e-3, 1.0);
    assert!(spring.bend.length() <= 1.0 + 1e-12 && spring.velocity.x <= 0.0);
}

#[test]
fn wind_keeps_its_mean_and_gusts() {
    let d = Dynamics { wind: [100.0, 0.0, 0.0], gust: 0.8, gust_frequency: 2.0, ..Dynamics::default() };
    let still = Motion::default();
    let samples: Vec<f64> =
        (0..20_000).map(|i| dynamics::driving_acceleration(&d, &still, f64::from(i) * 0.005).x).collect();
    let mean = samples.iter().sum::<f64>() / samples.len() as f64;
    let [low, high] = [f64::min, f64::max].map(|f| samples.iter().copied().fold(100.0, f));
    assert!((mean - 100.0).abs() < 1.0, "{mean}");
    assert!((20.0..40.0).contains(&low) && (160.0..=180.0).contains(&high), "{low} {high}");
}

/// No spring makes the program hang or return values that are not finite.
#[test]
fn extreme_springs_stay_finite() {
    let motion = Motion { amplitude: 10.0, frequency: 20.0, axis: [1.0, 0.0, 0.0] };
    for stiffness in [1e-6, 1.0, 1e12, 1e30] {
        for damping in [0.0, 1.0, 1e6, 1e30] {
            let d = Dynamics { stiffness, damping, gravity: [0.0, -981.0, 0.0], ..Dynamics::default() };
            let bend = dynamics::bend(&d, &motion, 2.0, 30.0);
            assert!(bend.is_finite() && bend.length() < 2.001, "{stiffness} {damping}: {bend}");
        }
    }
}

#[test]
fn faults_of_the_table_are_named() {
    let parse = |text: &str| {
        let text = format!("[mesh]\nshape = 'sphere'\n{text}");
        Scene::parse(&text, "animation.toml", &[]).unwrap_err().to_string()
    };
    let text = parse("[animation]\nframes = 0\nfps = -1");
    assert!(text.contains("animation.frames") && text.contains("animation.fps"), "{text}");
    let text = parse("[animation.motion]\namplitude = 1\naxis = [0, 0, 0]");
    assert!(text.contains("animation.motion.axis") && text.contains(":5:"), "{text}");
}

/// Frames of the command line: numbered files, each like a still with the frame's camera; any range
/// can be rendered again.
#[test]
fn frames_are_numbered_and_do_not_depend_on_each_other() {
    let folder = Folder::new();
    let scene = folder.write(
        "turn.toml",
        "[mesh]\nshape = 'critter'\n[film]\nwidth = 24\nheight = 16\nspp = 1\n[animation]\nframes = 3\nturntable = 90\n",
    );
    let render = |extra: &[&str]| {
        let out = folder.at("fur.png");
        let mut args = vec!["render", &scene, "-o", &out, "--fur", "base", "--quiet"];
        args.extend(extra);
        pelage(&args)
    };
    let stats = folder.at("s.json");
    render(&["--frames", "2..", "--stats", &stats]).expect(0, &[]);
    assert_eq!(folder.names(), ["fur_0002.png", "fur_0003.png", "s_0002.json", "s_0003.json", "turn.toml"]);
    let pixels = |name: &str| image::open(folder.at(name)).unwrap().to_rgba8();
    let third = pixels("fur_0003.png");
    assert!(third != pixels("fur_0002.png"), "the camera turns");
    render(&["--frames", "3..3"]).expect(0, &[]);
    assert!(pixels("fur_0003.png") == third, "alone as after the second");
    render(&["--frames", "4.."]).expect(2, &["3 frames"]);
    render(&["--frames", "3..2"]).expect(2, &["--frames", "A..B"]);
}

/// Wind bends the hair of a frame as it bends that of a still at the same time; without wind
/// nothing is bent.
#[test]
fn wind_bends_the_hair_of_frames() {
    let folder = Folder::new();
    let text = "[mesh]\nshape = 'sphere'\n[film]\nwidth = 48\nheight = 32\nspp = 1\n[[lights]]\n[render]\nfur = 'shells'\n\
        [bake]\nsource = 'particles'\nlayers = 6\nheight = 3\nresolution = [32, 32]\nfin_resolution = [64, 16]\n\
        [animation]\nframes = 6\nfps = 5\n[shells.dynamics]\nwind = [3000, 0, 0]\n";
    let path = folder.write("wind.toml", text);
    let pixels = |arguments: &[&str], name: &str| {
        let out = folder.at(if name.contains('_') { "fur.png" } else { name });
        let mut all = vec!["render", &path, "-o", &out, "--quiet"];
        all.extend(arguments);
        pelage(&all).expect(0, &[]);
        image::open(folder.at(name)).unwrap().to_rgba8()
    };
    let first = pixels(&["--frames", "1"], "fur_0001.png");
    let third = pixels(&["--frames", "3..3"], "fur_0003.png");
    let calm = pixels(&["--frames", "3..3", "-D", "shells.dynamics.wind=[0,0,0]"], "fur_0003.png");
    assert!(first == pixels(&[], "still.png"), "a still is the first frame");
    let differing = |a: &image::RgbaImage, b: &image::RgbaImage| {
        a.pixels().zip(b.pixels()).filter(|(a, b)| (0..4).any(|k| a.0[k].abs_diff(b.0[k]) > 8)).count()
    };
    assert!(differing(&third, &calm) > 48 * 32 / 20, "{} pixels differ from calm", differing(&third, &calm));
    assert!(differing(&third, &first) > 10, "{} pixels change by gusts", differing(&third, &first));
    // Alone, through the library.
    let scene = Scene::parse(text, "wind.toml", &[]).unwrap();
    let state = animation::at(&scene, 3);
    let world = World::load(scene, &Assets::default()).unwrap();
    let mut frame =
        pelage_shells::render(&world, &RenderOptions { time: state.time, ..Default::default() }).unwrap();
    film::composite::over_background(&mut frame.film, &world.scene, &Assets::default()).unwrap();
    let alone = folder.at("alone.png");
    let metadata = film::Metadata::of_program();
    film::io::write(&frame.film, std::path::Path::new(&alone), &metadata, &world.scene.film).unwrap();
    assert!(image::open(alone).unwrap().to_rgba8() == third, "as through the library");
    // cm, by the fur's height, no longer than the hair.
    let rest = Pose::at(&world, 0.0, 3.0);
    assert!(rest.bend.distance(Vec3::X * 1.5) < 1e-5, "{}", rest.bend);
    assert!(rest.by_height(3.0).distance(Vec3::X * 0.5) < 1e-5);
    assert!(rest.by_height(0.5).distance(Vec3::X) < 1e-6);
}
