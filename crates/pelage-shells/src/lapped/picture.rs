//! Pictures of patches and of the field, seen from the front, right and above, drawn on the CPU.

use super::{Lapped, contains};
use glam::{Mat3, Vec2, Vec3};
use pelage_core::Skin;
use pelage_core::film::Film;
use pelage_core::film::tonemap::srgb_decode;
use pelage_fur::random::random;
use rayon::prelude::*;

/// Samples per pixel along each axis.
const SAMPLES: usize = 3;

/// Direction from the skin to the camera (orthographic).
const EYE: Vec3 = Vec3::new(0.55, 0.35, 0.85);

/// Marks a sample without a face.
const NONE: u32 = u32::MAX;

/// Draws `skin` in the colours of its patches, with dark seams, on white; `side` pixels along the
/// longer side. Colours are linear and need no tone mapping.
pub fn patch_picture(lapped: &Lapped, skin: &Skin, side: u32) -> Film {
    let view = View::new(skin, side);
    let colors = colors(lapped, skin);
    let layers = layers(lapped, skin);
    let patch_at = |i: usize| match view.face[i] {
        NONE => NONE,
        f => shown(lapped, &layers[f as usize], view.barycentric(skin, i)),
    };
    let patches: Vec<u32> = (0..view.face.len()).into_par_iter().map(patch_at).collect();
    let color = |i: usize| {
        let patch = patches[i];
        if patch == NONE {
            return Vec3::ONE;
        }
        // A seam marks the samples on both sides of it.
        let seam = view
            .beside(i)
            .into_iter()
            .flatten()
            .any(|j| patches[j] != NONE && patches[j] != patch && view.touches(skin, i, j));
        let color = view.shade(skin, i) * colors[patch as usize];
        if seam { color * 0.25 } else { color }
    };
    view.film(&(0..view.face.len()).into_par_iter().map(color).collect::<Vec<_>>())
}

/// Draws `skin` in grey with strokes along the direction of the hair, thick at the root; otherwise
/// as [`patch_picture`].
pub fn field_picture(lapped: &Lapped, skin: &Skin, side: u32) -> Film {
    const SPACING: usize = 12 * SAMPLES;
    const LENGTH: f32 = (20 * SAMPLES) as f32;
    let view = View::new(skin, side);
    let grey = |i: usize| {
        if view.face[i] == NONE { Vec3::ONE } else { view.shade(skin, i) * Vec3::new(0.62, 0.60, 0.57) }
    };
    let mut pixels: Vec<Vec3> = (0..view.face.len()).into_par_iter().map(grey).collect();
    for row in 0..view.height.div_ceil(SPACING) {
        for column in 0..view.width.div_ceil(SPACING) {
            let id = (row * view.width + column) as u32;
            let jitter = 0.25 + 0.5 * Vec2::new(random(id, 0), random(id, 1));
            let mut at = (Vec2::new(column as f32, row as f32) + jitter) * SPACING as f32;
            let mut done = 0.0;
            let mut behind = None;
            while done < LENGTH {
                let Some(i) = view.sample(at).filter(|i| view.face[*i] != NONE) else { break };
                // A stroke does not jump to a surface behind a silhouette.
                if behind.is_some_and(|j| !view.touches(skin, i, j)) {
                    break;
                }
                behind = Some(i);
                let seen = view.to_film * lapped.field[view.face[i] as usize];
                view.dot(&mut pixels, at, 3.2 * (1.0 - done / LENGTH) + 0.4);
                // Strokes are foreshortened with the surface.
                at += Vec2::new(seen.x, -seen.y);
                done += 1.0;
            }
        }
    }
    view.film(&pixels)
}

/// The skin in the view: the visible face of each sample.
struct View {
    width: usize,
    height: usize,
    /// Rows: right, up, towards the camera.
    to_film: Mat3,
    /// Vertices, in samples; z points towards the camera.
    points: Vec<Vec3>,
    face: Vec<u32>,
    depth: Vec<f32>,
}

impl View {
    fn new(skin: &Skin, side: u32) -> Self {
        let back = EYE.normalize();
        let right = Vec3::Y.cross(back).normalize();
        let to_film = Mat3::from_cols(right, back.cross(right), back).transpose();
        let turned: Vec<Vec3> = skin.positions.iter().map(|p| to_film * *p).collect();
        let low = turned.iter().fold(Vec3::INFINITY, |low, p| low.min(*p));
        let high = turned.iter().fold(Vec3::NEG_INFINITY, |high, p| high.max(*p));
        let extent = (high - low).truncate();
        let longest = extent.max_element().max(f32::MIN_POSITIVE);
        let margin = side as f32 * 0.04;
        let scale = (side as f32 - 2.0 * margin) / longest;
        let pixels = (extent * scale + 2.0 * margin).ceil().clamp(Vec2::ONE, Vec2::splat(side as f32));
        let (width, height) = (pixels.x as usize * SAMPLES, pixels.y as usize * SAMPLES);
        let scale = scale * SAMPLES as f32;
        let middle = (low + high) / 2.0;
        let half = Vec2::new(width as f32, height as f32) / 2.0;
        let points = turned.iter().map(|p| {
            let p = (*p - middle) * scale;
            Vec3::new(half.x + p.x, half.y - p.y, p.z)
        });
        let points: Vec<Vec3> = points.collect();
        let (face, depth) = (vec![NONE; width * height], vec![f32::NEG_INFINITY; width * height]);
        let mut view = Self { width, height, to_film, points, face, depth };
        (0..skin.triangles.len()).for_each(|t| view.draw(skin, t));
        view
    }

    /// Draws a triangle with a depth test; of equal depths the first one drawn remains.
    fn draw(&mut self, skin: &Skin, t: usize) {
        let corners = skin.triangles[t].map(|v| self.points[v as usize]);
        let low = corners.iter().fold(Vec3::INFINITY, |low, p| low.min(*p));
        let high = corners.iter().fold(Vec3::NEG_INFINITY, |high, p| high.max(*p));
        let range = |low: f32, high: f32, size: usize| {
            (low - 0.5).ceil().max(0.0) as usize
                ..((high - 0.5).floor() + 1.0).clamp(0.0, size as f32) as usize
        };
        for y in range(low.y, high.y, self.height) {
            for x in range(low.x, high.x, self.width) {
                let Some(b) = weights(&corners, Vec2::new(x as f32 + 0.5, y as f32 + 0.5)) else { return };
                if b.min_element() < 0.0 {
                    continue;
                }
                let z = b.dot(Vec3::new(corners[0].z, corners[1].z, corners[2].z));
                let i = y * self.width + x;
                if z > self.depth[i] {
                    (self.depth[i], self.face[i]) = (z, t as u32);
                }
            }
        }
    }

    /// Barycentric coordinates of a sample in its visible face.
    fn barycentric(&self, skin: &Skin, i: usize) -> Vec3 {
        let corners = skin.triangles[self.face[i] as usize].map(|v| self.points[v as usize]);
        let at = Vec2::new((i % self.width) as f32 + 0.5, (i / self.width) as f32 + 0.5);
        weights(&corners, at).unwrap_or(Vec3::splat(1.0 / 3.0))
    }

    /// Shading of a sample with a face; the inside of open skins is darker.
    fn shade(&self, skin: &Skin, i: usize) -> Vec3 {
        let f = self.face[i] as usize;
        let b = self.barycentric(skin, i);
        let [p, q, r] = skin.triangles[f].map(|v| skin.normals.get(v as usize).copied().unwrap_or_default());
        let n = self.to_film * (p * b.x + q * b.y + r * b.z).normalize_or_zero();
        let [a, c, d] = skin.triangles[f].map(|v| self.points[v as usize]);
        // Rows go down: a face seen from outside is clockwise in samples.
        let outside = (c - a).truncate().perp_dot((d - a).truncate()) < 0.0;
        let (n, dim) = if outside { (n, 1.0) } else { (-n, 0.45) };
        let light = n.dot(Vec3::new(-0.45, 0.6, 0.66).normalize());
        Vec3::splat(dim * (0.28 + 0.72 * (0.5 + 0.5 * light).powi(2)))
    }

    /// Whether two adjacent samples show a connected surface: their depths differ no more than the
    /// slope explains.
    fn touches(&self, skin: &Skin, i: usize, j: usize) -> bool {
        let slope = |i: usize| {
            let [a, b, c] = skin.triangles[self.face[i] as usize].map(|v| self.points[v as usize]);
            let n = (b - a).cross(c - a);
            n.truncate().length() / n.z.abs().max(1e-3 * n.length()).max(f32::MIN_POSITIVE)
        };
        (self.depth[i] - self.depth[j]).abs() < 3.0 + 3.0 * slope(i).max(slope(j)).min(20.0)
    }

    /// The adjacent samples: left, right, above and below.
    fn beside(&self, i: usize) -> [Option<usize>; 4] {
        let column = i % self.width;
        [
            (column > 0).then(|| i - 1),
            (column + 1 < self.width).then_some(i + 1),
            i.checked_sub(self.width),
            (i + self.width < self.face.len()).then_some(i + self.width),
        ]
    }

    fn sample(&self, at: Vec2) -> Option<usize> {
        let inside = at.x >= 0.0 && at.y >= 0.0 && at.x < self.width as f32 && at.y < self.height as f32;
        inside.then(|| at.y as usize * self.width + at.x as usize)
    }

    /// Draws a dark disc.
    fn dot(&self, pixels: &mut [Vec3], at: Vec2, radius: f32) {
        let reach = radius.ceil() as i32;
        for (dy, dx) in (-reach..=reach).flat_map(|dy| (-reach..=reach).map(move |dx| (dy, dx))) {
            let offset = Vec2::new(dx as f32, dy as f32);
            if let Some(i) = self.sample(at + offset).filter(|_| offset.length() <= radius) {
                pixels[i] = Vec3::new(0.10, 0.035, 0.015);
            }
        }
    }

    /// Averages samples over each pixel.
    fn film(&self, samples: &[Vec3]) -> Film {
        let (width, height) = (self.width / SAMPLES, self.height / SAMPLES);
        let pixel = |i: usize| {
            let (x, y) = (i % width * SAMPLES, i / width * SAMPLES);
            let mut sum = Vec3::ZERO;
            for row in y..y + SAMPLES {
                sum += samples[row * self.width + x..][..SAMPLES].iter().sum::<Vec3>();
            }
            let [r, g, b] = (sum / (SAMPLES * SAMPLES) as f32).to_array();
            [r, g, b, 1.0]
        };
        let pixels: Vec<[f32; 4]> = (0..width * height).map(pixel).collect();
        Film::from_premultiplied(width as u32, height as u32, &pixels)
    }
}

/// Barycentric coordinates of `p` on the film; `None` if the triangle's projection has no area.
fn weights(corners: &[Vec3; 3], p: Vec2) -> Option<Vec3> {
    let [a, b, c] = corners.map(|p| p.truncate().as_dvec2());
    let p = p.as_dvec2();
    let area = (b - a).perp_dot(c - a);
    let (s, t) = ((b - p).perp_dot(c - p) / area, (c - p).perp_dot(a - p) / area);
    (area != 0.0).then(|| Vec3::new(s as f32, t as f32, (1.0 - s - t) as f32))
}

/// The patches of each face with the uv of its corners, in the order of pasting; only the topmost
/// if patches do not overlap.
fn layers<'a>(lapped: &'a Lapped, skin: &Skin) -> Vec<Vec<(u32, &'a [Vec2; 3])>> {
    let mut layers = vec![Vec::new(); skin.triangles.len()];
    for (p, patch) in (0_u32..).zip(&lapped.patches) {
        for (f, uv) in patch.faces.iter().zip(&patch.corner_uv) {
            if !patch.outline.is_empty() || lapped.topmost[*f as usize] == p {
                layers[*f as usize].push((p, uv));
            }
        }
    }
    layers
}

/// The last patch whose outline contains the point with barycentric coordinates `b`.
fn shown(lapped: &Lapped, layers: &[(u32, &[Vec2; 3])], b: Vec3) -> u32 {
    let holds = |(p, uv): &&(u32, &[Vec2; 3])| {
        contains(&lapped.patches[*p as usize].outline, uv[0] * b.x + uv[1] * b.y + uv[2] * b.z)
    };
    layers.iter().rev().find(holds).or(layers.last()).map_or(NONE, |(p, _)| *p)
}

/// A linear colour for each patch: of some random ones, the one that differs most from those of its
/// neighbours.
fn colors(lapped: &Lapped, skin: &Skin) -> Vec<Vec3> {
    let neighbours = pelage_core::mesh::topology::neighbours(&skin.triangles).neighbours;
    let mut pairs = Vec::new();
    for (f, around) in neighbours.iter().enumerate() {
        for g in around.iter().filter(|g| **g != pelage_core::skin::NONE) {
            let (p, q) = (lapped.topmost[f], lapped.topmost[*g as usize]);
            if p > q {
                pairs.push((p, q));
            }
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    let mut colors: Vec<Vec3> = Vec::with_capacity(lapped.patches.len());
    let mut pairs = pairs.into_iter().peekable();
    for p in 0..lapped.patches.len() as u32 {
        let mut beside = Vec::new();
        while let Some((_, q)) = pairs.next_if(|(first, _)| *first == p) {
            beside.push(colors[q as usize]);
        }
        let difference = |c: Vec3| beside.iter().map(|o| o.distance(c)).fold(f32::INFINITY, f32::min);
        let (mut best, mut most) = (Vec3::ONE, -1.0);
        for k in 0..8 {
            let color =
                hue(random(p, 3 * k), 0.25 + 0.25 * random(p, 3 * k + 1), 0.72 + 0.28 * random(p, 3 * k + 2));
            if difference(color) > most {
                (best, most) = (color, difference(color));
            }
        }
        colors.push(best);
    }
    colors.into_iter().map(|c| c.map(srgb_decode)).collect()
}

/// Converts hue (0..1), saturation and value to sRGB.
// [Smith1978]
fn hue(h: f32, s: f32, v: f32) -> Vec3 {
    let channel = |k: f32| {
        let x = (k + 6.0 * h).rem_euclid(6.0);
        v - v * s * x.min(4.0 - x).clamp(0.0, 1.0)
    };
    Vec3::new(channel(5.0), channel(3.0), channel(1.0))
}
