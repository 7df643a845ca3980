//! Films to write, read and compare.

use pelage_core::film::Film;
use pelage_core::scene::{FilmSpec, Tonemap};

/// Film settings that leave values as they are.
pub fn plain() -> FilmSpec {
    FilmSpec { tonemap: Tonemap::None, exposure: 0.0, ..FilmSpec::default() }
}

/// Ramps of red and green; the right half fades from transparent to opaque.
pub fn chart(width: u32, height: u32) -> Film {
    let (w, h) = (width as f32, height as f32);
    let pixels: Vec<[f32; 4]> = (0..width * height)
        .map(|i| {
            let (x, y) = ((i % width) as f32 / w, (i / width) as f32 / h);
            let alpha = if x < 0.5 { 1.0 } else { y };
            [x * alpha, y * alpha, 0.25 * alpha, alpha]
        })
        .collect();
    Film::from_premultiplied(width, height, &pixels)
}
