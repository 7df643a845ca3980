//! What a scene does not give, as a photographer would choose it: where the body faces, a camera
//! that frames the fur, and light.

use crate::scene::{Background, Camera, DirectionalLight, Environment, Framing, Front, Scene};
use crate::skin::Skin;
use glam::{Quat, Vec2, Vec3};
use std::collections::HashSet;

/// Azimuth of the camera from the direction in which the body is likely to face, and its elevation,
/// degrees: three-quarters from the front, a little from above.
const THREE_QUARTERS: [f32; 2] = [35.0, 12.0];

/// Margin around the fur, as a fraction of the film's side.
const MARGIN: f32 = 0.06;

/// How far hairs of a given length stand out from the skin: they lean and bend.
const REACH: f32 = 0.85;

/// Turns the coat to the body's front, chooses position and target of a camera with
/// `frame = "auto"`, the lights of a scene without lights and environment, and the environment of a
/// scene that shows one and has none. Returns a note for each choice.
pub fn complete(scene: &mut Scene, skin: &Skin) -> Vec<String> {
    let mut notes = Vec::new();
    let mut front = scene.mesh.front.take();
    if front == Some(Front::Auto) {
        let (guess, name) = front_of(skin);
        front = Some(guess);
        notes.push(format!(
            "front: the body is taken to face {name}, and the coat is combed the other way; mesh.front changes it"
        ));
    }
    if let Some(front) = front {
        let turned = |[x, y, z]: [f32; 3]| match front {
            Front::X => [-z, y, x],
            Front::NegativeX => [z, y, -x],
            Front::Z => [-x, y, -z],
            Front::NegativeZ | Front::Auto => [x, y, z],
        };
        let of_parts = scene.parts.iter_mut().filter_map(|part| part.guard.as_mut());
        for guard in std::iter::once(&mut scene.guard).chain(of_parts) {
            guard.comb_direction = turned(guard.comb_direction);
        }
    }
    if scene.camera.frame == Framing::Auto {
        let view = scene.camera.view.unwrap_or_else(|| view_of(front.unwrap_or_else(|| front_of(skin).0)));
        let aspect = scene.film.width as f32 / scene.film.height as f32;
        let points = fur_points(skin, longest_hair(scene));
        frame(&mut scene.camera, view, aspect, &points);
        let Camera { eye, target, .. } = &scene.camera;
        notes.push(format!(
            "camera: eye = {eye:?} and target = {target:?} chosen to frame the fur from {} degrees azimuth and {} \
             elevation; change them with camera.view, or give camera.eye and camera.target",
            view[0], view[1]
        ));
    }
    if scene.lights.is_empty() && scene.environment.is_none() {
        let camera = &scene.camera;
        (scene.lights, scene.environment) = lights_for(Vec3::from(camera.eye) - Vec3::from(camera.target));
        notes.push(
            "light: the scene has none; a key, a fill and a rim light under a soft sky are chosen for the camera; \
             give [[lights]] or [environment] to choose others"
                .into(),
        );
    }
    if scene.film.background == Background::Environment && scene.environment.is_none() {
        scene.environment = Some(soft_sky());
        notes.push(
            "background: the scene has no [environment] to show; a soft sky is added, which lights it too"
                .into(),
        );
    }
    notes
}

/// The longest hair of all coats, cm, with the largest value of maps.
pub fn longest_hair(scene: &Scene) -> f32 {
    let longest = |density: f32, length: f32| if density > 0.0 { length } else { 0.0 };
    scene.largest(|coat| {
        let (guard, undercoat) = (coat.guard, coat.undercoat);
        longest(guard.density.max(), guard.length.max())
            .max(longest(undercoat.density.max(), undercoat.height.max()))
    })
}

/// Where a body probably faces. Animals are the same left and right, so it faces along the axis
/// across which it is not its own mirror image; where that does not tell, along the longer one, as
/// animals are longer than wide. They carry the head higher than the tail; a body that is no longer
/// than wide faces +x or +z, as most modelling programs have it.
fn front_of(skin: &Skin) -> (Front, &'static str) {
    let (low, high) = skin.bounds();
    let side = high - low;
    let (mirror_x, mirror_z) = (mirrored(skin, Vec3::X), mirrored(skin, Vec3::Z));
    let faces_x = match mirror_x - mirror_z {
        d if d > 0.1 && mirror_x > 0.8 => false,
        d if d < -0.1 && mirror_z > 0.8 => true,
        _ => side.x > 1.2 * side.z,
    };
    let (along, length, width) = if faces_x { (Vec3::X, side.x, side.z) } else { (Vec3::Z, side.z, side.x) };
    let top = |sign: f32| {
        let end = 0.5 * (high + low).dot(along) + sign * 0.25 * length;
        let heights = skin.positions.iter().filter(|p| sign * (p.dot(along) - end) > 0.0).map(|p| p.y);
        heights.fold(f32::NEG_INFINITY, f32::max)
    };
    let backwards = length > 1.2 * width && top(-1.0) > top(1.0) + 0.02 * side.y;
    match (faces_x, backwards) {
        (true, false) => (Front::X, "+x"),
        (true, true) => (Front::NegativeX, "-x"),
        (false, false) => (Front::Z, "+z"),
        (false, true) => (Front::NegativeZ, "-z"),
    }
}

/// How much a body is its own mirror image across `axis`: the share of occupied cells whose mirror
/// images are occupied.
fn mirrored(skin: &Skin, axis: Vec3) -> f32 {
    const CELLS: f32 = 24.0;
    let (low, high) = skin.bounds();
    let (center, cell) = (0.5 * (low + high), (high - low).max_element().max(f32::MIN_POSITIVE) / CELLS);
    // Odd numbers of cells, so that the middle one is its own image.
    let of = |p: &Vec3| ((*p - center) / cell).round().as_ivec3();
    let occupied: HashSet<_> = skin.positions.iter().map(of).collect();
    let flip = glam::IVec3::ONE - 2 * axis.as_ivec3();
    let found = occupied.iter().filter(|c| occupied.contains(&(**c * flip))).count();
    found as f32 / occupied.len().max(1) as f32
}

/// Azimuth and elevation of a camera that sees a body three-quarters from the front.
fn view_of(front: Front) -> [f32; 2] {
    let azimuth = match front {
        Front::X => 90.0,
        Front::NegativeX => -90.0,
        Front::Z | Front::Auto => 0.0,
        Front::NegativeZ => 180.0,
    };
    [azimuth - THREE_QUARTERS[0], THREE_QUARTERS[1]]
}

/// Points of the skin and of the hairs' tips, cm.
fn fur_points(skin: &Skin, hair: f32) -> Vec<Vec3> {
    let tips = skin.positions.iter().zip(&skin.normals).map(|(p, n)| *p + *n * (REACH * hair));
    skin.positions.iter().copied().chain(tips).collect()
}

/// Unit vector towards the given azimuth (about +y, from +z towards +x) and elevation, degrees.
fn direction(azimuth: f32, elevation: f32) -> Vec3 {
    Quat::from_rotation_y(azimuth.to_radians()) * Quat::from_rotation_x(-elevation.to_radians()) * Vec3::Z
}

/// Places the camera so that all `points` lie within the film less its margin, in the middle.
fn frame(camera: &mut Camera, [azimuth, elevation]: [f32; 2], aspect: f32, points: &[Vec3]) {
    let back = direction(azimuth, elevation);
    let right = Vec3::from(camera.up).cross(back).try_normalize().unwrap_or(Vec3::X);
    let up = back.cross(right);
    let tan = (0.5 * camera.fov.to_radians()).tan();
    let tan = Vec2::new(tan * aspect, tan) * (1.0 - 2.0 * MARGIN);
    // Points within the film's sides lie below planes that meet in the eye. Each pair of planes,
    // moved until both touch a point, gives the eye's place across the view, and how far back it
    // must be at least.
    let side = |axis: Vec3, tan: f32| {
        let furthest = |sign: f32| {
            let reach = |p: &Vec3| sign * p.dot(axis) + tan * p.dot(back);
            points.iter().map(reach).fold(f32::NEG_INFINITY, f32::max)
        };
        let (high, low) = (furthest(1.0), furthest(-1.0));
        (0.5 * (high - low), 0.5 * (high + low) / tan)
    };
    let ((x, back_x), (y, back_y)) = (side(right, tan.x), side(up, tan.y));
    let nearest = points.iter().map(|p| p.dot(back)).fold(f32::NEG_INFINITY, f32::max);
    let distance = back_x.max(back_y).max(nearest + 2.0 * camera.near);
    let middle = 0.5 * (nearest + points.iter().map(|p| p.dot(back)).fold(f32::INFINITY, f32::min));
    let at = |depth: f32| (right * x + up * y + back * depth).to_array();
    // Three digits and some more: numbers that a person would write.
    let unit = 10.0_f64.powf(f64::from(distance - middle).max(1e-6).log10().floor() - 3.0);
    let rounded = |v: [f32; 3]| v.map(|x| rounded(x, unit));
    camera.eye = rounded(at(distance));
    camera.target = rounded(at(middle));
    camera.frame = Framing::Given;
    camera.view = None;
}

/// The multiple of `unit`, a power of ten, that is nearest to x: with as few decimals as that
/// takes.
fn rounded(x: f32, unit: f64) -> f32 {
    let steps = (f64::from(x) / unit).round();
    // Division by a power of ten is exact to the last digit, multiplication by a tenth is not.
    let value = if unit < 1.0 { steps / (1.0 / unit).round() } else { steps * unit };
    (value + 0.0) as f32
}

/// A warm key light beside the camera, a weak fill on the other side, a rim light from behind and a
/// soft sky. `back` is the direction from the target to the eye.
fn lights_for(back: Vec3) -> (Vec<DirectionalLight>, Option<Environment>) {
    let azimuth = back.x.atan2(back.z).to_degrees();
    let light = |turn: f32, elevation: f32, irradiance: [f32; 3]| DirectionalLight {
        direction: direction(azimuth + turn, elevation).to_array().map(|v| (v * 1000.0).round() / 1000.0),
        irradiance,
    };
    let lights = vec![
        light(-50.0, 42.0, [5.2, 4.9, 4.4]),
        light(60.0, 15.0, [0.9, 0.95, 1.05]),
        light(155.0, 35.0, [4.2, 4.3, 4.5]),
    ];
    (lights, Some(soft_sky()))
}

fn soft_sky() -> Environment {
    Environment { tint: [0.80, 0.90, 1.0], intensity: 0.55, ..Environment::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ball(radius: f32, center: Vec3) -> Vec<Vec3> {
        let at = |i: usize| {
            let (z, a) = (1.0 - (2 * i + 1) as f32 / 2000.0, 2.4 * i as f32);
            center + radius * Vec3::new((1.0 - z * z).sqrt() * a.cos(), (1.0 - z * z).sqrt() * a.sin(), z)
        };
        (0..2000).map(at).collect()
    }

    /// Coordinates on the film, -1..1 in its height, and the depth of a point.
    fn on_film(camera: &Camera, p: Vec3) -> Vec3 {
        let (eye, target) = (Vec3::from(camera.eye), Vec3::from(camera.target));
        let forward = (target - eye).normalize();
        let right = forward.cross(Vec3::from(camera.up)).normalize();
        let (d, tan) = (p - eye, (0.5 * camera.fov.to_radians()).tan());
        let depth = d.dot(forward);
        Vec3::new(d.dot(right), d.dot(right.cross(forward)), 0.0) / (depth * tan) + Vec3::Z * depth
    }

    /// From any side and for any shape of the film, the fur touches the margin of one pair of sides
    /// and lies in the middle.
    #[test]
    fn the_fur_fills_the_picture() {
        for aspect in [0.6_f32, 1.0, 1.6] {
            for view in [[35.0, 12.0], [-120.0, 60.0], [200.0, -30.0]] {
                let mut camera = Camera { fov: 20.0, ..Camera::default() };
                let points = ball(12.0, Vec3::new(3.0, -40.0, 7.0));
                frame(&mut camera, view, aspect, &points);
                let film: Vec<_> = points.iter().map(|p| on_film(&camera, *p)).collect();
                let low = film.iter().copied().reduce(Vec3::min).unwrap();
                let high = film.iter().copied().reduce(Vec3::max).unwrap();
                let room = 1.0 - 2.0 * MARGIN;
                let used = (high.y.max(-low.y) / room).max(high.x.max(-low.x) / (room * aspect));
                assert!((used - 1.0).abs() < 0.01, "{aspect} {view:?}: {used}");
                assert!((high + low).truncate().length() < 0.02, "{aspect} {view:?}: {low} {high}");
                let back = (Vec3::from(camera.eye) - Vec3::from(camera.target)).normalize();
                assert!(back.dot(direction(view[0], view[1])) > 0.9999, "{view:?}");
            }
        }
    }

    /// A body along each axis whose head is higher than its tail, and a round one.
    #[test]
    fn a_body_faces_where_its_head_is() {
        let skin = |positions: &[[f32; 3]]| Skin {
            positions: positions.iter().map(|p| Vec3::from(*p)).collect(),
            ..Skin::default()
        };
        for (tail, head, front) in [
            ([-9.0, 3.0, 0.0], [9.0, 6.0, 1.0], Front::X),
            ([9.0, 3.0, 0.0], [-9.0, 6.0, 1.0], Front::NegativeX),
            ([0.0, 3.0, -9.0], [1.0, 6.0, 9.0], Front::Z),
            ([0.0, 3.0, 9.0], [1.0, 6.0, -9.0], Front::NegativeZ),
            ([-5.0, 6.0, -5.0], [5.0, 3.0, 5.0], Front::Z),
        ] {
            assert_eq!(front_of(&skin(&[tail, head, [0.0; 3]])).0, front);
        }
        // Wide ears do not turn a head.
        let ears = [
            [-9.0, 5.0, 0.0],
            [9.0, 5.0, 0.0],
            [0.0, 0.0, 4.0],
            [0.0, 2.0, -3.0],
            [2.0, 1.0, 3.0],
            [-2.0, 1.0, 3.0],
        ];
        assert_eq!(front_of(&skin(&ears)).0, Front::Z);
    }

    /// The comb of a coat, written for a body that faces -z, always leads away from the head.
    #[test]
    fn the_coat_turns_with_the_body() {
        for (front, tail) in [
            (Front::X, -Vec3::X),
            (Front::NegativeX, Vec3::X),
            (Front::Z, -Vec3::Z),
            (Front::NegativeZ, Vec3::Z),
        ] {
            let mut scene = Scene::default();
            scene.guard.comb_direction = [0.0, -0.25, 1.0];
            scene.mesh.front = Some(front);
            complete(&mut scene, &Skin { positions: ball(3.0, Vec3::ZERO), ..Skin::default() });
            assert_eq!(Vec3::from(scene.guard.comb_direction), tail - Vec3::Y * 0.25);
            assert_eq!(scene.mesh.front, None, "a scene that is loaded again is not turned twice");
        }
    }

    #[test]
    fn the_key_light_is_beside_the_camera_and_the_rim_light_behind() {
        let back = direction(35.0, 12.0);
        let (lights, sky) = lights_for(back);
        let toward = |i: usize| Vec3::from(lights[i].direction).normalize().dot(back);
        assert!(toward(0) > 0.4 && toward(1) > 0.4 && toward(2) < -0.3, "{lights:?}");
        assert!(sky.is_some());
    }
}
