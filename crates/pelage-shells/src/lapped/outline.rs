//! The irregular outline of a patch: a polygon that is star-shaped around the origin.

use glam::{DVec2, Vec2};
use pelage_fur::random::random;
use std::f64::consts::TAU;

/// Corners of an outline.
const CORNERS: usize = 48;

/// An irregular outline around the origin, cm.
pub(super) struct Outline {
    points: Vec<DVec2>,
    /// Everything within this distance of the origin is inside.
    inner: f64,
    /// Everything beyond this distance is outside.
    outer: f64,
}

/// Relation of a triangle to an outline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Relation {
    Inside,
    Outside,
    Across,
}

impl Outline {
    /// An outline whose distance from the origin varies between `radius (1 - irregularity)` and
    /// `radius (1 + irregularity)`: a sum of cosines with two to six periods and random amplitudes
    /// and phases.
    pub fn new(radius: f64, irregularity: f64, seed: u32) -> Self {
        let wave = |i: usize| {
            let angle = i as f64 / CORNERS as f64 * TAU;
            let term = |k: u32| {
                let height = f64::from(random(seed, 2 * k)) - 0.5;
                height * (f64::from(k) * angle + f64::from(random(seed, 2 * k + 1)) * TAU).cos()
            };
            (2..=6).map(term).sum::<f64>()
        };
        let waves: Vec<f64> = (0..CORNERS).map(wave).collect();
        let highest = waves.iter().fold(f64::MIN_POSITIVE, |h, w| h.max(w.abs()));
        let distance = |i: usize| radius * (1.0 + irregularity * waves[i] / highest);
        let point = |i: usize| DVec2::from_angle(i as f64 / CORNERS as f64 * TAU) * distance(i);
        let points: Vec<DVec2> = (0..CORNERS).map(point).collect();
        // The nearest point of an edge may lie between its ends.
        let edge = |i: usize| {
            let (a, b) = (points[i], points[(i + 1) % CORNERS]);
            let t = (-a.dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            a.lerp(b, t).length()
        };
        let inner = (0..CORNERS).map(edge).fold(f64::INFINITY, f64::min);
        let outer = points.iter().map(|p| p.length()).fold(0.0, f64::max);
        Self { points, inner, outer }
    }

    /// Whether `p` is inside.
    pub fn contains(&self, p: DVec2) -> bool {
        let distance = p.length();
        distance <= self.inner || (distance <= self.outer && in_star(&self.points, p))
    }

    /// Exact relation of a triangle to the outline: `Inside` only if the whole triangle is.
    pub fn relation(&self, triangle: &[DVec2; 3]) -> Relation {
        let farthest = triangle.iter().map(|p| p.length()).fold(0.0, f64::max);
        if farthest <= self.inner {
            return Relation::Inside;
        }
        let [a, b, c] = *triangle;
        let low = a.min(b).min(c);
        let high = a.max(b).max(c);
        if DVec2::ZERO.clamp(low, high).length() > self.outer {
            return Relation::Outside;
        }
        let inside = triangle.map(|p| self.contains(p));
        let crossed = (0..CORNERS).any(|i| {
            let (p, q) = (self.points[i], self.points[(i + 1) % CORNERS]);
            crosses(p, q, a, b) || crosses(p, q, b, c) || crosses(p, q, c, a)
        });
        if crossed || (inside != [true; 3] && inside != [false; 3]) {
            Relation::Across
        } else if inside[0] {
            Relation::Inside
        } else if in_triangle(self.points[0], triangle) {
            Relation::Across
        } else {
            Relation::Outside
        }
    }

    /// Corners of the polygon.
    pub fn polygon(&self) -> Vec<Vec2> {
        self.points.iter().map(|p| p.as_vec2()).collect()
    }
}

/// Whether `p` (uv, cm) lies within the outline of a patch; an empty outline contains everything.
pub fn contains(outline: &[Vec2], p: Vec2) -> bool {
    let points: &dyn Fn(usize) -> DVec2 = &|i| outline[i].as_dvec2();
    outline.is_empty() || in_sector(outline.len(), points, p.as_dvec2())
}

fn in_star(points: &[DVec2], p: DVec2) -> bool {
    in_sector(points.len(), &|i| points[i], p)
}

/// Whether `p` is on the inner side of the polygon's edge in its direction from the origin.
fn in_sector(corners: usize, point: &dyn Fn(usize) -> DVec2, p: DVec2) -> bool {
    if p == DVec2::ZERO {
        return true;
    }
    let turn = p.y.atan2(p.x).rem_euclid(TAU) / TAU * corners as f64;
    let i = (turn as usize).min(corners - 1);
    let (a, b) = (point(i), point((i + 1) % corners));
    (b - a).perp_dot(p - a) >= 0.0
}

/// Whether the segments p–q and a–b cross.
fn crosses(p: DVec2, q: DVec2, a: DVec2, b: DVec2) -> bool {
    let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
    let (a_side, b_side) = (side(p, q, a), side(p, q, b));
    let (p_side, q_side) = (side(a, b, p), side(a, b, q));
    a_side * b_side < 0.0 && p_side * q_side < 0.0
}

fn in_triangle(p: DVec2, [a, b, c]: &[DVec2; 3]) -> bool {
    let side = |a: &DVec2, b: &DVec2| (*b - *a).perp_dot(p - *a);
    let sides = [side(a, b), side(b, c), side(c, a)];
    sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn relations_agree_with_points() {
        for seed in 0..200_u32 {
            let outline = Outline::new(2.0, 0.8, seed);
            let draw = |k: u32| f64::from(random(seed ^ 0xabc, k));
            let center = DVec2::new(draw(0) - 0.5, draw(1) - 0.5) * 7.0;
            let size = 0.05 + 6.0 * draw(2) * draw(3);
            let corner = |k: u32| center + DVec2::new(draw(4 + k) - 0.5, draw(8 + k) - 0.5) * size;
            let triangle = [corner(0), corner(1), corner(2)];
            let n = 60;
            let points = (0..=n).flat_map(|i| (0..=n - i).map(move |j| (i, j)));
            let at = |(i, j)| {
                let (s, t) = (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n));
                triangle[0] + (triangle[1] - triangle[0]) * s + (triangle[2] - triangle[0]) * t
            };
            let (inside, outside): (Vec<_>, Vec<_>) =
                points.map(at).partition(|p| contains(&outline.polygon(), p.as_vec2()));
            match outline.relation(&triangle) {
                Relation::Inside => assert!(outside.is_empty(), "{seed}: {outside:?}"),
                Relation::Outside => assert!(inside.is_empty(), "{seed}: {inside:?}"),
                // The intersection may be smaller than the grid.
                Relation::Across => {}
            }
            let all = |r: Relation| outline.relation(&triangle) == r;
            assert!(inside.is_empty() || outside.is_empty() || all(Relation::Across), "{seed}");
        }
    }
}
