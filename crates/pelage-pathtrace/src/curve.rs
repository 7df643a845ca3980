//! Segments of hairs: truncated cones that meet their neighbours in mitred joints.
//!
//! A segment is the part of an infinite cone between two planes. At a joint both segments share the plane that halves the angle
//! between them, so that a bent hair has neither gaps on its outer side nor overlaps on its inner side; at its ends a hair is cut
//! square. The solid between is closed: rays along a hair meet its end. Only the taper's change at a joint leaves steps, in size
//! the radius times the change of slope.

use super::bvh::Ray;
use glam::Vec3A;

/// The cone of a segment, without its planes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cone {
    /// Where the axis starts, cm.
    pub start: Vec3A,
    /// Unit, from root to tip.
    pub axis: Vec3A,
    /// cm.
    pub length: f32,
    /// Radius at the start, cm.
    pub radius: f32,
    /// Change of the radius per length.
    pub slope: f32,
}

/// Part of a ray within a cone or segment; ray parameters are lengths, cm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Where the ray comes in.
    pub enter: f32,
    /// Where it goes out.
    pub exit: f32,
    /// Where it is nearest to the line of the axis.
    pub nearest: f32,
    /// Whether it comes in through the side, not through an end or joint.
    pub side: bool,
    /// Place of `nearest` relative to the start, cm.
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

    /// The part of a ray (unit `direction`) within the infinite cone.
    #[inline]
    pub fn span(&self, origin: Vec3A, direction: Vec3A) -> Option<Span> {
        let w = origin - self.start;
        let along = direction.dot(self.axis);
        let across = direction - along * self.axis;
        let across2 = across.length_squared();
        let from_axis = w - w.dot(self.axis) * self.axis;
        // Seen from where the ray is nearest to the axis nothing large cancels, however far its origin is.
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
            // Steeper along the axis than the side: the ray comes in or goes out once on this side of the apex.
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

    /// Cuts `span` to what lies between the planes through the start and the end; their normals point along the axis.
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

    /// Place along the axis, 0..1, radius (cm) there, and offset across in radii, -1..1, at which a ray comes in at `enter`.
    ///
    /// The offset is sin(φ_o - φ_n) with the azimuths of the way back along the ray and of the normal.
    pub fn place(&self, span: &Span, direction: Vec3A, enter: f32) -> (f32, f32, f32) {
        let at = span.near + (enter - span.nearest) * direction;
        let along = at.dot(self.axis).clamp(0.0, self.length);
        let radius = (self.radius + self.slope * along).max(1e-9);
        let (_, side) = frame(self.axis, -direction);
        let h = -(span.near.dot(side) / radius).clamp(-1.0, 1.0);
        (along / self.length, radius, h)
    }
}

/// Whether the line of a ray surely passes beside a segment of at most `radius`: most that boxes let through.
#[inline]
pub fn passes(ray: &Ray, start: Vec3A, end: Vec3A, radius: f32) -> bool {
    let common = ray.direction.cross(end - start);
    let distance = (ray.origin - start).dot(common);
    // Mitred ends of tapered segments are a little thicker; rounding is far below a tenth of a µm.
    let reach = 1.05 * radius + 1e-5;
    distance * distance > reach * reach * common.length_squared()
}

/// Second and third axis of the frame of a fibre: the second as near to `towards` as can be, so that its azimuth is 0.
#[inline]
pub fn frame(axis: Vec3A, towards: Vec3A) -> (Vec3A, Vec3A) {
    let across = towards - towards.dot(axis) * axis;
    let y = across
        .try_normalize()
        .unwrap_or_else(|| Vec3A::from(glam::Vec3::from(axis).any_orthonormal_vector()));
    (y, axis.cross(y))
}

/// Half the extent of a hair's cut at a point of a segment: `bend` is the tangent of half the angle between the segments.
pub fn extent(axis: Vec3A, radius: f32, bend: f32) -> Vec3A {
    let across = (Vec3A::ONE - axis * axis).max(Vec3A::ZERO);
    radius * (Vec3A::from(glam::Vec3::from(across).to_array().map(f32::sqrt)) + bend * axis.abs())
}
