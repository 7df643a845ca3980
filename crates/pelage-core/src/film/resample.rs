//! Scaling an image so that it covers a film.

use rayon::prelude::*;

/// Scales `source` (premultiplied linear pixels row by row; `size`: width and height) so that it
/// covers `to`. The aspect ratio is kept; excess is cropped equally on both sides. Tent filter, as
/// wide as a source pixel when enlarging and as a target pixel when shrinking; edge pixels repeat.
///
/// If both sizes are the same, so are the pixels. Both sizes are at least 1 x 1.
pub fn cover(source: &[[f32; 4]], size: [usize; 2], to: [usize; 2]) -> Vec<[f32; 4]> {
    let scale = (size[0] as f64 / to[0] as f64).min(size[1] as f64 / to[1] as f64);
    let columns = taps(size[0], to[0], scale);
    let rows = taps(size[1], to[1], scale);
    let mut narrow = vec![[0.0f32; 4]; to[0] * size[1]];
    narrow.par_chunks_mut(to[0]).zip(source.par_chunks(size[0])).for_each(|(out, row)| {
        for (pixel, taps) in out.iter_mut().zip(&columns) {
            *pixel = weighted(taps, |i| row[i]);
        }
    });
    let mut result = vec![[0.0f32; 4]; to[0] * to[1]];
    result.par_chunks_mut(to[0]).zip(&rows).for_each(|(out, taps)| {
        for (x, pixel) in out.iter_mut().enumerate() {
            *pixel = weighted(taps, |i| narrow[i * to[0] + x]);
        }
    });
    result
}

fn weighted(taps: &[(usize, f32)], at: impl Fn(usize) -> [f32; 4]) -> [f32; 4] {
    taps.iter().fold([0.0; 4], |sum, (i, w)| {
        let value = at(*i);
        std::array::from_fn(|c| sum[c] + w * value[c])
    })
}

/// Source indices and weights of each target pixel along one axis; `scale` is source pixels per
/// target pixel.
fn taps(size: usize, to: usize, scale: f64) -> Vec<Vec<(usize, f32)>> {
    let start = (size as f64 - to as f64 * scale) / 2.0;
    let radius = scale.max(1.0);
    let of = |target: usize| {
        let center = start + (target as f64 + 0.5) * scale;
        let range = (center - radius).floor() as i64..=(center + radius).ceil() as i64;
        let raw: Vec<(usize, f64)> = range
            .map(|i| (i.clamp(0, size as i64 - 1) as usize, 1.0 - ((i as f64 + 0.5 - center) / radius).abs()))
            .filter(|(_, w)| *w > 0.0)
            .collect();
        let sum: f64 = raw.iter().map(|(_, w)| w).sum();
        raw.into_iter().map(|(i, w)| (i, (w / sum) as f32)).collect()
    };
    (0..to).map(of).collect()
}
