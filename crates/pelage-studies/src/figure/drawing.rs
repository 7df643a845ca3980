//! Drawings of studies: an SVG canvas, a parallel projection, the painter's algorithm, and
//! distinguishable colours.

use crate::report::escape;
use glam::Vec3;
use pelage_core::film::tonemap::srgb_decode;
use std::fmt::Write;

/// A point on the canvas, px from its upper left corner.
pub(super) type Point = [f64; 2];

/// An SVG file under construction. Styles are CSS.
pub(super) struct Canvas {
    size: [f64; 2],
    body: String,
}

/// Which part of a text lies at its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

impl Canvas {
    /// A white canvas.
    pub(super) fn new(width: f64, height: f64) -> Self {
        Self { size: [width, height], body: String::new() }
    }

    pub(super) fn polygon(&mut self, points: &[Point], style: &str) {
        self.points("polygon", points, style);
    }

    pub(super) fn polyline(&mut self, points: &[Point], style: &str) {
        self.points("polyline", points, style);
    }

    fn points(&mut self, element: &str, points: &[Point], style: &str) {
        let list: Vec<String> = points.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
        let _ = write!(self.body, "<{element} points=\"{}\" style=\"{style}\"/>", list.join(" "));
    }

    pub(super) fn line(&mut self, a: Point, b: Point, style: &str) {
        let _ = write!(
            self.body,
            "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" style=\"{style}\"/>",
            a[0], a[1], b[0], b[1]
        );
    }

    /// A line with a head at `b`.
    pub(super) fn arrow(&mut self, a: Point, b: Point, style: &str) {
        self.line(a, b, style);
        let d = [b[0] - a[0], b[1] - a[1]];
        let length = d[0].hypot(d[1]).max(1e-9);
        let [x, y] = d.map(|v| 5.0 * v / length);
        let wing = |side: f64| [b[0] - x + 0.5 * side * y, b[1] - y - 0.5 * side * x];
        self.polyline(&[wing(1.0), b, wing(-1.0)], &format!("{style};fill:none"));
    }

    pub(super) fn circle(&mut self, [x, y]: Point, radius: f64, style: &str) {
        let _ =
            write!(self.body, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius:.1}\" style=\"{style}\"/>");
    }

    pub(super) fn text(&mut self, [x, y]: Point, anchor: Anchor, px: f64, text: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let _ = write!(
            self.body,
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" font-size=\"{px}\">{}</text>",
            escape(text)
        );
    }

    /// The file's content.
    pub(super) fn svg(self) -> String {
        let [w, h] = self.size;
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {w} {h}\" width=\"{w}\" height=\"{h}\">\
             <style>text{{font-family:system-ui,sans-serif;fill:#222}}</style>\
             <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>{}</svg>\n",
            self.body
        )
    }
}

/// A parallel projection of space, cm, to the canvas.
#[derive(Debug, Clone, Copy)]
pub(super) struct View {
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    centre: Vec3,
    middle: Point,
    scale: f64,
}

impl View {
    /// Seen along `forward` with `up` upwards; `centre` appears at `middle`, a cm is `scale` px.
    pub(super) fn new(forward: Vec3, up: Vec3, centre: Vec3, middle: Point, scale: f64) -> Self {
        let forward = forward.normalize_or(Vec3::NEG_Z);
        let right = forward.cross(up).normalize_or(forward.any_orthonormal_vector());
        Self { right, up: right.cross(forward), forward, centre, middle, scale }
    }

    /// The view in which `points` fill the box from `low` to `high` on the canvas.
    pub(super) fn fitted(forward: Vec3, up: Vec3, points: &[Vec3], low: Point, high: Point) -> Self {
        let mut view = Self::new(forward, up, points.first().copied().unwrap_or_default(), [0.0; 2], 1.0);
        let flat: Vec<Point> = points.iter().map(|p| view.place(*p)).collect();
        let least = [0, 1].map(|k| flat.iter().map(|p| p[k]).fold(f64::MAX, f64::min));
        let most = [0, 1].map(|k| flat.iter().map(|p| p[k]).fold(f64::MIN, f64::max));
        let fit = |k: usize| (high[k] - low[k]) / (most[k] - least[k]).max(1e-9);
        view.scale = fit(0).min(fit(1));
        view.middle = [0, 1].map(|k| 0.5 * (low[k] + high[k] - view.scale * (least[k] + most[k])));
        view
    }

    pub(super) fn place(&self, p: Vec3) -> Point {
        let d = p - self.centre;
        [
            self.middle[0] + self.scale * f64::from(d.dot(self.right)),
            self.middle[1] - self.scale * f64::from(d.dot(self.up)),
        ]
    }

    pub(super) fn depth(&self, p: Vec3) -> f32 {
        (p - self.centre).dot(self.forward)
    }
}

/// Faces and lines in space, drawn from the farthest to the nearest.
pub(super) struct Painter {
    view: View,
    parts: Vec<(f32, Vec<Point>, bool, String)>,
}

impl Painter {
    pub(super) fn new(view: View) -> Self {
        Self { view, parts: Vec::new() }
    }

    pub(super) fn face(&mut self, corners: &[Vec3], style: String) {
        self.part(corners, true, style, 0.0);
    }

    /// A line; it is drawn over faces less than `nearer` cm in front of it.
    pub(super) fn line(&mut self, points: &[Vec3], nearer: f32, style: String) {
        self.part(points, false, style, nearer);
    }

    fn part(&mut self, points: &[Vec3], closed: bool, style: String, nearer: f32) {
        let depth = points.iter().map(|p| self.view.depth(*p)).sum::<f32>() / points.len().max(1) as f32;
        let flat = points.iter().map(|p| self.view.place(*p)).collect();
        self.parts.push((depth - nearer, flat, closed, style));
    }

    pub(super) fn draw(mut self, canvas: &mut Canvas) {
        self.parts.sort_by(|a, b| b.0.total_cmp(&a.0));
        for (_, points, closed, style) in self.parts {
            if closed { canvas.polygon(&points, &style) } else { canvas.polyline(&points, &style) }
        }
    }
}

/// An sRGB-encoded colour for a number; successive numbers get very different hues. `value` is the
/// brightest channel, 0..1.
pub(super) fn number_color(number: u32, saturation: f32, value: f32) -> Vec3 {
    let hue = 6.0 * (f32::from((number.wrapping_mul(40_503) & 0xffff) as u16) / 65_536.0);
    let channel = |k: f32| {
        let x = (k + hue).rem_euclid(6.0);
        value - value * saturation * x.min(4.0 - x).clamp(0.0, 1.0)
    };
    Vec3::new(channel(5.0), channel(3.0), channel(1.0))
}

/// A value of 0..1 in the magma colour map, sRGB-encoded.
pub(super) fn magma(value: f32) -> Vec3 {
    let lut = nv_flip::magma_lut().to_vec();
    let i = (value.clamp(0.0, 1.0) * 255.0) as usize * 3;
    lut.get(i..i + 3).map_or(Vec3::ZERO, |c| Vec3::from([c[0], c[1], c[2]].map(f32::from)) / 255.0)
}

/// An sRGB-encoded colour for CSS.
pub(super) fn css(color: Vec3) -> String {
    let [r, g, b] = color.to_array().map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// An sRGB-encoded colour as an opaque display-linear pixel.
pub(super) fn pixel(color: Vec3) -> [f32; 4] {
    let [r, g, b] = color.to_array().map(srgb_decode);
    [r, g, b, 1.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_faces_are_drawn_over_far_ones() {
        let view = View::new(Vec3::NEG_Z, Vec3::Y, Vec3::ZERO, [50.0, 50.0], 10.0);
        assert_eq!(view.place(Vec3::new(1.0, 2.0, -7.0)), [60.0, 30.0]);
        let points = [Vec3::ZERO, Vec3::new(4.0, 1.0, 0.0)];
        let fitted = View::fitted(Vec3::NEG_Z, Vec3::Y, &points, [10.0, 10.0], [50.0, 30.0]);
        assert_eq!(points.map(|p| fitted.place(p)), [[10.0, 25.0], [50.0, 15.0]]);
        let at = |z: f32| [Vec3::new(0.0, 0.0, z), Vec3::new(1.0, 0.0, z), Vec3::new(0.0, 1.0, z)];
        for order in [[1.0, -1.0], [-1.0, 1.0]] {
            let mut painter = Painter::new(view);
            for z in order {
                painter.face(&at(z), if z > 0.0 { "fill:near".into() } else { "fill:far".into() });
            }
            let mut canvas = Canvas::new(100.0, 100.0);
            painter.draw(&mut canvas);
            let svg = canvas.svg();
            assert!(svg.find("fill:far") < svg.find("fill:near"), "{svg}");
        }
    }

    #[test]
    fn colours_of_successive_numbers_differ() {
        for n in 0..64 {
            let difference = number_color(n, 0.5, 0.9).distance(number_color(n + 1, 0.5, 0.9));
            assert!(difference > 0.2, "{n}: {difference}");
        }
        assert_eq!(css(Vec3::new(1.0, 0.0, 0.5)), "#ff0080");
        assert!(magma(1.0).length() > magma(0.5).length() && magma(0.0).length() < 0.1);
    }

    #[test]
    fn text_is_escaped() {
        let mut canvas = Canvas::new(10.0, 10.0);
        canvas.text([1.0, 2.0], Anchor::Middle, 9.0, "a < b");
        assert!(canvas.svg().contains("a &lt; b"));
    }
}
