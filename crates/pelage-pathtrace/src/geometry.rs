//! What rays meet: the triangles of surfaces and the hairs' segments, each in hierarchies of their
//! own.

use super::{
    bvh::{Bounds, Bvh, Part, Ray, Stack},
    curve::{self, Cone, Span},
    segments::{check, mark_ends, part_bounds},
    strands::Strands,
    surfaces::{SurfaceHit, Surfaces},
};
use glam::{Vec3A, Vec4};
use pelage_core::{Error, Result, World};
use pelage_fur::Layer;
use pelage_fur::fibre::Fibre;
use pelage_fur::random::{hash2, random};

/// Hairs of a layer, whose points are in [`Geometry::points`].
#[derive(Debug, Clone)]
struct HairLayer {
    strands: Strands,
    fibre: Fibre,
    /// Number of the first point.
    first: u32,
}

/// Skin, objects and hairs.
pub struct Geometry {
    /// Points of all hairs: position and radius, cm. The radius is negative where no joint is.
    points: Vec<Vec4>,
    layers: Vec<HairLayer>,
    hair: Bvh,
    /// Skin and objects.
    pub surfaces: Surfaces,
    bounds: Bounds,
}

/// Where a ray meets a hair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HairHit {
    /// Number of the segment's first point.
    point: u32,
    /// Unit, from root to tip.
    pub axis: Vec3A,
    /// Point of the axis nearest to where the ray enters, cm.
    pub position: Vec3A,
    /// Position along the segment, 0..1.
    along: f32,
    /// Radius there, cm.
    pub radius: f32,
    /// Offset across the hair in radii, as [`pelage_fur::fibre::Hit::h`].
    pub h: f32,
}

/// The nearest thing that a ray meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hit {
    /// A hair.
    Hair(HairHit),
    /// The skin or an object.
    Surface(SurfaceHit),
}

/// The hair that a ray leaves, if any.
///
/// Such a ray starts on the hair's axis. It can meet the same hair again only where it enters
/// through its side after having left it: farther away than the radius over the sine of the angle
/// between ray and axis.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RayOrigin {
    /// Range of the hair's points.
    first: u32,
    end: u32,
    /// Distance before which the hair is not met, cm.
    clear: f32,
}

/// Shading data of a hair where it is met.
#[derive(Debug, Clone, Copy)]
pub struct HairShading<'a> {
    /// Its layer.
    pub layer: Layer,
    /// Its scattering model.
    pub fibre: &'a Fibre,
    /// Colour, glints and offset.
    pub hit: pelage_fur::fibre::Hit,
}

impl Geometry {
    /// Builds the hierarchies over the surfaces of `world` and over `layers` of hairs, each with
    /// its scattering model.
    ///
    /// # Errors
    /// [`Error::Unsupported`] where a layer's points, hairs and opacities do not fit each other, or
    /// there are 2³¹ points or more; as [`Surfaces::new`].
    pub fn new(world: &World, layers: Vec<(Strands, Fibre)>) -> Result<Self> {
        let mut points: Vec<Vec4> = Vec::new();
        let mut kept = Vec::new();
        let mut parts: Vec<Part> = Vec::new();
        for (mut strands, fibre) in layers {
            check(&strands)?;
            let first = points.len() as u64;
            if first + strands.points.len() as u64 >= 1 << 31 {
                return Err(Error::Unsupported(
                    "found 2^31 points of hairs or more, expected fewer: trace a part of the fur with --patch".into(),
                ));
            }
            let mut own = std::mem::take(&mut strands.points);
            mark_ends(&strands, &mut own, first as u32, &mut parts);
            if points.is_empty() {
                points = own;
            } else {
                points.append(&mut own);
            }
            kept.push(HairLayer { strands, fibre, first: first as u32 });
        }
        parts.shrink_to_fit();
        let hair = Bvh::build(parts, |part| part_bounds(&points, part));
        let surfaces = Surfaces::new(world)?;
        let (low, high) = points
            .iter()
            .map(|p| (Vec3A::from(p.truncate()), p.w.abs()))
            .chain(surfaces.positions().iter().map(|p| (Vec3A::from(*p), 0.0)))
            .fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(low, high), (p, r)| {
                (low.min(p - 2.0 * r), high.max(p + 2.0 * r))
            });
        Ok(Self {
            points,
            layers: kept,
            hair,
            surfaces,
            bounds: Bounds { low: low - 1e-3, high: high + 1e-3 },
        })
    }

    /// Box around everything.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Memory that it holds, bytes.
    pub fn bytes(&self) -> u64 {
        let hairs: usize = self.layers.iter().map(|c| std::mem::size_of_val(&c.strands.hairs[..])).sum();
        (std::mem::size_of_val(&self.points[..]) + hairs) as u64 + self.hair.bytes() + self.surfaces.bytes()
    }

    /// The nearest thing that a ray meets, and its distance, cm. `word` is the random word that
    /// decides which translucent hairs let the ray pass.
    pub fn closest(&self, ray: &Ray, from: &RayOrigin, word: u32, stack: &mut Stack) -> Option<(Hit, f32)> {
        let surface = self.surfaces.closest(ray, stack);
        let limit = surface.map_or(f32::INFINITY, |(_, t)| t);
        let mut best: Option<(u32, Cone, Span)> = None;
        let reached = self.hair.walk(ray, limit, stack, |point, limit| {
            match self.intersect_segment(ray, point, from, word, limit) {
                Some((t, cone, span)) => {
                    best = Some((point, cone, span));
                    t
                }
                None => limit,
            }
        });
        let Some((point, cone, span)) = best else {
            return surface.map(|(hit, t)| (Hit::Surface(hit), t));
        };
        let (along, radius, h) = cone.place(&span, ray.direction, reached);
        let position = cone.start + along * cone.length * cone.axis;
        Some((Hit::Hair(HairHit { point, axis: cone.axis, position, along, radius, h }), reached))
    }

    /// Whether anything blocks a ray of unbounded length; `word` as in [`Geometry::closest`].
    pub fn blocked(&self, ray: &Ray, from: &RayOrigin, word: u32, stack: &mut Stack) -> bool {
        self.surfaces.blocked(ray, stack)
            || self.hair.walk(ray, f32::INFINITY, stack, |point, limit| {
                self.intersect_segment(ray, point, from, word, limit).map_or(limit, |_| -1.0)
            }) < 0.0
    }

    /// Where a ray meets the segment that starts at `point`, before `limit`.
    ///
    /// A ray that starts inside another hair meets that hair at once if its axis is still ahead. So
    /// the number of hairs that a ray meets is the number of axes that it passes, whether hairs
    /// overlap or not.
    #[inline]
    fn intersect_segment(
        &self,
        ray: &Ray,
        point: u32,
        from: &RayOrigin,
        word: u32,
        limit: f32,
    ) -> Option<(f32, Cone, Span)> {
        let [a, b] = [self.points[point as usize], self.points[point as usize + 1]];
        if curve::misses(ray, Vec3A::from_vec4(a), Vec3A::from_vec4(b), a.w.abs().max(b.w.abs())) {
            return None;
        }
        let cone = Cone::of_segment(a, b)?;
        let span = cone.span(ray.origin, ray.direction)?;
        if span.exit <= 0.0 || span.enter >= limit {
            return None;
        }
        let span = cone.cut(span, ray.direction, self.normals(point, cone.axis))?;
        if span.exit <= 0.0 || span.enter >= limit {
            return None;
        }
        if (from.first..from.end).contains(&point) {
            if !span.side || span.enter <= from.clear {
                return None;
            }
        } else if span.enter <= 0.0 && span.nearest <= 0.0 {
            return None;
        }
        let t = span.enter.max(0.0);
        (self.opaque(point, &cone, &span, ray, t, word)).then_some((t, cone, span))
    }

    /// Normals of the planes that bound a segment: halfway between the axes at a joint, the axis at
    /// an end. Not normalised.
    #[inline]
    fn normals(&self, point: u32, axis: Vec3A) -> [Vec3A; 2] {
        let at = point as usize;
        let joined = |end: usize, from: usize| {
            if self.points[end].w.is_sign_negative() {
                axis
            } else {
                axis + (Vec3A::from_vec4(self.points[from + 1]) - Vec3A::from_vec4(self.points[from]))
                    .normalize()
            }
        };
        [joined(at, at.saturating_sub(1)), joined(at + 1, at + 1)]
    }

    /// Whether a hair that may be translucent stops a ray. One random number decides for the whole
    /// hair, so that joints do not count twice.
    #[inline]
    fn opaque(&self, point: u32, cone: &Cone, span: &Span, ray: &Ray, t: f32, word: u32) -> bool {
        let layer = self.layer_of(point);
        if layer.strands.opacity.is_empty() {
            return true;
        }
        let (strand, segment) = layer.place(point);
        let (along, _, _) = cone.place(span, ray.direction, t);
        let [a, b] = [segment, segment + 1].map(|point| layer.strands.opacity_at(strand, point));
        random(hash2(word, layer.first), strand as u32) < a + (b - a) * along
    }

    #[inline]
    fn layer_of(&self, point: u32) -> &HairLayer {
        let later = self.layers[1..].iter().rev().find(|c| point >= c.first);
        later.unwrap_or(&self.layers[0])
    }

    /// Shading data of a hair where it is met.
    pub fn hair_shading(&self, hit: &HairHit) -> HairShading<'_> {
        let layer = self.layer_of(hit.point);
        let (strand, segment) = layer.place(hit.point);
        let s = (segment as f32 + hit.along) / layer.strands.segments as f32;
        HairShading {
            layer: layer.strands.layer,
            fibre: &layer.fibre,
            hit: pelage_fur::fibre::Hit {
                tint: layer.strands.color(strand, s),
                glint_angle: layer.strands.hairs[strand].glint_angle,
                h: hit.h,
            },
        }
    }

    /// Origin of a ray along `direction` (unit) that leaves a hair which another ray has met.
    pub fn origin_on_hair(&self, hit: &HairHit, direction: Vec3A) -> RayOrigin {
        let layer = self.layer_of(hit.point);
        let (strand, segment) = layer.place(hit.point);
        let first = hit.point - segment as u32;
        debug_assert_eq!(first, layer.first + (strand * (layer.strands.segments + 1)) as u32);
        let sin = (1.0 - direction.dot(hit.axis).powi(2)).max(1e-6).sqrt();
        RayOrigin { first, end: first + layer.strands.segments as u32 + 1, clear: 1.01 * hit.radius / sin }
    }
}

impl HairLayer {
    /// Hair and segment that a point begins.
    #[inline]
    fn place(&self, point: u32) -> (usize, usize) {
        let stride = self.strands.segments as u32 + 1;
        let at = point - self.first;
        ((at / stride) as usize, (at % stride) as usize)
    }
}
