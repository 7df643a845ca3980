//! Twin of `shaders/guard_raster.wgsl`: coverage of the guard hairs' ribbons.

use glam::{Vec3, Vec4};
use half::f16;
use pelage_fur::layout::Frame;
use pelage_fur::random::hash2;
use pelage_fur::strands::{opacity, position, radius};
use pelage_fur::view::{film_from_world, samples_per_slope};

/// A fragment of a strand.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fragment {
    /// Sample within the tile.
    pub xy: [u32; 2],
    /// Depth, cm.
    pub z: f32,
    /// Kind and id; breaks ties of depth.
    pub source: u32,
    /// Premultiplied radiance and opacity.
    pub color: Vec4,
}

/// Part of a box one sample wide, at distance `across` from the middle of a ribbon, that the ribbon
/// covers. All lengths in samples.
pub fn ribbon_coverage(across: f32, radius: f32) -> f32 {
    ((across + 0.5).min(radius) - (across - 0.5).max(-radius)).clamp(0.0, 1.0)
}

/// Radiance of a shaded vertex, and whether it is hidden from the camera.
fn unpack_shade(shade: [u32; 2]) -> (Vec3, bool) {
    let half = |word: u32| f16::from_bits(word as u16).to_f32();
    let color = Vec3::new(half(shade[0]), half(shade[0] >> 16), half(shade[1]));
    (color, half(shade[1] >> 16) > 0.5)
}

/// Fragments of segment `k` of a strand with shaded vertices, not tested against the skin. `seed`:
/// that of the root.
pub fn segment(
    frame: &Frame,
    strand: &[[f32; 4]],
    shades: &[[u32; 2]],
    seed: u32,
    k: usize,
) -> Vec<Fragment> {
    let mut fragments = Vec::new();
    let (mut color_a, hidden_a) = unpack_shade(shades[k]);
    let (mut color_b, hidden_b) = unpack_shade(shades[k + 1]);
    if hidden_a && hidden_b {
        return fragments;
    }
    if hidden_a {
        color_a = color_b;
    }
    if hidden_b {
        color_b = color_a;
    }
    let ends = [strand[k], strand[k + 1]];
    let [a, b] = ends.map(|v| film_from_world(frame, position(v)));
    if a.z <= frame.near || b.z <= frame.near {
        return fragments;
    }
    let radius_a = radius(ends[0]) * samples_per_slope(frame) / a.z;
    let radius_b = radius(ends[1]) * samples_per_slope(frame) / b.z;
    let source = hash2(seed, k as u32) & 0x3fff_ffff;
    let d = (b - a).truncate();
    // Columns of samples are visited along the axis of larger extent.
    let (major, minor) = if d.y.abs() > d.x.abs() { (1, 0) } else { (0, 1) };
    let span = d[major];
    let cosine = span.abs() / d.length_squared().max(1e-20).sqrt();
    let tile = |k: usize| frame.tile_origin[k]..frame.tile_origin[k] + frame.tile_size[k] as i32;
    let centre = |x: i32| x as f32 + 0.5;
    let (low, high) = (a[major].min(b[major]), a[major].max(b[major]));
    for column in tile(major).filter(|x| centre(*x) >= low && centre(*x) < high) {
        let u = (centre(column) - a[major]) / span;
        // Parameter along the hair in space: perspective-correct.
        let w = u * a.z / (b.z + (a.z - b.z) * u);
        let z = a.z + (b.z - a.z) * w;
        let radius = radius_a + (radius_b - radius_a) * u;
        let middle = a[minor] + u * d[minor];
        let opaque = opacity(ends[0]) + (opacity(ends[1]) - opacity(ends[0])) * w;
        for row in tile(minor) {
            let alpha = ribbon_coverage((centre(row) - middle).abs() * cosine, radius) * opaque;
            if alpha < 1e-4 {
                continue;
            }
            let mut xy = [0; 2];
            xy[major] = (column - frame.tile_origin[major]) as u32;
            xy[minor] = (row - frame.tile_origin[minor]) as u32;
            fragments.push(Fragment {
                xy,
                z,
                source,
                color: (color_a.lerp(color_b, w) * alpha).extend(alpha),
            });
        }
    }
    fragments
}
