//! Small worlds for tests on the GPU, and measurements on their films.

use pelage_core::World;
use pelage_core::assets::Assets;
use pelage_core::film::Film;
use pelage_core::scene::{DirectionalLight, Filter, FurLayers, Scene, Shape};
use pelage_render::{Frame, RenderOptions};

/// A ball of 1 cm radius in short fur under two lights, 96 x 64 pixels of 4 samples, after `edit`.
pub fn ball(edit: impl FnOnce(&mut Scene)) -> World {
    world(|scene| {
        scene.mesh.shape = Some(Shape::Sphere);
        scene.mesh.scale = Some(0.2);
        scene.camera.eye = [0.0, 1.5, 6.5];
        scene.camera.fov = 26.0;
        edit(scene);
    })
}

/// A flat square, 2 x 2 cm, facing +y, seen from 45 degrees, after `edit`.
pub fn square(edit: impl FnOnce(&mut Scene)) -> World {
    world(|scene| {
        scene.mesh.shape = Some(Shape::Plane);
        scene.mesh.scale = Some(0.2);
        scene.camera.eye = [0.0, 5.0, 5.0];
        scene.camera.fov = 14.0;
        edit(scene);
    })
}

/// Short fur without a mesh, which `edit` sets.
pub fn world(edit: impl FnOnce(&mut Scene)) -> World {
    let lights = vec![
        DirectionalLight { direction: [0.5, 0.8, 0.4], irradiance: [3.0, 2.8, 2.5] },
        DirectionalLight { direction: [-0.8, 0.1, 0.3], irradiance: [0.7, 0.9, 1.2] },
    ];
    let mut scene = Scene { lights, ..Default::default() };
    scene.film.width = 96;
    scene.film.height = 64;
    scene.film.spp = 4;
    scene.film.filter = Filter::Box;
    scene.guard.density = 250.0.into();
    scene.guard.length = 0.6.into();
    scene.guard.segments = 6;
    scene.undercoat.height = 0.3.into();
    scene.undercoat.density = 12_000.0.into();
    scene.undercoat.layers = 12;
    scene.undercoat.cell = 0.06;
    scene.render.fur = FurLayers::Hybrid;
    edit(&mut scene);
    World::load(scene, &Assets::default()).expect("a world")
}

/// All planes of `world`, on a device of its own: memory budgets count per device.
pub fn render(world: &World) -> Frame {
    let options = RenderOptions { aovs: true, ..Default::default() };
    let frame = pelage_shells::render(world, &options).expect("a frame");
    assert_eq!(frame.stats.fragments_dropped, 0);
    frame
}

/// The planes of `a` and `b` that differ in any bit: name, pixels, largest difference, first pixel.
pub fn differing(a: &Film, b: &Film) -> Vec<(String, usize, f32, usize)> {
    assert_eq!((a.width, a.height, a.planes.len()), (b.width, b.height, b.planes.len()));
    let mut found = Vec::new();
    for (p, q) in a.planes.iter().zip(&b.planes) {
        assert_eq!(p.name, q.name);
        let at: Vec<usize> =
            (0..p.data.len()).filter(|i| p.data[*i].to_bits() != q.data[*i].to_bits()).collect();
        if let Some(first) = at.first() {
            let most = at.iter().map(|i| (p.data[*i] - q.data[*i]).abs()).fold(0.0, f32::max);
            found.push((p.name.clone(), at.len(), most, *first));
        }
    }
    found
}

/// Root of the mean squared difference of the named planes.
pub fn rmse(a: &Film, b: &Film, names: &[&str]) -> f64 {
    let mut sum = 0.0;
    let mut count = 0;
    for name in names {
        let (p, q) = (plane(a, name), plane(b, name));
        sum += p.iter().zip(q).map(|(x, y)| f64::from(x - y).powi(2)).sum::<f64>();
        count += p.len();
    }
    (sum / count as f64).sqrt()
}

/// Largest difference of the named planes.
pub fn largest(a: &Film, b: &Film, names: &[&str]) -> f32 {
    names
        .iter()
        .flat_map(|name| plane(a, name).iter().zip(plane(b, name)).map(|(x, y)| (x - y).abs()))
        .fold(0.0, f32::max)
}

/// A plane that must exist.
pub fn plane<'a>(film: &'a Film, name: &str) -> &'a [f32] {
    film.plane(name).unwrap_or_else(|| panic!("no plane {name}"))
}

/// The colour planes.
pub const RGB: [&str; 3] = ["R", "G", "B"];
/// Colour and alpha.
pub const RGBA: [&str; 4] = ["R", "G", "B", "A"];
