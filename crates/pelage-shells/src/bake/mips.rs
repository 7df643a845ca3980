//! Mip chains that preserve coverage.

use super::Texture;

/// What a mip chain preserves of its finest level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Keep {
    /// Mean coverage and mean premultiplied colour, for blended layers. The stack of filtered
    /// layers is slightly more opaque than the filtered stack, because hairs that continue through
    /// several layers are then no longer hidden behind one another.
    Mean,
    /// Fraction of texels whose coverage is at least this threshold in 0..1, for alpha-tested
    /// layers: coverage and colour are scaled in each level. The mean is not preserved.
    Share(f32),
}

/// Width and height of mip level `level`: halved `level` times, rounded down, at least 1.
pub fn size(size: [u32; 2], level: u32) -> [u32; 2] {
    size.map(|n| n.checked_shr(level).unwrap_or(0).max(1))
}

/// Number of levels of a complete chain, the finest included, down to 1 x 1.
pub fn levels(size: [u32; 2]) -> u32 {
    32 - size[0].max(size[1]).max(1).leading_zeros()
}

/// The complete chain, starting with the unchanged finest level.
pub fn chain(base: &Texture, keep: Keep) -> Vec<Texture> {
    let mut filtered = vec![base.clone()];
    for level in 1..levels([base.width, base.height]) {
        let to = size([base.width, base.height], level);
        if let Some(next) = filtered.last().map(|finer| resize(finer, to)) {
            filtered.push(next);
        }
    }
    if let Keep::Share(threshold) = keep {
        let wanted = share(base, threshold);
        // Levels are filtered from unscaled ones, so that errors do not accumulate.
        filtered.iter_mut().skip(1).for_each(|level| scale_to_share(level, threshold, wanted));
    }
    filtered
}

/// Mean coverage.
pub fn mean_coverage(texture: &Texture) -> f64 {
    texture.texels.iter().map(|t| f64::from(t[3])).sum::<f64>() / texture.texels.len().max(1) as f64
}

/// Fraction of the texels whose coverage is at least `threshold`.
pub fn share(texture: &Texture, threshold: f32) -> f64 {
    let above = texture.texels.iter().filter(|t| t[3] >= threshold).count();
    above as f64 / texture.texels.len().max(1) as f64
}

/// Box filter of premultiplied texels: each texel of the result is the mean over its area, partial
/// texels included, so that means are preserved for any size. No box extends beyond the texture, so
/// wrapping does not matter.
fn resize(from: &Texture, [width, height]: [u32; 2]) -> Texture {
    let (columns, rows) = (taps(from.width, width), taps(from.height, height));
    let mut texels = Vec::with_capacity(width as usize * height as usize);
    for row in &rows {
        for column in &columns {
            let mut sum = [0.0f64; 4];
            for &(j, v) in row {
                for &(i, u) in column {
                    let texel = from.texels.get(j * from.width as usize + i).copied().unwrap_or_default();
                    (0..4).for_each(|c| sum[c] += v * u * f64::from(texel[c]));
                }
            }
            texels.push(sum.map(|s| s as f32));
        }
    }
    Texture { width, height, texels }
}

/// For each of `to` texels along an axis, the indices of the `from` texels that it covers and their
/// weights, which sum to 1.
fn taps(from: u32, to: u32) -> Vec<Vec<(usize, f64)>> {
    let (from, to) = (u64::from(from), u64::from(to));
    // In units of 1/`to` of a fine texel all positions are integers.
    let cover = |i: u64| {
        let (start, end) = (i * from, (i + 1) * from);
        (start / to..end.div_ceil(to))
            .map(|k| (k as usize, ((end.min((k + 1) * to) - start.max(k * to)) as f64) / from as f64))
            .collect()
    };
    (0..to).map(cover).collect()
}

/// Scales coverage and colour so that the fraction `wanted` of the texels reaches the threshold, as
/// nearly as their number and equal values allow.
// [Castano2010]. DEVIATION: the scale is found by sorting instead of bisection. The threshold is
// placed midway between the last texel that shall pass and the first that shall not, so that
// rounding to 8 bits seldom changes the result.
fn scale_to_share(level: &mut Texture, threshold: f32, wanted: f64) {
    let mut coverage: Vec<f32> = level.texels.iter().map(|t| t[3]).filter(|a| *a > 0.0).collect();
    coverage.sort_by(|a, b| b.total_cmp(a));
    let passing = (wanted * level.texels.len() as f64).round() as usize;
    // Equal texels pass or fail together.
    let apart = |n: &usize| *n == 0 || *n == coverage.len() || coverage[n - 1] > coverage[*n];
    let Some(passing) = (0..=coverage.len()).filter(apart).min_by_key(|n| n.abs_diff(passing)) else {
        return;
    };
    let last_in = passing.checked_sub(1).map(|i| coverage[i]);
    let first_out = coverage.get(passing).copied();
    if last_in.is_none_or(|a| a >= threshold) && first_out.is_none_or(|a| a < threshold) {
        return;
    }
    // At the ends by one step of 8 bits.
    let middle = match (last_in, first_out) {
        (Some(last), Some(first)) => 0.5 * (last + first),
        (Some(last), None) => last * (1.0 - 1.0 / 256.0),
        (None, first) => first.unwrap_or(threshold) * (1.0 + 1.0 / 256.0),
    };
    for texel in &mut level.texels {
        let scaled = (texel[3] * threshold / middle).min(1.0);
        let factor = if texel[3] > 0.0 { scaled / texel[3] } else { 0.0 };
        *texel = [texel[0] * factor, texel[1] * factor, texel[2] * factor, scaled];
    }
}
