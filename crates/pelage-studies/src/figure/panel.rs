//! Pictures side by side on white, each with its label below.

use glam::Vec3;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};
use pelage_core::Result;
use pelage_core::film::Film;
use pelage_core::film::composite::over;
use pelage_core::film::tonemap::{display_rgb8, srgb_decode};
use pelage_core::scene::FilmSpec;

const WHITE: [f32; 4] = [1.0; 4];

/// A picture in display-linear colours, with its label.
pub(super) struct Picture {
    width: usize,
    height: usize,
    /// Display-linear, opaque.
    pixels: Vec<[f32; 4]>,
    label: String,
}

impl Picture {
    /// A film after exposure and tone mapping, over white.
    pub(super) fn of(film: &Film, spec: &FilmSpec, label: String) -> Result<Self> {
        let pixels = film
            .premultiplied()?
            .iter()
            .map(|&[r, g, b, a]| {
                let alpha = a.clamp(0.0, 1.0);
                let straight = if alpha > 0.0 { Vec3::new(r, g, b) / alpha } else { Vec3::ZERO };
                // The code values that a PNG file of this film has.
                let [r, g, b] =
                    display_rgb8(straight, spec).map(|code| alpha * srgb_decode(f32::from(code) / 255.0));
                over([r, g, b, alpha], WHITE)
            })
            .collect();
        Ok(Self { width: film.width as usize, height: film.height as usize, pixels, label })
    }
}

/// The sheet, row by row with `columns` pictures each; every column is as wide as the widest
/// picture. Its pixels are display-linear.
pub(super) fn assemble(pictures: &[Picture], columns: u32) -> Film {
    let columns = (columns as usize).clamp(1, pictures.len().max(1));
    let widest = pictures.iter().map(|p| p.width).max().unwrap_or(1);
    let font = Font::for_width(widest);
    let gap = font.line() / 4;
    let labels: Vec<Vec<String>> = pictures.iter().map(|p| font.wrap(&p.label, widest)).collect();
    let mut sheet = Sheet { width: columns * widest + (columns + 1) * gap, pixels: Vec::new() };
    for (pictures, labels) in pictures.chunks(columns).zip(labels.chunks(columns)) {
        let y = sheet.height() + gap;
        let highest = pictures.iter().map(|p| p.height).max().unwrap_or(1);
        let lines = labels.iter().map(Vec::len).max().unwrap_or(0);
        sheet.grow(gap + highest + lines * font.line() + gap);
        for (k, (picture, label)) in pictures.iter().zip(labels).enumerate() {
            let x = gap + k * (widest + gap);
            for (row, line) in picture.pixels.chunks(picture.width.max(1)).enumerate() {
                let at = (y + row) * sheet.width + x;
                sheet.pixels[at..at + line.len()].copy_from_slice(line);
            }
            for (n, line) in label.iter().enumerate() {
                sheet.write(font, line, [x, y + picture.height + n * font.line()]);
            }
        }
    }
    Film::from_premultiplied(sheet.width as u32, sheet.height() as u32, &sheet.pixels)
}

/// A grey placeholder for a missing picture, with a text in its middle. Display-linear.
pub(super) fn slot(width: u32, height: u32, text: &str) -> Film {
    let [w, h] = [width as usize, height as usize];
    let mut sheet = Sheet { width: w, pixels: vec![[0.6, 0.6, 0.6, 1.0]; w * h] };
    let font = Font::for_width(w);
    for (n, line) in font.wrap(text, w).iter().enumerate() {
        sheet.write(font, line, [0, h / 2 + n * font.line()]);
    }
    Film::from_premultiplied(width, height, &sheet.pixels)
}

/// A monospaced font of one height.
#[derive(Clone, Copy)]
struct Font(RasterHeight);

impl Font {
    fn for_width(width: usize) -> Self {
        Self(match width {
            0..480 => RasterHeight::Size16,
            480..900 => RasterHeight::Size24,
            _ => RasterHeight::Size32,
        })
    }

    /// Pixels from one line to the next.
    fn line(self) -> usize {
        self.0.val() + self.0.val() / 4
    }

    /// Breaks a text into lines of at most `width` pixels; a longer word gets a line of its own.
    fn wrap(self, text: &str, width: usize) -> Vec<String> {
        let most = width / get_raster_width(FontWeight::Regular, self.0);
        let mut lines: Vec<String> = Vec::new();
        for word in text.split_whitespace() {
            match lines.last_mut().filter(|line| line.chars().count() + 1 + word.chars().count() <= most) {
                Some(line) => {
                    line.push(' ');
                    line.push_str(word);
                }
                None => lines.push(word.to_owned()),
            }
        }
        lines
    }
}

struct Sheet {
    width: usize,
    pixels: Vec<[f32; 4]>,
}

impl Sheet {
    fn height(&self) -> usize {
        self.pixels.len() / self.width.max(1)
    }

    fn grow(&mut self, rows: usize) {
        self.pixels.resize(self.pixels.len() + rows * self.width, WHITE);
    }

    /// Writes a line of text in black, clipped to the sheet.
    fn write(&mut self, font: Font, line: &str, [x, y]: [usize; 2]) {
        let step = get_raster_width(FontWeight::Regular, font.0);
        let height = self.height();
        for (i, c) in line.chars().enumerate() {
            let glyph = |c| get_raster(c, FontWeight::Regular, font.0);
            let Some(glyph) = glyph(c).or_else(|| glyph('?')) else { continue };
            for (row, levels) in glyph.rows().enumerate() {
                for (column, level) in levels.iter().enumerate() {
                    let (px, py) = (x + i * step + column, y + row);
                    if *level > 0 && px < self.width && py < height {
                        let pixel = &mut self.pixels[py * self.width + px];
                        let ink = f32::from(*level) / 255.0;
                        (0..3).for_each(|c| pixel[c] *= 1.0 - ink);
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
        let spec = FilmSpec { tonemap: pelage_core::scene::Tonemap::None, ..FilmSpec::default() };
        Picture::of(&film, &spec, label.into()).unwrap()
    }

    #[test]
    fn pictures_are_side_by_side_with_their_labels() {
        let sheet = assemble(
            &[grey(80, 20, "(a) x"), grey(80, 20, "(b) y"), grey(80, 20, "a label of two lines")],
            2,
        );
        // Two rows: gaps of 5, lines of 20.
        assert_eq!((sheet.width, sheet.height), (2 * 80 + 3 * 5, (5 + 20 + 20 + 5) + (5 + 20 + 2 * 20 + 5)));
        let red = sheet.plane("R").unwrap();
        let at = |x: usize, y: usize| red[y * sheet.width as usize + x];
        assert!((at(10, 10) - 0.2).abs() < 0.01 && (at(100, 10) - 0.2).abs() < 0.01);
        assert_eq!((at(0, 0), at(87, 10), at(120, 90)), (1.0, 1.0, 1.0));
        let ink = |x0: usize, x1: usize, y0: usize, y1: usize| {
            (y0..y1).flat_map(|y| (x0..x1).map(move |x| (x, y))).filter(|(x, y)| at(*x, *y) < 0.5).count()
        };
        assert!(ink(5, 60, 25, 45) > 20 && ink(90, 150, 25, 45) > 20);
        assert!(ink(5, 80, 75, 95) > 20 && ink(5, 80, 95, 115) > 20, "both lines of the third");
        assert_eq!(ink(0, 175, 45, 55), 0);
    }
}
