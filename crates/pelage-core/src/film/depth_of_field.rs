//! Depth of field as a post-process.
//!
//! Every pixel becomes a disc, its circle of confusion. A pixel gathers its neighbours in three
//! classes by their signed circle of confusion, which grows with depth:
//!
//! * **front** (nearer by more than a pixel of blur): counts where its own disc covers the pixel.
//!   Out-of-focus things in front bleed over sharp ones.
//! * **same** (within a pixel of blur): counts where its own disc covers the pixel.
//! * **behind**: fills what the `same` class leaves uncovered, as far as the pixel's own disc
//!   reaches. The disc of a sharp pixel reaches no neighbour, so that nothing behind bleeds over
//!   it.
//!
//! With F, S and the coverages f, s the sums of front and same (each neighbour weighted by 1 / area
//! of its disc) and B the mean of behind: `F + (1 - f) (S + (1 - s) B)`. Coverages above 1 are
//! scaled to 1; where nothing lies behind, S is scaled to full coverage.

use super::Film;
use crate::scene::{Camera, LensMethod};
use crate::{Error, Result};
use glam::Vec3;
use rayon::prelude::*;

/// Largest radius of a disc, pixels; larger ones are reduced to it.
pub const MAX_RADIUS: f32 = 64.0;

/// Steps of the radius per pixel: radii are rounded, so that the discs' areas can be tabulated.
const PARTS: f32 = 16.0;

/// Edge of the blocks that share a search radius, pixels.
const BLOCK: usize = 16;

/// Signed diameter of the circle of confusion, pixels: positive behind the plane in focus.
///
/// `aperture` is the diameter of the lens, `z` the depth and `focus` the distance of the plane in
/// focus, cm; `focal_pixels` is film height / (2 tan(fov / 2)).
// [Potmesil1981], thin lens
pub fn circle_of_confusion(aperture: f32, focus: f32, focal_pixels: f32, z: f32) -> f32 {
    let scale = aperture * focal_pixels / focus;
    if z.is_finite() { scale * (z - focus) / z.max(1e-6) } else { scale }
}

/// Blurs `R G B A` and all planes whose names end in `.R`, `.G`, `.B` or `.A`, all premultiplied,
/// by the depths in `depth.Z`. Does nothing for a camera without a lens or with one whose method is
/// not `post`. Several threads; the result does not depend on their number.
///
/// # Errors
/// [`Error::Unsupported`] if the film has no `depth.Z`; [`Error::Scene`] if lens or camera are out
/// of range.
pub fn apply(film: &mut Film, camera: &Camera) -> Result<()> {
    let Some(lens) = camera.lens.as_ref().filter(|lens| lens.method == LensMethod::Post) else {
        return Ok(());
    };
    let focus = lens.focus.unwrap_or_else(|| (Vec3::from(camera.target) - Vec3::from(camera.eye)).length());
    let sensible = |v: f32| v.is_finite() && v > 0.0;
    if !sensible(focus) || !lens.aperture.is_finite() || lens.aperture < 0.0 {
        return Err(Error::fault(
            "camera.lens",
            format!(
                "found aperture {} cm and focus {focus} cm, expected an aperture not below 0 and a focus above 0",
                lens.aperture
            ),
        ));
    }
    if !sensible(camera.fov) || camera.fov >= 180.0 {
        return Err(Error::fault(
            "camera.fov",
            format!("found {}, expected more than 0 and less than 180", camera.fov),
        ));
    }
    film.validate()?;
    let focal_pixels = film.height as f32 / (2.0 * (camera.fov.to_radians() / 2.0).tan());
    let depth = film.plane("depth.Z").ok_or_else(|| {
        Error::Unsupported(
            "found no plane depth.Z in the film, which depth of field as a post-process needs: use camera.lens.method = \"samples\"".into(),
        )
    })?;
    let blur: Vec<f32> = depth
        .iter()
        .map(|z| {
            let limit = 2.0 * MAX_RADIUS;
            circle_of_confusion(lens.aperture, focus, focal_pixels, *z).clamp(-limit, limit)
        })
        .collect();

    let colour = |name: &str| matches!(name.rsplit('.').next(), Some("R" | "G" | "B" | "A"));
    let chosen: Vec<usize> = (0..film.planes.len()).filter(|i| colour(&film.planes[*i].name)).collect();
    // Four planes at a time share the weights of their neighbourhood.
    for group in chosen.chunks(4) {
        let pixels: Vec<[f32; 4]> = (0..film.pixels())
            .map(|p| std::array::from_fn(|c| group.get(c).map_or(0.0, |plane| film.planes[*plane].data[p])))
            .collect();
        let blurred = gather(&pixels, &blur, [film.width as usize, film.height as usize]);
        for (c, plane) in group.iter().enumerate() {
            film.planes[*plane].data.iter_mut().zip(&blurred).for_each(|(to, from)| *to = from[c]);
        }
    }
    Ok(())
}

/// Radius of a disc, rounded to the steps of the area table.
fn radius_of(blur: f32) -> f32 {
    (blur.abs() * (0.5 * PARTS)).round() / PARTS
}

/// Share of a pixel at `distance` that a disc covers.
fn coverage(radius: f32, distance: f32) -> f32 {
    (radius + 0.5 - distance).clamp(0.0, 1.0)
}

/// Sum of [`coverage`] over all pixels, for each step of the radius up to `largest`.
fn areas(largest: f32) -> Vec<f32> {
    let steps = (largest * PARTS).round() as usize;
    (0..=steps)
        .into_par_iter()
        .map(|step| {
            let radius = step as f32 / PARTS;
            let reach = (radius + 0.5).floor() as i32;
            let sum: f64 = (-reach..=reach)
                .flat_map(|y| (-reach..=reach).map(move |x| ((x * x + y * y) as f32).sqrt()))
                .map(|distance| f64::from(coverage(radius, distance)))
                .sum();
            sum as f32
        })
        .collect()
}

/// For each block of pixels, the largest distance of a disc that may touch it, pixels.
fn search_radii(radii: &[f32], [width, height]: [usize; 2]) -> (Vec<f32>, usize) {
    let [columns, rows] = [width.div_ceil(BLOCK), height.div_ceil(BLOCK)];
    let mut largest = vec![0f32; columns * rows];
    for (i, radius) in radii.iter().enumerate() {
        let block = &mut largest[i / width / BLOCK * columns + i % width / BLOCK];
        *block = block.max(*radius);
    }
    let far = (MAX_RADIUS / BLOCK as f32).ceil() as usize + 1;
    let reach = |i: usize| {
        let (bx, by) = (i % columns, i / columns);
        let mut reach = 0f32;
        for y in by.saturating_sub(far)..(by + far + 1).min(rows) {
            for x in bx.saturating_sub(far)..(bx + far + 1).min(columns) {
                // Pixels between the blocks, along the longer axis.
                let gap = bx.abs_diff(x).max(by.abs_diff(y)).saturating_sub(1) * BLOCK;
                let radius = largest[y * columns + x];
                if radius + 0.5 > gap as f32 {
                    reach = reach.max(radius);
                }
            }
        }
        reach
    };
    ((0..columns * rows).map(reach).collect(), columns)
}

/// The three classes of the module's documentation, for four planes.
fn gather(pixels: &[[f32; 4]], blur: &[f32], [width, height]: [usize; 2]) -> Vec<[f32; 4]> {
    let radii: Vec<f32> = blur.iter().map(|b| radius_of(*b)).collect();
    let areas = areas(radii.iter().copied().fold(0.0, f32::max));
    let area = |radius: f32| areas[(radius * PARTS).round() as usize];
    let (search, columns) = search_radii(&radii, [width, height]);
    let mut result = vec![[0f32; 4]; pixels.len()];
    result.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for (x, out) in row.iter_mut().enumerate() {
            let here = y * width + x;
            let reach = (search[y / BLOCK * columns + x / BLOCK] + 0.5).floor() as usize;
            // Weighted sums and weights of front, same, behind.
            let mut sums = [[0f32; 4]; 3];
            let mut weights = [0f32; 3];
            for ny in y.saturating_sub(reach)..(y + reach + 1).min(height) {
                for nx in x.saturating_sub(reach)..(x + reach + 1).min(width) {
                    let there = ny * width + nx;
                    let behind = blur[there] > blur[here] + 1.0;
                    let radius = if behind { radii[here] } else { radii[there] };
                    let (dx, dy) = (nx.abs_diff(x), ny.abs_diff(y));
                    let covered = coverage(radius, ((dx * dx + dy * dy) as f32).sqrt());
                    if covered > 0.0 {
                        let class = if behind { 2 } else { usize::from(blur[there] >= blur[here] - 1.0) };
                        let weight = covered / area(radius);
                        weights[class] += weight;
                        sums[class].iter_mut().zip(pixels[there]).for_each(|(s, v)| *s += weight * v);
                    }
                }
            }
            let [front, same, behind] = weights;
            // The pixel itself is of the class `same`, so its weight is above 0.
            let scale_same = if same > 1.0 || behind <= 0.0 { 1.0 / same } else { 1.0 };
            let fill = if behind > 0.0 { (1.0 - same).max(0.0) / behind } else { 0.0 };
            let scale_front = if front > 1.0 { 1.0 / front } else { 1.0 };
            let through = (1.0 - front).max(0.0);
            *out = std::array::from_fn(|c| {
                sums[0][c] * scale_front + through * (sums[1][c] * scale_same + fill * sums[2][c])
            });
        }
    });
    result
}
