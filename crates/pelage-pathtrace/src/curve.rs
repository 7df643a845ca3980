//! Segments of hairs: truncated cones that meet their neighbours in mitred joints.
//!
//! A segment is the part of an infinite cone between two planes. At a joint both segments share the
//! plane that bisects the angle between them, so that a bent hair has no gaps on its outer side and
//! no overlaps on its inner side. At its ends a hair is cut square. The solid is closed: rays along
//! a hair meet its end. Only a change of taper at a joint leaves a step, as large as the radius
//! times the change of slope.

use super::bvh::Ray;
use glam::{Vec3A, Vec4};

/// The infinite cone of a segment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Start of the axis, cm.
    pub start: Vec3A,
    /// Unit, from root to tip.
    pub axis: Vec3A,
    /// Length of the segment, cm.
    pub length: f32,
    /// Radius at the start, cm.
    pub radius: f32,
    /// Change of the radius per length.
    pub slope: f32,
}

/// Part of a ray within a cone or segment. Ray parameters are distances from its origin, cm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Where the ray enters.
    pub enter: f32,
    /// Where it leaves.
    pub exit: f32,
    /// Where it is nearest to the line of the axis.
    pub nearest: f32,
    /// Whether it enters through the side, not through an end or a joint.
    pub side: bool,
    /// Point of the ray at `nearest`, relative to the start of the axis, cm.
    near: Vec3A,
}

impl Cone {
    /// The cone between two points and their radii; `None` if they coincide or both radii are 0.
    pub fn new(start: Vec3A, end: Vec3A, radii: [f32; 2]) -> Option<Self> {
        let along = end - start;
        let length = along.length();
        let solid = length > 1e-9 && radii[0].max(radii[1]) > 0.0 && length.is_finite();
        solid.then(|| Self {
            start,
            axis: along / length,
            length,
            radius: radii[0],
            slope: (radii[1] - radii[0]) / length,
        })
    }

    /// The cone between two points with radii as [`crate::geometry`] keeps them, where the sign of
    /// a radius is a mark.
    #[inline]
    pub fn of_segment(a: Vec4, b: Vec4) -> Option<Self> {
        Self::new(Vec3A::from_vec4(a), Vec3A::from_vec4(b), [a.w.abs(), b.w.abs()])
    }

    /// The part of a ray (unit `direction`) within the infinite cone.
    #[inline]
    pub fn span(&self, origin: Vec3A, direction: Vec3A) -> Option<Span> {
        let w = origin - self.start;
        let along = direction.dot(self.axis);
        let across = direction - along * self.axis;
        let across2 = across.length_squared();
        let from_axis = w - w.dot(self.axis) * self.axis;
        // Measured from where the ray is nearest to the axis, no large numbers cancel, however far
        // its origin is.
        let nearest = if across2 > 1e-9 {
            -from_axis.dot(across) / across2
        } else {
            (0.5 * self.length - w.dot(self.axis)) / along
        };
        let near = w + nearest * direction;
        let at = near.dot(self.axis);
        let off = near - at * self.axis;
        let radius = self.radius + self.slope * at;
        // |off + t across|² = (radius + slope along t)²
        let a = across2 - self.slope * self.slope * along * along;
        let b = off.dot(across) - self.slope * along * radius;
        let c = off.length_squared() - radius * radius;
        let discriminant = b * b - a * c;
        if discriminant < 0.0 {
            return None;
        }
        let (enter, exit) = if a > 1e-9 * across2 {
            let root = discriminant.sqrt();
            ((-b - root) / a, (-b + root) / a)
        } else if a < -1e-12 {
            // Closer to the axis than the cone's side: the ray crosses the side once on this side
            // of the apex.
            let root = discriminant.sqrt();
            let (first, last) = ((-b + root) / a, (-b - root) / a);
            if self.slope * along > 0.0 { (last, f32::INFINITY) } else { (f32::NEG_INFINITY, first) }
        } else if b.abs() > 1e-12 {
            let once = -0.5 * c / b;
            if b > 0.0 { (f32::NEG_INFINITY, once) } else { (once, f32::INFINITY) }
        } else if c < 0.0 {
            (f32::NEG_INFINITY, f32::INFINITY)
        } else {
            return None;
        };
        Some(Span { enter: enter + nearest, exit: exit + nearest, nearest, side: true, near })
    }

    /// Clips `span` to the planes through the start and the end of the axis, whose `normals` point
    /// from root to tip.
    #[inline]
    pub fn cut(&self, mut span: Span, direction: Vec3A, normals: [Vec3A; 2]) -> Option<Span> {
        let end = self.length * self.axis;
        for (height, fall) in [
            (normals[0].dot(span.near), normals[0].dot(direction)),
            (normals[1].dot(end - span.near), -normals[1].dot(direction)),
        ] {
            // Inside while height + t fall >= 0.
            let t = span.nearest - height / fall;
            if fall > 0.0 {
                if t > span.enter {
                    (span.enter, span.side) = (t, false);
                }
            } else if fall < 0.0 {
                span.exit = span.exit.min(t);
            } else if height < 0.0 {
                return None;
            }
        }
        (span.enter < span.exit).then_some(span)
    }

    /// Where a ray enters at the distance `enter`: position along the axis, 0..1; radius there, cm;
    /// offset across the hair in radii, -1..1.
    ///
    /// The offset is sin(φ_o - φ_n) with the azimuth φ_o of the direction back along the ray and
    /// φ_n of the normal.
    pub fn place(&self, span: &Span, direction: Vec3A, enter: f32) -> (f32, f32, f32) {
        let at = span.near + (enter - span.nearest) * direction;
        let along = at.dot(self.axis).clamp(0.0, self.length);
        let radius = (self.radius + self.slope * along).max(1e-9);
        let (_, side) = frame(self.axis, -direction);
        let h = -(span.near.dot(side) / radius).clamp(-1.0, 1.0);
        (along / self.length, radius, h)
    }
}

/// Whether the line of a ray surely misses a segment of at most `radius`: a cheap test that rejects
/// most segments whose box is met.
#[inline]
pub fn misses(ray: &Ray, start: Vec3A, end: Vec3A, radius: f32) -> bool {
    let common = ray.direction.cross(end - start);
    let distance = (ray.origin - start).dot(common);
    // Mitred ends of tapered segments are a little thicker; the second term, a tenth of a µm, is
    // far above rounding.
    let reach = 1.05 * radius + 1e-5;
    distance * distance > reach * reach * common.length_squared()
}

/// Second and third axis of the frame of a fibre. The second is as close to `towards` as possible,
/// which so has the azimuth 0.
#[inline]
pub fn frame(axis: Vec3A, towards: Vec3A) -> (Vec3A, Vec3A) {
    let across = towards - towards.dot(axis) * axis;
    let y = across
        .try_normalize()
        .unwrap_or_else(|| Vec3A::from(glam::Vec3::from(axis).any_orthonormal_vector()));
    (y, axis.cross(y))
}

/// Half the extent along the world's axes of a hair's cross section; `bend` is the tangent of half
/// the angle between the segments that meet there.
pub fn extent(axis: Vec3A, radius: f32, bend: f32) -> Vec3A {
    let across = (Vec3A::ONE - axis * axis).max(Vec3A::ZERO);
    radius * (Vec3A::from(glam::Vec3::from(across).to_array().map(f32::sqrt)) + bend * axis.abs())
}
