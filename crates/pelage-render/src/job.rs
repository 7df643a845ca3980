//! The parts of a film that are rendered one after the other.

use pelage_core::film::composite::crop_pixels;

/// A tile: a rectangle of pixels, and the bin of strands that may touch it.
#[derive(Debug, Clone, Copy)]
pub struct Job {
    /// Upper left pixel.
    pub origin: [u32; 2],
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Number of the tile that holds it, row by row.
    pub(crate) bin: u32,
}

impl Job {
    /// Tiles with edges of `edge` pixels that cover a film of `size` pixels, row by row, cut to
    /// `crop` (x0 x1 y0 y1 in 0..1).
    pub fn grid(size: [u32; 2], edge: u32, crop: Option<[f32; 4]>) -> Vec<Self> {
        let [low, high] = crop_pixels(size, crop.unwrap_or([0.0, 1.0, 0.0, 1.0]));
        let grid = size.map(|s| s.div_ceil(edge));
        let mut jobs = Vec::new();
        for y in 0..grid[1] {
            for x in 0..grid[0] {
                let origin = [(x * edge).max(low[0]), (y * edge).max(low[1])];
                let end = [((x + 1) * edge).min(high[0]), ((y + 1) * edge).min(high[1])];
                if origin[0] < end[0] && origin[1] < end[1] {
                    let size = [end[0] - origin[0], end[1] - origin[1]];
                    jobs.push(Self { origin, size, bin: y * grid[0] + x });
                }
            }
        }
        jobs
    }
}
