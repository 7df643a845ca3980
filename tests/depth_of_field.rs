//! Depth of field as a post-process.

use crate::common::films::chart;
use crate::common::message;
use pelage_core::Error;
use pelage_core::film::{Film, depth_of_field};
use pelage_core::scene::{Camera, Lens, LensMethod};

fn lens(aperture: f32, focus: f32) -> Camera {
    Camera {
        fov: 40.0,
        lens: Some(Lens { aperture, focus: Some(focus), method: LensMethod::Post }),
        ..Camera::default()
    }
}

fn point(depth: f32) -> Film {
    let mut pixels = vec![[0.0; 4]; 61 * 61];
    pixels[30 * 61 + 30] = [1.0, 0.5, 0.25, 1.0];
    let mut film = Film::from_premultiplied(61, 61, &pixels);
    film.push("guard.G", false, pixels.iter().map(|p| p[1]).collect());
    film.push("depth.Z", true, vec![depth; 61 * 61]);
    film
}

#[test]
fn what_is_in_focus_stays_as_it_is() {
    let mut film = chart(64, 48);
    film.push("depth.Z", true, vec![20.0; 64 * 48]);
    let sharp = film.clone();
    depth_of_field::apply(&mut film, &lens(2.0, 20.0)).unwrap();
    assert_eq!(film, sharp);
    depth_of_field::apply(&mut film, &lens(2.0, 40.0)).unwrap();
    assert_ne!(film, sharp, "the wrong focus shows");
    let mut film = sharp.clone();
    depth_of_field::apply(&mut film, &Camera::default()).unwrap();
    let mut samples = lens(2.0, 40.0);
    samples.lens.as_mut().unwrap().method = LensMethod::Samples;
    depth_of_field::apply(&mut film, &samples).unwrap();
    assert_eq!(film, sharp, "no lens, or lens samples: nothing to do");
}

#[test]
fn a_point_becomes_a_disc_of_its_circle_of_confusion() {
    let focal = 61.0 / (2.0 * 20f32.to_radians().tan());
    let diameter = depth_of_field::circle_of_confusion(2.0, 20.0, focal, 30.0);
    assert!((diameter - 2.0 * (30.0 - 20.0) / 30.0 * focal / 20.0).abs() < 1e-4);
    assert!(
        (depth_of_field::circle_of_confusion(2.0, 20.0, focal, f32::INFINITY) - 2.0 * focal / 20.0).abs()
            < 1e-4
    );
    // Alone at its depth, and in front of nothing: the energy is the same, the disc as wide as
    // computed.
    for around in [30.0, f32::INFINITY] {
        let mut film = point(30.0);
        let depth = film.plane_mut("depth.Z").unwrap();
        depth.fill(around);
        depth[30 * 61 + 30] = 30.0;
        // A wide lens makes a difference of more than a pixel between the two depths.
        let camera = lens(4.0, 20.0);
        depth_of_field::apply(&mut film, &camera).unwrap();
        for (name, energy) in [("R", 1.0), ("G", 0.5), ("A", 1.0), ("guard.G", 0.5)] {
            let plane = film.plane(name).unwrap();
            let sum: f32 = plane.iter().sum();
            assert!((sum - energy).abs() < 1e-3, "{name}: {sum}");
            let wide = plane[30 * 61..31 * 61].iter().filter(|v| **v > 0.0).count() as f32;
            assert!(
                (wide - 2.0 * diameter).abs() < 1.6,
                "{name}: {wide} pixels, computed {}",
                2.0 * diameter
            );
        }
    }
}

#[test]
fn blur_bleeds_from_the_front_and_not_from_behind() {
    // Left half red at 10 cm, right half blue at 40 cm.
    let scene = || {
        let left = |i: usize| i % 60 < 30;
        let pixels: Vec<[f32; 4]> =
            (0..60 * 40).map(|i| if left(i) { [1.0, 0.0, 0.0, 1.0] } else { [0.0, 0.0, 1.0, 1.0] }).collect();
        let mut film = Film::from_premultiplied(60, 40, &pixels);
        film.push("depth.Z", true, (0..60 * 40).map(|i| if left(i) { 10.0 } else { 40.0 }).collect());
        film
    };
    let at = |film: &Film, x: usize| film.premultiplied().unwrap()[20 * 60 + x];
    let mut front_sharp = scene();
    depth_of_field::apply(&mut front_sharp, &lens(2.0, 10.0)).unwrap();
    assert_eq!(at(&front_sharp, 29), [1.0, 0.0, 0.0, 1.0]);
    assert!(at(&front_sharp, 30)[0] < 1e-6, "nor does the sharp front spread");
    let mut back_sharp = scene();
    depth_of_field::apply(&mut back_sharp, &lens(2.0, 40.0)).unwrap();
    let (near, far) = (at(&back_sharp, 30), at(&back_sharp, 50));
    assert!(near[0] > 0.3 && near[0] < 0.6, "the blurred front covers about half: {near:?}");
    assert!(at(&back_sharp, 29)[2] > 0.3, "and lets the back through on its own side");
    assert_eq!(far, [0.0, 0.0, 1.0, 1.0]);
    for film in [&front_sharp, &back_sharp] {
        assert!(film.plane("A").unwrap().iter().all(|a| (a - 1.0).abs() < 1e-4), "opaque stays opaque");
    }
}

#[test]
fn invalid_inputs_are_errors() {
    assert!(message(depth_of_field::apply(&mut chart(4, 4), &lens(1.0, 10.0))).contains("depth.Z"));
    let mut film = point(10.0);
    for camera in [lens(-1.0, 10.0), lens(f32::NAN, 10.0), lens(1.0, 0.0)] {
        assert!(matches!(depth_of_field::apply(&mut film, &camera), Err(Error::Scene(_))));
    }
    // Absurd but valid: bounded by the largest radius.
    depth_of_field::apply(&mut film, &lens(1e6, 1e-3)).unwrap();
    assert!(film.plane("R").unwrap().iter().all(|v| v.is_finite()));
}
