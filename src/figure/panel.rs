//! Pictures side by side on white, each with its label under it.

use crate::Result;
use crate::film::Film;
use crate::film::composite::over;
use crate::film::tonemap::{display_rgb8, srgb_decode};
use crate::scene::FilmSpec;
use font8x8::UnicodeFonts;
use glam::Vec3;

const WHITE: [f32; 4] = [1.0; 4];
const BLACK: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// A picture as a display shows it.
pub(super) struct Picture {
    width: usize,
    height: usize,
    /// Display-linear, opaque.
    pixels: Vec<[f32; 4]>,
    label: String,
}

impl Picture {
    /// A film through its exposure and tone mapping, over white where it is transparent.
    pub(super) fn of(film: &Film, spec: &FilmSpec, label: String) -> Result<Self> {
        let pixels = film
            .premultiplied()?
            .iter()
            .map(|&[r, g, b, a]| {
                let alpha = a.clamp(0.0, 1.0);
                let straight = if alpha > 0.0 { Vec3::new(r, g, b) / alpha } else { Vec3::ZERO };
                // The codes that a PNG of this film alone has.
                let [r, g, b] =
                    display_rgb8(straight, spec).map(|code| alpha * srgb_decode(f32::from(code) / 255.0));
                over([r, g, b, alpha], WHITE)
            })
            .collect();
        Ok(Self { width: film.width as usize, height: film.height as usize, pixels, label })
    }
}

/// The sheet: `columns` pictures a row, row by row. Its pixels are display-linear.
pub(super) fn assemble(pictures: &[Picture], columns: u32) -> Film {
    let columns = (columns as usize).clamp(1, pictures.len().max(1));
    let rows = pictures.len().div_ceil(columns);
    let widest = pictures.iter().map(|p| p.width).max().unwrap_or(1);
    let highest = pictures.iter().map(|p| p.height).max().unwrap_or(1);
    let scale = (widest / 320).max(1);
    let (gap, strip) = (4 * scale, 14 * scale);
    let width = columns * widest + (columns + 1) * gap;
    let height = rows * (highest + strip) + (rows + 1) * gap;
    let mut sheet = Sheet { width, pixels: vec![WHITE; width * height] };
    for (i, picture) in pictures.iter().enumerate() {
        let x = gap + (i % columns) * (widest + gap);
        let y = gap + (i / columns) * (highest + strip + gap);
        for (row, line) in picture.pixels.chunks(picture.width.max(1)).enumerate() {
            let at = (y + row) * width + x;
            sheet.pixels[at..at + line.len()].copy_from_slice(line);
        }
        sheet.write(&picture.label, [x, y + picture.height + 4 * scale], widest / (8 * scale), scale);
    }
    Film::from_premultiplied(width as u32, height as u32, &sheet.pixels)
}

/// Grey with words in its middle, where a picture is missing. Display-linear.
pub(super) fn slot(width: u32, height: u32, words: &str) -> Film {
    let [w, h] = [width as usize, height as usize];
    let mut sheet = Sheet { width: w, pixels: vec![[0.6, 0.6, 0.6, 1.0]; w * h] };
    if h > 16 && w > 16 {
        sheet.write(words, [8, h / 2 - 4], (w - 8) / 8, 1);
    }
    Film::from_premultiplied(width, height, &sheet.pixels)
}

struct Sheet {
    width: usize,
    pixels: Vec<[f32; 4]>,
}

impl Sheet {
    /// Writes at most `most` characters of `text` in black, 8 x 8 dots each, a dot `scale` pixels wide.
    fn write(&mut self, text: &str, [x, y]: [usize; 2], most: usize, scale: usize) {
        for (i, c) in text.chars().take(most).enumerate() {
            let glyph =
                font8x8::BASIC_FONTS.get(c).or_else(|| font8x8::BASIC_FONTS.get('?')).unwrap_or_default();
            for (row, bits) in glyph.iter().enumerate() {
                for column in (0..8).filter(|bit| bits >> bit & 1 == 1) {
                    for dot in 0..scale * scale {
                        let px = x + (8 * i + column) * scale + dot % scale;
                        let py = y + row * scale + dot / scale;
                        self.pixels[py * self.width + px] = BLACK;
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(width: u32, height: u32, label: &str) -> Picture {
        let pixels = vec![[0.2, 0.2, 0.2, 1.0]; (width * height) as usize];
        let film = Film::from_premultiplied(width, height, &pixels);
        let spec = FilmSpec { tonemap: crate::scene::Tonemap::None, ..FilmSpec::default() };
        Picture::of(&film, &spec, label.into()).unwrap()
    }

    #[test]
    fn pictures_stand_side_by_side_with_their_labels() {
        let sheet = assemble(
            &[grey(40, 20, "(a) x"), grey(40, 20, "(b) y"), grey(40, 20, "far too long a label")],
            2,
        );
        assert_eq!((sheet.width, sheet.height), (2 * 40 + 3 * 4, 2 * (20 + 14) + 3 * 4));
        let red = sheet.plane("R").unwrap();
        let at = |x: usize, y: usize| red[y * sheet.width as usize + x];
        assert!((at(10, 10) - 0.2).abs() < 0.01 && (at(60, 10) - 0.2).abs() < 0.01);
        assert_eq!((at(0, 0), at(46, 10), at(60, 50)), (1.0, 1.0, 1.0));
        let dark = |x0: usize, x1: usize, y0: usize, y1: usize| {
            (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))).filter(|(x, y)| at(*x, *y) == 0.0).count()
        };
        assert!(dark(4, 44, 25, 37) > 20 && dark(48, 88, 25, 37) > 20);
        assert_eq!(dark(0, 92, 0, 24), 0);
    }
}
