//! Names of a film's planes, and copying of finished tiles into them.

use crate::job::Job;
use crate::options::RenderOptions;
use pelage_core::film::{Film, Plane};
use pelage_core::scene::FurLayers;

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

/// Planes of the coverage of guard hairs, undercoat and skin, which add up to `A`.
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

/// Copies the pixels of a tile, plane by plane as the film pass writes them, into the film. Depth
/// becomes the opacity-weighted mean, infinite where the weight is at most 1e-4.
pub fn write_tile(job: &Job, pixels: &[f32], film: &mut Film) {
    let width = film.width as usize;
    let [w, h] = job.size.map(|s| s as usize);
    let [x0, y0] = job.origin.map(|s| s as usize);
    let plane = |p: usize| &pixels[p * w * h..(p + 1) * w * h];
    for (target, named) in film.planes.iter_mut().zip(&PLANES) {
        for y in 0..h {
            for x in 0..w {
                let i = y * w + x;
                target.data[(y0 + y) * width + x0 + x] = match named.name {
                    "depth.Z" if plane(19)[i] > 1e-4 => plane(18)[i] / plane(19)[i],
                    "depth.Z" => f32::INFINITY,
                    _ => plane(named.number)[i],
                };
            }
        }
    }
}

/// A black film with the planes that a rendering keeps.
pub fn blank_film(width: u32, height: u32, options: &RenderOptions<'_>, fur: FurLayers) -> Film {
    let plane = |named: &Named| Plane {
        name: named.name.into(),
        full_precision: named.full_precision,
        data: vec![0.0; width as usize * height as usize],
    };
    Film { width, height, planes: kept(options, fur).iter().map(plane).collect() }
}
