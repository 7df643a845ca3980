//! Subelements found through a tree of boxes, by points and by rays.

use super::subelements::{cells, corners};
use glam::{Vec3, Vec3A};
use pelage_fur::shell::{Located, Place, Shell, subelement, subelement_centroid};
use pelage_pathtrace::bvh::{Bounds, Bvh, Part, Ray, Stack};
use pelage_render::twin::undercoat_march::MarchInputs;

/// A ray: direction of forward component 1, entry, length of the first step, and the skin.
pub(super) struct Start {
    pub(super) ray: Vec3,
    pub(super) z: f32,
    pub(super) prism: u32,
    pub(super) phase: f32,
    pub(super) z_base: f32,
}

/// A piece of even medium on a ray.
pub(super) struct Piece {
    /// Depths, cm.
    pub(super) from: f32,
    pub(super) to: f32,
    pub(super) place: Place,
    /// Extinction and radiance, where the way has already looked them up.
    pub(super) shaded: Option<(f32, Vec3)>,
}

/// A tree of boxes over all subelements, with their bodies.
pub(super) struct Tree<'a> {
    shell: &'a Shell,
    layers: u32,
    d: u32,
    pub(super) bvh: Bvh,
    /// Corners of each subelement in the order of equation 3.
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
            // Room for the walls' bend and for rounding.
            let margin = Vec3A::splat(1e-4) + 0.02 * (high - low);
            Bounds { low: low - margin, high: high + margin }
        });
        Self { shell, layers, d, bvh, bodies }
    }

    /// Prism, layer and local index of a body: [Andersen2016] eq. 3 backwards.
    fn numbers(&self, body: u32) -> (u32, u32, u32) {
        let cells = 1u32 << (2 * self.d);
        (body / cells / self.layers, body / cells % self.layers, body % cells)
    }

    /// The steps of the march, each asking the tree for the subelement it is in.
    pub(super) fn ask_at_steps(
        &self,
        inputs: &MarchInputs<'_>,
        eye: Vec3,
        start: &Start,
        stack: &mut Stack,
        pieces: &mut Vec<Piece>,
    ) {
        let length = inputs.undercoat.fur.step / start.ray.length();
        let mut z = start.z;
        let mut dz = length * start.phase;
        loop {
            let z_mid = z + 0.5 * dz;
            let x = eye + z_mid * start.ray;
            let Some(place) = self.find(x, start.ray, stack).or_else(|| self.starting(x, start, z, dz))
            else {
                // As the march does: a last, shorter step up to the skin or the top, from the place where it ends.
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

    /// The place of a first step whose middle lies a little above the top, by rounding.
    fn starting(&self, x: Vec3, start: &Start, z: f32, dz: f32) -> Option<Place> {
        if z > start.z {
            return None;
        }
        let mut place = Place { t: 1.0, ..self.shell.enter(start.prism) };
        let found = self.shell.locate(&mut place, x, start.ray, 4);
        let close = place.t > 1.0 && place.dt_dz <= 0.0 && place.t <= 1.0 - place.dt_dz * dz;
        (found == Located::Inside && close).then_some(place)
    }

    /// The place of a point by the tree: a ray of no length shows the boxes around it.
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

    /// All subelements that a ray meets, each with the length of its way through it.
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

/// Where a ray is within a body whose walls are cut into triangles; `None` where it misses.
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
        // The same diagonal from both sides of a wall: that from the corner which comes first in space.
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
    fn a_ray_is_as_long_within_a_body_as_it_is() {
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
