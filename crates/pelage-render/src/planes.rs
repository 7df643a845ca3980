//! Names of a film's planes, and copying of finished tiles into them.

use crate::job::Job;
use crate::options::RenderOptions;
use pelage_core::World;
use pelage_core::film::{Film, Plane};
use pelage_core::scene::{FilmSpec, FurLayers};

/// A plane of the film.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Named {
    /// Name, that of the channel in an EXR file.
    pub name: &'static str,
    /// Whether it is written as 32-bit float.
    pub full_precision: bool,
    /// Its number in what the film pass writes.
    pub number: usize,
}

const fn half(name: &'static str, number: usize) -> Named {
    Named { name, full_precision: false, number }
}

const fn full(name: &'static str, number: usize) -> Named {
    Named { name, full_precision: true, number }
}

/// Planes of the coverage of guard hairs, undercoat, and skin with objects, which add up to `A`.
pub const COVERAGES: [&str; 3] = ["guard.A", "undercoat.A", "base.A"];

/// The planes of a film. The film pass also writes, as number 19, the weight of the depth.
pub const PLANES: [Named; 31] = [
    half("R", 0),
    half("G", 1),
    half("B", 2),
    half("A", 3),
    half("guard.R", 4),
    half("guard.G", 5),
    half("guard.B", 6),
    half("undercoat.R", 7),
    half("undercoat.G", 8),
    half("undercoat.B", 9),
    half("base.R", 10),
    half("base.G", 11),
    half("base.B", 12),
    full("transmittance.Y", 16),
    full("fragments.Y", 17),
    full("depth.Z", 18),
    full("P.X", 20),
    full("P.Y", 21),
    full("P.Z", 22),
    full("N.X", 13),
    full("N.Y", 14),
    full("N.Z", 15),
    half("Albedo.R", 23),
    half("Albedo.G", 24),
    half("Albedo.B", 25),
    full("Tangent.X", 26),
    full("Tangent.Y", 27),
    full("Tangent.Z", 28),
    half(COVERAGES[0], 29),
    half(COVERAGES[1], 30),
    half(COVERAGES[2], 31),
];

/// The planes that a rendering keeps. Those of shells and fins have no features but the position:
/// once blended, textured shells cannot be separated.
pub fn kept(options: &RenderOptions<'_>, fur: FurLayers) -> &'static [Named] {
    match (options.features, options.aovs) {
        (true, _) if fur == FurLayers::Shells => &PLANES[..19],
        (true, _) => &PLANES,
        (false, true) => &PLANES[..16],
        (false, false) => &PLANES[..4],
    }
}

/// Number of planes that the film pass writes for [`kept`].
pub fn written(options: &RenderOptions<'_>, fur: FurLayers) -> u32 {
    match kept(options, fur).len() {
        4 => 4,
        16 => 20,
        19 => 23,
        _ => 32,
    }
}

/// Number of objects whose coverage a rendering keeps.
pub fn objects(options: &RenderOptions<'_>, world: &World) -> u32 {
    let kept = options.features && world.scene.render.fur != FurLayers::Shells;
    if kept { world.objects.len() as u32 } else { 0 }
}

/// Number of planes for the coverage of the skin and of each of `objects` objects; without objects
/// `base.A` is that of the skin.
pub fn of_objects(objects: u32) -> u32 {
    if objects > 0 { 1 + objects } else { 0 }
}

/// Name of the plane of an object's coverage, by its number in the scene from 0; their sum and
/// [`SKIN_COVERAGE`] is `base.A`.
pub fn object_coverage(number: usize) -> String {
    format!("object{}.A", number + 1)
}

/// Plane of the coverage of the skin where a scene has objects.
pub const SKIN_COVERAGE: &str = "skin.A";

/// Copies the pixels of a tile, plane by plane as the film pass writes them, into the film. Depth
/// becomes the opacity-weighted mean, infinite where the weight is at most 1e-4.
pub fn write_tile(job: &Job, pixels: &[f32], film: &mut Film) {
    let width = film.width as usize;
    let [w, h] = job.size.map(|s| s as usize);
    let [x0, y0] = job.origin.map(|s| s as usize);
    let plane = |p: usize| &pixels[p * w * h..(p + 1) * w * h];
    for (k, target) in film.planes.iter_mut().enumerate() {
        // The coverages of objects follow all others, of which number 19 is none of the film.
        let number = PLANES.get(k).map_or(k + 1, |named| named.number);
        let depth = target.name == "depth.Z";
        for y in 0..h {
            for x in 0..w {
                let i = y * w + x;
                target.data[(y0 + y) * width + x0 + x] = match depth {
                    true if plane(19)[i] > 1e-4 => plane(18)[i] / plane(19)[i],
                    true => f32::INFINITY,
                    false => plane(number)[i],
                };
            }
        }
    }
}

/// A black film with the planes that a rendering keeps.
pub fn blank_film(options: &RenderOptions<'_>, world: &World) -> Film {
    let FilmSpec { width, height, .. } = world.scene.film;
    let plane = |name: String, full_precision: bool| Plane {
        name,
        full_precision,
        data: vec![0.0; width as usize * height as usize],
    };
    let kept = kept(options, world.scene.render.fur);
    let mut planes: Vec<_> =
        kept.iter().map(|named| plane(named.name.into(), named.full_precision)).collect();
    let objects = objects(options, world);
    if objects > 0 {
        planes.push(plane(SKIN_COVERAGE.into(), false));
        planes.extend((0..objects as usize).map(|k| plane(object_coverage(k), false)));
    }
    Film { width, height, planes }
}
