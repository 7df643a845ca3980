//! Perspective drawings for figures, on the CPU: triangles, thick lines, and textured quads with a
//! depth buffer.

use glam::{DVec3, Vec2, Vec3};
use pelage_core::film::Film;
use pelage_core::scene::Camera;
use pelage_shells::bake::Texture;

/// Samples along a pixel's side.
const SAMPLES: usize = 3;

/// A drawing; its colours are display-linear.
pub(super) struct Canvas {
    /// Pixels.
    size: [usize; 2],
    colors: Vec<Vec3>,
    depths: Vec<f32>,
    eye: Vec3,
    /// Right, up, forward.
    axes: [Vec3; 3],
    /// Samples per tangent of the angle from the axis.
    scale: f32,
}

/// A point on the canvas: samples to the right and down, and depth, cm.
type Place = Vec3;

impl Canvas {
    /// A white canvas of `size` pixels, seen through a camera.
    pub fn new(camera: &Camera, size: [u32; 2]) -> Self {
        let size = size.map(|n| n as usize);
        let [eye, target, up] = [camera.eye, camera.target, camera.up].map(Vec3::from);
        let forward = (target - eye).normalize_or(Vec3::NEG_Z);
        let right = forward.cross(up).normalize_or(Vec3::X);
        let samples = size[0] * size[1] * SAMPLES * SAMPLES;
        let half = 0.5 * (size[1] * SAMPLES) as f32;
        Self {
            size,
            colors: vec![Vec3::ONE; samples],
            depths: vec![f32::INFINITY; samples],
            eye,
            axes: [right, right.cross(forward), forward],
            scale: half / (0.5 * camera.fov.to_radians()).tan(),
        }
    }

    /// Position of the camera, cm.
    pub fn eye(&self) -> Vec3 {
        self.eye
    }

    fn place(&self, p: Vec3) -> Option<Place> {
        let [right, up, forward] = self.axes;
        let offset = p - self.eye;
        let depth = offset.dot(forward);
        let middle = 0.5 * Vec2::new((self.size[0] * SAMPLES) as f32, (self.size[1] * SAMPLES) as f32);
        let seen = Vec2::new(offset.dot(right), -offset.dot(up)) / depth * self.scale;
        (depth > 1e-3).then(|| (middle + seen).extend(depth))
    }

    /// Calls `paint(sample, weights, depth)` for each visible sample of a triangle; `weights` are
    /// barycentric.
    fn cover(&mut self, corners: [Vec3; 3], nearer: f32, mut paint: impl FnMut(&mut Self, usize, Vec3, f32)) {
        let [Some(a), Some(b), Some(c)] = corners.map(|p| self.place(p)) else { return };
        let [width, height] = self.size.map(|n| n * SAMPLES);
        let area = f64::from((b - a).truncate().perp_dot((c - a).truncate()));
        if area == 0.0 {
            return;
        }
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let range = |low: f32, high: f32, most: usize| {
            (low - 0.5).ceil().max(0.0) as usize..((high + 0.5).floor().clamp(0.0, most as f32) as usize)
        };
        let [p, q, r] = [a, b, c].map(|p| p.truncate().as_dvec2());
        for y in range(low.y, high.y, height) {
            for x in range(low.x, high.x, width) {
                let at = glam::DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
                let seen = DVec3::new(
                    (q - at).perp_dot(r - at),
                    (r - at).perp_dot(p - at),
                    (p - at).perp_dot(q - at),
                ) / area;
                if seen.min_element() < 0.0 {
                    continue;
                }
                // Perspective-correct weights: those on the film divided by the depths.
                let over = seen.as_vec3() / Vec3::new(a.z, b.z, c.z);
                let depth = 1.0 / over.element_sum();
                let i = y * width + x;
                if depth <= self.depths[i] + nearer {
                    paint(self, i, over * depth, depth);
                }
            }
        }
    }

    /// A triangle of one colour.
    pub fn triangle(&mut self, corners: [Vec3; 3], color: Vec3) {
        self.cover(corners, 0.0, |canvas, i, _, depth| {
            canvas.colors[i] = color;
            canvas.depths[i] = depth;
        });
    }

    /// A translucent triangle of one colour, which is not written to the depth buffer.
    pub fn veil(&mut self, corners: [Vec3; 3], color: Vec3, alpha: f32) {
        self.cover(corners, 1e-3, |canvas, i, _, _| {
            canvas.colors[i] = canvas.colors[i].lerp(color, alpha);
        });
    }

    /// A textured quad, blended over the drawing: `corners` in order around it, each with its
    /// texture coordinates. The texture wraps along u, and along v if `wrap_v`.
    pub fn quad(&mut self, corners: [(Vec3, Vec2); 4], texture: &Texture, wrap_v: bool) {
        let [a, b, c, d] = corners;
        for t in [[a, b, c], [a, c, d]] {
            self.cover(t.map(|(p, _)| p), 1e-3, |canvas, i, w, _| {
                let uv = w.x * t[0].1 + w.y * t[1].1 + w.z * t[2].1;
                let texel = texture.bilinear(uv, wrap_v);
                canvas.colors[i] = canvas.colors[i] * (1.0 - texel.w) + texel.truncate();
            });
        }
    }

    /// A line `width` pixels wide; it is drawn over surfaces less than `nearer` cm in front of it.
    pub fn line(&mut self, [a, b]: [Vec3; 2], color: Vec3, width: f32, nearer: f32) {
        self.strand([(a, width), (b, width)], [color; 2], nearer);
    }

    /// A tapered line: its ends with widths in pixels, and their colours. It is written to the
    /// depth buffer.
    pub fn strand(&mut self, [(a, wide), (b, thin)]: [(Vec3, f32); 2], color: [Vec3; 2], nearer: f32) {
        let (Some(p), Some(q)) = (self.place(a), self.place(b)) else { return };
        let [width, height] = self.size.map(|n| n * SAMPLES);
        let [wide, thin] = [wide, thin].map(|w| 0.5 * w * SAMPLES as f32);
        let reach = wide.max(thin);
        let low = (p.min(q) - reach).max(Vec3::ZERO);
        let high = p.max(q) + reach + 1.0;
        let along = (q - p).truncate();
        for y in low.y as usize..(high.y.max(0.0) as usize).min(height) {
            for x in low.x as usize..(high.x.max(0.0) as usize).min(width) {
                let at = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
                let t = ((at - p.truncate()).dot(along) / along.length_squared().max(1e-6)).clamp(0.0, 1.0);
                let depth = p.z + t * (q.z - p.z);
                let i = y * width + x;
                let off = at.distance(p.truncate() + t * along);
                if off <= wide + t * (thin - wide) && depth <= self.depths[i] + nearer {
                    self.colors[i] = color[0].lerp(color[1], t);
                    self.depths[i] = self.depths[i].min(depth);
                }
            }
        }
    }

    /// The drawing, with the mean of the samples in each pixel.
    pub fn film(&self) -> Film {
        let [width, height] = self.size;
        let pixel = |i: usize| {
            let (x, y) = (i % width * SAMPLES, i / width * SAMPLES);
            let rows = (y..y + SAMPLES).map(|row| &self.colors[row * width * SAMPLES + x..][..SAMPLES]);
            let sum: Vec3 = rows.flatten().sum();
            let [r, g, b] = (sum / (SAMPLES * SAMPLES) as f32).to_array();
            [r, g, b, 1.0]
        };
        let pixels: Vec<[f32; 4]> = (0..width * height).map(pixel).collect();
        Film::from_premultiplied(width as u32, height as u32, &pixels)
    }
}

/// Flat shading of a triangle, lit from above the camera: a factor of 0.45 to 1.
pub(super) fn shade(corners: [Vec3; 3], eye: Vec3) -> f32 {
    let [a, b, c] = corners;
    let n = (b - a).cross(c - a).normalize_or_zero();
    let light = ((eye - a).normalize_or_zero() + Vec3::new(-0.3, 0.7, 0.0)).normalize_or_zero();
    0.45 + 0.55 * n.dot(light).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec4;

    fn canvas() -> Canvas {
        Canvas::new(&Camera { eye: [0.0, 0.0, 10.0], fov: 53.130_1, ..Camera::default() }, [40, 20])
    }

    fn at(canvas: &Canvas, x: usize, y: usize) -> Vec3 {
        canvas.colors[(y * SAMPLES + 1) * canvas.size[0] * SAMPLES + x * SAMPLES + 1]
    }

    #[test]
    fn the_nearer_triangle_is_visible_in_any_order() {
        let triangle = |z: f32| [Vec3::new(-3.0, -3.0, z), Vec3::new(3.0, -3.0, z), Vec3::new(0.0, 4.0, z)];
        for order in [[0.0, 1.0], [1.0, 0.0]] {
            let mut canvas = canvas();
            for z in order {
                canvas.triangle(triangle(z), Vec3::new(z, 0.5, 0.5));
            }
            assert_eq!(at(&canvas, 20, 10), Vec3::new(1.0, 0.5, 0.5));
            assert_eq!(at(&canvas, 1, 1), Vec3::ONE, "outside is white");
        }
    }

    #[test]
    fn the_projection_is_that_of_a_pinhole() {
        // At a distance of 10 the view is 10 cm high: two pixels a centimetre.
        let place = canvas().place(Vec3::new(2.0, 1.0, 0.0)).expect("in front");
        assert!((place - Vec3::new(72.0, 24.0, 10.0)).length() < 1e-3, "{place}");
        assert!(canvas().place(Vec3::new(0.0, 0.0, 11.0)).is_none(), "behind the camera");
    }

    #[test]
    fn hidden_lines_are_not_drawn() {
        let mut canvas = canvas();
        let wall = [Vec3::new(-9.0, -9.0, 1.0), Vec3::new(9.0, -9.0, 1.0), Vec3::new(0.0, 20.0, 1.0)];
        canvas.triangle(wall, Vec3::splat(0.5));
        let line = |z: f32| [Vec3::new(-3.0, 0.0, z), Vec3::new(3.0, 0.0, z)];
        canvas.line(line(0.0), Vec3::ZERO, 2.0, 0.1);
        assert_eq!(at(&canvas, 20, 10), Vec3::splat(0.5));
        canvas.line(line(2.0), Vec3::ZERO, 2.0, 0.1);
        assert_eq!(at(&canvas, 20, 10), Vec3::ZERO);
    }

    #[test]
    fn textures_wrap_and_are_interpolated() {
        let texture = Texture { width: 2, height: 1, texels: vec![[0.0; 4], [1.0; 4]] };
        assert_eq!(texture.bilinear(Vec2::new(0.25, 0.5), true), Vec4::ZERO);
        assert_eq!(texture.bilinear(Vec2::new(0.5, 0.5), true), Vec4::splat(0.5));
        assert_eq!(texture.bilinear(Vec2::new(1.0, 0.5), true), Vec4::splat(0.5), "across the edge");
    }
}
