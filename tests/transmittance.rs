//! The march through a slab of uniform density against Beer and Lambert.

use crate::common::worlds::{plane, render, square};
use glam::{Vec2, Vec3};
use pelage_core::World;
use pelage_core::scene::{DirectionalLight, FurLayers};
use pelage_fur::shell::Shell;
use pelage_fur::simplex::Field;
use pelage_fur::undercoat::Undercoat;
use pelage_fur::{camera, view};

/// Undercoat of the slab: hairs/cm2, diameter in um, height in cm.
const DENSITY: f32 = 2000.0;
const DIAMETER: f32 = 15.0;
const HEIGHT: f32 = 0.3;
const LAYERS: u32 = 32;

/// Optical depth of upright hairs in a slab, seen at `angle` from the normal: n d sin(angle) over a
/// path of H / cos(angle), times the mean of the density over the layers, which falls at the hairs'
/// ends.
fn optical_depth(world: &World, angle: f64) -> f64 {
    let packed = pelage_fur::groom::pack(world).expect("a groom");
    let shell = Shell::default();
    let undercoat =
        Undercoat { parameters: &packed.undercoat, noise: Field::new(0), shell: &shell, cells: &[] };
    let at =
        |layer: u32| undercoat.evaluate(Vec3::ZERO, Vec3::Y, (layer as f32 + 0.5) / LAYERS as f32, 0).density;
    let mean = (0..LAYERS).map(|l| f64::from(at(l))).sum::<f64>() / f64::from(LAYERS);
    assert!(mean > 0.8, "the slab is not full");
    f64::from(DENSITY) * f64::from(DIAMETER) * 1e-4 * f64::from(HEIGHT) * angle.tan() * mean
}

/// Largest and mean difference of the transmittance in the image of a slab seen at `degrees`, and
/// the range of transmittances; the expected optical depth is multiplied by `factor`.
fn error(degrees: f32, factor: f64) -> (f64, f64, [f64; 2]) {
    let irradiance = 3.0;
    let world = square(|s| {
        s.render.fur = FurLayers::Implicit;
        s.lights = vec![DirectionalLight { direction: [0.0, 1.0, 0.0], irradiance: [irradiance; 3] }];
        // All scattered light continues forwards: the skin is lit as if it were bare, so that it
        // shows the transmittance to the camera.
        s.undercoat.forward_scattering = 1.0;
        s.undercoat.color_root = [1.0; 3].into();
        s.undercoat.color_tip = [1.0; 3].into();
        s.base.color = [1.0; 3].into();
        s.undercoat.density = DENSITY.into();
        s.undercoat.diameter = [DIAMETER; 2];
        s.undercoat.height = HEIGHT.into();
        s.undercoat.layers = LAYERS;
        s.undercoat.subdivision = Some(0);
        s.undercoat.noise_contrast = 0.0;
        s.undercoat.height_variation = 0.0;
        s.undercoat.tangent_jitter = 0.0;
        s.undercoat.uv_jitter = 0.0;
        s.mesh.scale = Some(2.0);
        s.film.width = 48;
        s.film.height = 32;
        s.film.spp = 16;
        let angle = degrees.to_radians();
        s.camera.eye = [0.0, 10.0 * angle.cos(), 10.0 * angle.sin()];
        s.camera.up = [0.0, angle.sin(), -angle.cos()];
        s.camera.fov = 4.0;
    });
    let film = render(&world).film;
    let frame = camera::frame(&world.scene.camera, [film.width, film.height], Vec2::ZERO, Vec2::ZERO, 0);
    let vertical = optical_depth(&world, std::f64::consts::FRAC_PI_4);
    let (mut most, mut sum) = (0f64, 0f64);
    let mut range = [f64::MAX, f64::MIN];
    for y in 0..film.height {
        for x in 0..film.width {
            let ray = view::sample_ray(&frame, [x, y]).normalize();
            let angle = f64::from(-ray.y).acos();
            let expected = (-factor * vertical * angle.tan()).exp();
            let white = f64::from(irradiance) / std::f64::consts::PI;
            let seen = f64::from(plane(&film, "base.R")[(y * film.width + x) as usize]) / white;
            most = most.max((seen - expected).abs());
            sum += seen - expected;
            range = [range[0].min(expected), range[1].max(expected)];
        }
    }
    (most, sum / film.pixels() as f64, range)
}

#[test]
fn even_slab_follows_beer_and_lambert() {
    for degrees in [0.0, 15.0, 30.0, 45.0, 60.0, 70.0, 80.0] {
        let (most, mean, range) = error(degrees, 1.0);
        println!("{degrees} degrees: transmittance {range:.4?}, largest error {most:.5}, mean {mean:+.5}");
        assert!(most < 0.005 && mean.abs() < 0.001, "{degrees} degrees: {most} {mean}");
    }
}

#[test]
fn wrong_extinction_is_noticed() {
    let (most, mean, _) = error(45.0, 1.05);
    println!("5 % too much extinction expected: largest {most:.5}, mean {mean:+.5}");
    assert!(most > 0.01);
}
