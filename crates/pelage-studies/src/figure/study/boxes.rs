//! A tree of bounding boxes over subelements, queried by points and by rays.

use super::subelements::{cells, corners};
use glam::{Vec3, Vec3A};
use pelage_fur::shell::{Located, Place, Shell, subelement, subelement_centroid};
use pelage_pathtrace::bvh::{Bounds, Bvh, Part, Ray, Stack};
use pelage_render::twin::undercoat_march::MarchInputs;

/// A ray that enters the shell.
pub(super) struct Start {
    /// Direction, with a component of 1 along the camera's axis.
    pub(super) ray: Vec3,
    /// Depth of the entry, cm.
    pub(super) z: f32,
    /// Prism of the entry.
    pub(super) prism: u32,
    /// First step, part of the step length.
    pub(super) phase: f32,
    /// Depth of the skin, cm.
    pub(super) z_base: f32,
}

/// An interval of a ray with homogeneous medium.
pub(super) struct Piece {
    /// Depths, cm.
    pub(super) from: f32,
    pub(super) to: f32,
    pub(super) place: Place,
    /// Extinction and source radiance, if they are known already.
    pub(super) shaded: Option<(f32, Vec3)>,
}

/// A tree of bounding boxes over all subelements, with their corners.
pub(super) struct Tree<'a> {
    shell: &'a Shell,
    layers: u32,
    d: u32,
    pub(super) bvh: Bvh,
    /// Corners of each subelement, in the order of [Andersen2016] eq. 3.
    pub(super) bodies: Vec<[Vec3; 6]>,
}

impl<'a> Tree<'a> {
    pub(super) fn new(shell: &'a Shell, layers: u32, d: u32) -> Self {
        let cells = cells(d);
        let bodies: Vec<[Vec3; 6]> = (0..shell.prisms.len() as u32)
            .flat_map(|prism| {
                let (place, cells) = (shell.enter(prism), &cells);
                (0..layers).flat_map(move |l| cells.iter().map(move |c| corners(&place, c, l, layers)))
            })
            .collect();
        let parts = (0..bodies.len() as u32).map(|thing| Part { thing, part: 0, parts: 1 }).collect();
        let bvh = Bvh::build(parts, |part| {
            let body = bodies[part.thing as usize].map(Vec3A::from);
            let low = body.iter().fold(Vec3A::INFINITY, |a, b| a.min(*b));
            let high = body.iter().fold(Vec3A::NEG_INFINITY, |a, b| a.max(*b));
            // Room for the curved walls and for rounding.
            let margin = Vec3A::splat(1e-4) + 0.02 * (high - low);
            Bounds { low: low - margin, high: high + margin }
        });
        Self { shell, layers, d, bvh, bodies }
    }

    /// Prism, layer and local index of a body, the inverse of [Andersen2016] eq. 3.
    fn numbers(&self, body: u32) -> (u32, u32, u32) {
        let cells = 1u32 << (2 * self.d);
        (body / cells / self.layers, body / cells % self.layers, body % cells)
    }

    /// The steps of the march, where each step queries the tree for its subelement.
    pub(super) fn ask_at_steps(
        &self,
        inputs: &MarchInputs<'_>,
        eye: Vec3,
        start: &Start,
        stack: &mut Stack,
        pieces: &mut Vec<Piece>,
    ) {
        let length = inputs.fur.undercoat.step / start.ray.length();
        let mut z = start.z;
        let mut dz = length * start.phase;
        loop {
            let z_mid = z + 0.5 * dz;
            let x = eye + z_mid * start.ray;
            let Some(place) = self.find(x, start.ray, stack).or_else(|| self.starting(x, start, z, dz))
            else {
                // As in the march: a last, shorter step that ends at the skin or at the top.
                let Some(last) = pieces.last() else {
                    return;
                };
                let mut place = last.place;
                self.shell.locate(&mut place, x, start.ray, 2);
                let beyond = if place.t > 1.0 { place.t - 1.0 } else { place.t };
                let z_end = z_mid - beyond / place.dt_dz;
                if (place.t > 1.0 || place.t < 0.0) && beyond * place.dt_dz > 0.0 && z_end > z {
                    place.t = place.t.clamp(0.0, 1.0);
                    pieces.push(Piece { from: z, to: z_end, place, shaded: None });
                }
                return;
            };
            let (t, slope) = (place.t, place.dt_dz);
            if slope > 0.0 && t + 0.5 * dz * slope > 1.0 {
                let z_end = z_mid + (1.0 - t) / slope;
                pieces.push(Piece { from: z, to: z_end, place, shaded: None });
                return;
            }
            pieces.push(Piece { from: z, to: z + dz, place, shaded: None });
            z += dz;
            dz = length;
        }
    }

    /// The place of a first step whose midpoint lies slightly above the top because of rounding.
    fn starting(&self, x: Vec3, start: &Start, z: f32, dz: f32) -> Option<Place> {
        if z > start.z {
            return None;
        }
        let mut place = Place { t: 1.0, ..self.shell.enter(start.prism) };
        let found = self.shell.locate(&mut place, x, start.ray, 4);
        let close = place.t > 1.0 && place.dt_dz <= 0.0 && place.t <= 1.0 - place.dt_dz * dz;
        (found == Located::Inside && close).then_some(place)
    }

    /// The place of a point, by the tree: a ray of length 0 visits the boxes around it.
    fn find(&self, x: Vec3, ray: Vec3, stack: &mut Stack) -> Option<Place> {
        let mut found = None;
        let box_ray = Ray::new(Vec3A::from(x), Vec3A::from(ray.normalize_or(Vec3::Z)));
        self.bvh.walk(&box_ray, 0.0, stack, |body, limit| {
            let (prism, layer, id) = self.numbers(body);
            let mut place = self.shell.enter(prism);
            place.t = (layer as f32 + 0.5) / self.layers as f32;
            self.shell.solve(&mut place, x, ray, 2);
            let inside = place.lambda.min_element() >= -1e-5 && (0.0..=1.0).contains(&place.t);
            let at = ((place.t * self.layers as f32) as u32).min(self.layers - 1);
            if inside && at == layer && subelement(place.lambda, self.d) == id {
                found = Some(place);
                return -1.0;
            }
            limit
        });
        found
    }

    /// All subelements that a ray crosses, with the interval in each.
    pub(super) fn meet(&self, eye: Vec3, start: &Start, stack: &mut Stack, pieces: &mut Vec<Piece>) {
        let direction = start.ray.normalize_or(Vec3::Z);
        let ray = Ray::new(Vec3A::from(eye), Vec3A::from(direction));
        let speed = start.ray.length();
        self.bvh.walk(&ray, f32::INFINITY, stack, |body, limit| {
            if let Some((from, to)) = interval(&self.bodies[body as usize], eye, direction) {
                let (prism, layer, id) = self.numbers(body);
                let mut place = self.shell.enter(prism);
                place.t = (layer as f32 + 0.5) / self.layers as f32;
                place.lambda = subelement_centroid(id, self.d);
                self.shell.solve(&mut place, eye + 0.5 * (from + to) * direction, start.ray, 2);
                place.t = place.t.clamp(0.0, 1.0);
                pieces.push(Piece { from: from / speed, to: to / speed, place, shaded: None });
            }
            limit
        });
    }
}

/// Interval of a ray within a body whose walls are split into triangles; `None` if it misses.
// [MollerTrumbore1997]
fn interval(body: &[Vec3; 6], origin: Vec3, direction: Vec3) -> Option<(f32, f32)> {
    let (mut low, mut high, mut hits) = (f32::INFINITY, f32::NEG_INFINITY, 0);
    let mut hit = |a: Vec3, b: Vec3, c: Vec3| {
        let (e1, e2) = (b - a, c - a);
        let p = direction.cross(e2);
        let det = e1.dot(p);
        if det == 0.0 {
            return;
        }
        let s = origin - a;
        let q = s.cross(e1);
        let (u, v) = (s.dot(p) / det, direction.dot(q) / det);
        if u >= 0.0 && v >= 0.0 && u + v <= 1.0 {
            let t = e2.dot(q) / det;
            (low, high, hits) = (low.min(t), high.max(t), hits + 1);
        }
    };
    hit(body[0], body[1], body[2]);
    hit(body[3], body[4], body[5]);
    for k in 0..3 {
        let next = (k + 1) % 3;
        let [a, b, c, d] = [body[k], body[next], body[next + 3], body[k + 3]];
        // Both bodies at a wall split it along the same diagonal, from the corner that is first in
        // lexicographic order.
        let first = a.to_array() < b.to_array();
        let (p, q) = if first { ([a, b, c], [a, c, d]) } else { ([a, b, d], [b, c, d]) };
        hit(p[0], p[1], p[2]);
        hit(q[0], q[1], q[2]);
    }
    (hits >= 2 && high > low).then_some((low, high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_within_a_body_is_exact() {
        let base = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let top = base.map(|p| p + 2.0 * Vec3::Z);
        let body = [base[0], base[1], base[2], top[0], top[1], top[2]];
        let (from, to) = interval(&body, Vec3::new(0.2, 0.2, -3.0), Vec3::Z).expect("a hit");
        assert!((from - 3.0).abs() < 1e-5 && (to - 5.0).abs() < 1e-5);
        let (from, to) = interval(&body, Vec3::new(-1.0, 0.25, 0.7), Vec3::X).expect("a hit");
        assert!((from - 1.0).abs() < 1e-5 && (to - 1.75).abs() < 1e-5);
        assert!(interval(&body, Vec3::new(0.8, 0.8, -3.0), Vec3::Z).is_none());
    }
}
