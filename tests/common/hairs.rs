//! Explicit hairs for the path tracer.

use glam::{Vec3, Vec4};
use pelage_core::World;
use pelage_core::assets::Assets;
use pelage_core::film::Film;
use pelage_core::scene::{Environment, Filter, Scene, Shape};
use pelage_fur::Layer;
use pelage_fur::fibre::Fibre;
use pelage_fur::random::{hash2, random};
use pelage_pathtrace::strands::{Hair, Strands};
use pelage_pathtrace::{self as pathtrace, Integrator, LightModel, Options};

/// A hair of one colour.
pub fn hair(color: Vec3) -> Hair {
    Hair { color_root: color, color_tip: color, glint_angle: 0.6, present: u64::MAX }
}

/// Hairs of `segments` segments through the given points with their radii, all of one colour.
pub fn strands(layer: Layer, segments: usize, points: Vec<Vec4>, color: Vec3) -> Strands {
    let count = points.len() / (segments + 1);
    Strands {
        layer,
        segments,
        points,
        hairs: vec![hair(color); count],
        opacity: Vec::new(),
        color_transition: [0.5, 0.5],
        color_transitions: Vec::new(),
    }
}

/// A straight hair of even radius.
pub fn straight(from: Vec3, to: Vec3, radius: f32, segments: usize) -> Vec<Vec4> {
    (0..=segments).map(|k| from.lerp(to, k as f32 / segments as f32).extend(radius)).collect()
}

/// Bent, tapered hairs that grow from a square of `side` cm about the origin, `count` of them,
/// `length` cm high.
pub fn coat(
    count: u32,
    side: f32,
    length: f32,
    radius: f32,
    lean: f32,
    segments: usize,
    seed: u32,
) -> Vec<Vec4> {
    let mut points = Vec::new();
    for i in 0..count {
        let r = |k: u32| random(hash2(seed, i), k);
        let root = Vec3::new((r(0) - 0.5) * side, 0.0, (r(1) - 0.5) * side);
        let turn = r(2) * std::f32::consts::TAU;
        let out = Vec3::new(turn.cos(), 0.0, turn.sin()) * 0.3 + Vec3::X * lean;
        for k in 0..=segments {
            let s = k as f32 / segments as f32;
            let at = root + (Vec3::Y * s + out * s * s) * length * (0.7 + 0.3 * r(3));
            points.push(at.extend(radius * (1.0 - 0.6 * s)));
        }
    }
    points
}

/// A world whose skin is a small square far below everything, without lights: `edit` adds them and
/// the camera.
pub fn empty_world(edit: impl FnOnce(&mut Scene)) -> World {
    let mut scene = Scene::default();
    scene.mesh.shape = Some(Shape::Plane);
    scene.mesh.scale = Some(0.001);
    scene.mesh.translate = [0.0, -500.0, 0.0];
    scene.film.width = 24;
    scene.film.height = 24;
    scene.film.filter = Filter::Box;
    scene.camera.eye = [0.0, 0.0, 10.0];
    scene.camera.target = [0.0; 3];
    scene.camera.fov = 10.0;
    edit(&mut scene);
    World::load(scene, &Assets::default()).expect("a world")
}

/// A uniform sky of radiance 1.
pub fn sky() -> Environment {
    Environment { lights: 1, ..Environment::default() }
}

/// Options for `samples` samples.
pub fn options(integrator: Integrator, lights: LightModel, samples: u32) -> Options<'static> {
    Options { integrator, lights: Some(lights), samples: Some(samples), ..Options::default() }
}

/// The diffuse term of Kajiya and Kay, lossless for a white hair.
pub fn diffuse() -> Fibre {
    Fibre::KajiyaKay(pelage_fur::fibre::KajiyaKay::new(1.0, 0.0, 1.0))
}

/// Traces diffuse hairs.
pub fn trace(world: &World, coats: Vec<Strands>, options: &Options<'_>) -> Film {
    let coats = coats.into_iter().map(|s| (s, diffuse())).collect();
    pathtrace::render_layers(world, coats, options, &mut |_| Ok(())).expect("a film").film
}

/// Mean of a plane.
pub fn mean(film: &Film, name: &str) -> f64 {
    let plane = film.plane(name).unwrap_or_else(|| panic!("no plane {name}"));
    plane.iter().map(|v| f64::from(*v)).sum::<f64>() / plane.len() as f64
}
