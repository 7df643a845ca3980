//! Names of a film's planes, and copying of finished tiles into them.

use crate::job::Job;
use pelage_core::film::{Film, Plane};

/// Copies the pixels of a tile, plane by plane as the film pass writes them, into the film. Depth
/// becomes the opacity-weighted mean, infinite where the weight is at most 1e-4.
pub fn write_tile(job: &Job, pixels: &[f32], film: &mut Film) {
    let width = film.width as usize;
    let [w, h] = job.size.map(|s| s as usize);
    let [x0, y0] = job.origin.map(|s| s as usize);
    let plane = |p: usize| &pixels[p * w * h..(p + 1) * w * h];
    for (p, target) in film.planes.iter_mut().enumerate() {
        for y in 0..h {
            for x in 0..w {
                let i = y * w + x;
                target.data[(y0 + y) * width + x0 + x] = match target.name.as_str() {
                    "depth.Z" if plane(19)[i] > 1e-4 => plane(18)[i] / plane(19)[i],
                    "depth.Z" => f32::INFINITY,
                    _ => plane(p)[i],
                };
            }
        }
    }
}

/// Names of the planes in the order in which the film pass writes them, and whether they are
/// written in full precision. The pass writes a 20th plane, the weight of the depth.
pub const PLANES: [(&str, bool); 19] = [
    ("R", false),
    ("G", false),
    ("B", false),
    ("A", false),
    ("guard.R", false),
    ("guard.G", false),
    ("guard.B", false),
    ("undercoat.R", false),
    ("undercoat.G", false),
    ("undercoat.B", false),
    ("base.R", false),
    ("base.G", false),
    ("base.B", false),
    ("N.X", true),
    ("N.Y", true),
    ("N.Z", true),
    ("transmittance.Y", true),
    ("fragments.Y", true),
    ("depth.Z", true),
];

/// A black film with all [`PLANES`] if `aovs`, else with the first four.
pub fn blank_film(width: u32, height: u32, aovs: bool) -> Film {
    let mut film = Film { width, height, planes: Vec::new() };
    let kept = if aovs { PLANES.len() } else { 4 };
    for (name, full_precision) in &PLANES[..kept] {
        let data = vec![0.0; width as usize * height as usize];
        film.planes.push(Plane { name: (*name).into(), full_precision: *full_precision, data });
    }
    film
}
