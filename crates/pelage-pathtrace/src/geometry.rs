//! What is traced: the skin's triangles and the hairs' segments, each in a hierarchy of its own.

use super::{
    bvh::{self, Bounds, Bvh, Part, Ray, Stack},
    curve::{self, Cone, Span},
    strands::Strands,
};
use glam::{Vec2, Vec3, Vec3A, Vec4};
use pelage_core::{Error, Result, Skin, World};
use pelage_fur::Layer;
use pelage_fur::fibre::Fibre;
use pelage_fur::groom;
use pelage_fur::groom::PackedGroom;
use pelage_fur::parameters::{Maps, Parameter, SkinPoint};
use pelage_fur::random::{hash2, random};
use rayon::prelude::*;

/// Hairs of a layer, without their points.
#[derive(Debug, Clone)]
struct Coat {
    strands: Strands,
    fibre: Fibre,
    /// Number of the first point.
    first: u32,
}

/// Skin and hairs.
pub struct Geometry {
    /// All hairs' points: position and radius; the sign of the radius is set where no joint is.
    points: Vec<Vec4>,
    coats: Vec<Coat>,
    hair: Bvh,
    skin: Skin,
    triangles: Bvh,
    groom: Box<PackedGroom>,
    bounds: Bounds,
}

/// A hair that a ray comes to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HairHit {
    /// Number of the segment's first point.
    point: u32,
    /// Unit, from root to tip.
    pub axis: Vec3A,
    /// On the axis, beside the place where the ray comes in.
    pub position: Vec3A,
    /// Place along the segment, 0..1.
    along: f32,
    /// cm.
    pub radius: f32,
    /// Offset across in radii, as [`pelage_fur::fibre::Hit::h`].
    pub h: f32,
}

/// Skin that a ray comes to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinHit {
    triangle: u32,
    /// Barycentric coordinates of corners 1 and 2.
    lambda: [f32; 2],
    /// Whether the ray comes from outside.
    pub front: bool,
}

/// What a ray comes to first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hit {
    /// A hair.
    Hair(HairHit),
    /// The skin.
    Skin(SkinHit),
}

/// What a ray leaves. A ray that leaves a hair starts on its axis. It meets the same hair again only where it comes in through the
/// side after it has gone out, that is beyond the radius over the sine of its angle to the axis.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RayOrigin {
    first: u32,
    end: u32,
    clear: f32,
}

/// Shading data of a hair.
#[derive(Debug, Clone, Copy)]
pub struct Shaded<'a> {
    /// Which coat.
    pub layer: Layer,
    /// Its scattering.
    pub fibre: &'a Fibre,
    /// Colour and glints; `h` as hit.
    pub hit: pelage_fur::fibre::Hit,
}

/// Most parts that a segment's box is cut into where the segment lies across the axes.
const MOST_PARTS: f32 = 4.0;

/// Sharper bends than a right angle get square ends.
const SHARPEST: f32 = 0.0;

impl Geometry {
    /// Takes the skin of `world` and hairs with their scattering.
    ///
    /// # Errors
    /// [`Error::Unsupported`] where a coat's points, hairs and opacities do not fit each other, or there are more than 2³¹ points.
    pub fn new(world: &World, coats: Vec<(Strands, Fibre)>) -> Result<Self> {
        let mut points: Vec<Vec4> = Vec::new();
        let mut kept = Vec::new();
        let mut parts: Vec<Part> = Vec::new();
        for (mut strands, fibre) in coats {
            check(&strands)?;
            let first = points.len() as u64;
            if first + strands.points.len() as u64 >= 1 << 31 {
                return Err(Error::Unsupported(
                    "there are more than 2^31 points of hairs: trace a patch".into(),
                ));
            }
            let mut own = std::mem::take(&mut strands.points);
            mark_ends(&strands, &mut own, first as u32, &mut parts);
            if points.is_empty() {
                points = own;
            } else {
                points.append(&mut own);
            }
            kept.push(Coat { strands, fibre, first: first as u32 });
        }
        parts.shrink_to_fit();
        let hair = Bvh::build(parts, |part| segment_bounds(&points, part));
        let skin = world.skin.clone();
        let all = (0..skin.triangles.len() as u32).map(|thing| Part { thing, part: 0, parts: 1 }).collect();
        let triangles = Bvh::build(all, |part| {
            let corners = skin.corners(part.thing as usize).map(Vec3A::from);
            // Boxes without thickness are missed by rays that rounding bends.
            let pad = Vec3A::splat(1e-5);
            Bounds {
                low: corners[0].min(corners[1]).min(corners[2]) - pad,
                high: corners[0].max(corners[1]).max(corners[2]) + pad,
            }
        });
        let (low, high) = points
            .iter()
            .map(|p| (Vec3A::from(p.truncate()), p.w.abs()))
            .chain(skin.positions.iter().map(|p| (Vec3A::from(*p), 0.0)))
            .fold((Vec3A::INFINITY, Vec3A::NEG_INFINITY), |(low, high), (p, r)| {
                (low.min(p - 2.0 * r), high.max(p + 2.0 * r))
            });
        Ok(Self {
            points,
            coats: kept,
            hair,
            skin,
            triangles,
            groom: Box::new(groom::pack(world)?),
            bounds: Bounds { low: low - 1e-3, high: high + 1e-3 },
        })
    }

    /// Box around everything.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// Bytes that are kept.
    pub fn bytes(&self) -> u64 {
        let hairs: usize = self.coats.iter().map(|c| std::mem::size_of_val(&c.strands.hairs[..])).sum();
        (std::mem::size_of_val(&self.points[..]) + hairs) as u64 + self.hair.bytes() + self.triangles.bytes()
    }

    /// What a ray comes to first, and how far away it is. `word` decides by chance which half-opaque hairs let it through.
    pub fn closest(&self, ray: &Ray, from: &RayOrigin, word: u32, stack: &mut Stack) -> Option<(Hit, f32)> {
        let skin = self.closest_skin(ray, stack);
        let limit = skin.map_or(f32::INFINITY, |(_, t)| t);
        let mut best: Option<(u32, Cone, Span)> = None;
        let reached = self.hair.walk(ray, limit, stack, |point, limit| {
            match self.meet(ray, point, from, word, limit) {
                Some((t, cone, span)) => {
                    best = Some((point, cone, span));
                    t
                }
                None => limit,
            }
        });
        let Some((point, cone, span)) = best else { return skin.map(|(hit, t)| (Hit::Skin(hit), t)) };
        let (along, radius, h) = cone.place(&span, ray.direction, reached);
        let position = cone.start + along * cone.length * cone.axis;
        Some((Hit::Hair(HairHit { point, axis: cone.axis, position, along, radius, h }), reached))
    }

    /// The skin that a ray comes to first, and how far away it is.
    pub fn closest_skin(&self, ray: &Ray, stack: &mut Stack) -> Option<(SkinHit, f32)> {
        let mut best = None;
        let t = self.triangles.walk(ray, f32::INFINITY, stack, |triangle, limit| {
            match self.meet_triangle(ray, triangle, limit) {
                Some((t, hit)) => {
                    best = Some(hit);
                    t
                }
                None => limit,
            }
        });
        best.map(|hit| (hit, t))
    }

    /// Whether anything stands in the way of a ray to infinity.
    pub fn blocked(&self, ray: &Ray, from: &RayOrigin, word: u32, stack: &mut Stack) -> bool {
        let skin = self.triangles.walk(ray, f32::INFINITY, stack, |triangle, limit| {
            self.meet_triangle(ray, triangle, limit).map_or(limit, |_| -1.0)
        });
        skin < 0.0
            || self.hair.walk(ray, f32::INFINITY, stack, |point, limit| {
                self.meet(ray, point, from, word, limit).map_or(limit, |_| -1.0)
            }) < 0.0
    }

    /// Where a ray meets the segment that starts at `point`, before `limit`.
    ///
    /// A ray that starts within another hair meets it if the axis is still ahead, and at once: so the number of hairs met on a way
    /// is that of the axes passed, whether hairs overlap or not.
    #[inline]
    fn meet(
        &self,
        ray: &Ray,
        point: u32,
        from: &RayOrigin,
        word: u32,
        limit: f32,
    ) -> Option<(f32, Cone, Span)> {
        let [a, b] = [self.points[point as usize], self.points[point as usize + 1]];
        if curve::passes(ray, Vec3A::from_vec4(a), Vec3A::from_vec4(b), a.w.abs().max(b.w.abs())) {
            return None;
        }
        let cone = Cone::new(Vec3A::from_vec4(a), Vec3A::from_vec4(b), [a.w.abs(), b.w.abs()])?;
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

    /// Whether a hair that may be half opaque stops a ray. The same for all segments of a hair, so that joints do not count twice.
    #[inline]
    fn opaque(&self, point: u32, cone: &Cone, span: &Span, ray: &Ray, t: f32, word: u32) -> bool {
        let coat = self.coat(point);
        if coat.strands.opacity.is_empty() {
            return true;
        }
        let (strand, segment) = coat.place(point);
        let (along, _, _) = cone.place(span, ray.direction, t);
        let [a, b] = [coat.strands.opacity[segment], coat.strands.opacity[segment + 1]];
        random(hash2(word, coat.first), strand as u32) < a + (b - a) * along
    }

    #[inline]
    fn coat(&self, point: u32) -> &Coat {
        let later = self.coats[1..].iter().rev().find(|c| point >= c.first);
        later.unwrap_or(&self.coats[0])
    }

    fn meet_triangle(&self, ray: &Ray, triangle: u32, limit: f32) -> Option<(f32, SkinHit)> {
        let [a, b, c] = self.skin.corners(triangle as usize).map(Vec3A::from);
        let (e1, e2) = (b - a, c - a);
        let p = ray.direction.cross(e2);
        let determinant = e1.dot(p);
        if determinant == 0.0 {
            return None;
        }
        let inverse = 1.0 / determinant;
        let s = ray.origin - a;
        let u = s.dot(p) * inverse;
        let q = s.cross(e1);
        let v = ray.direction.dot(q) * inverse;
        let t = e2.dot(q) * inverse;
        let met = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < limit;
        met.then_some((t, SkinHit { triangle, lambda: [u, v], front: determinant > 0.0 }))
    }

    /// What a hair looks like where it is hit.
    pub fn shaded(&self, hit: &HairHit) -> Shaded<'_> {
        let coat = self.coat(hit.point);
        let (strand, segment) = coat.place(hit.point);
        let s = (segment as f32 + hit.along) / coat.strands.segments as f32;
        Shaded {
            layer: coat.strands.layer,
            fibre: &coat.fibre,
            hit: pelage_fur::fibre::Hit {
                tint: coat.strands.color(strand, s),
                glint_angle: coat.strands.hairs[strand].glint_angle,
                h: hit.h,
            },
        }
    }

    /// What a ray along `direction` leaves that starts at a hit hair's axis.
    pub fn departure(&self, hit: &HairHit, direction: Vec3A) -> RayOrigin {
        let coat = self.coat(hit.point);
        let (strand, segment) = coat.place(hit.point);
        let first = hit.point - segment as u32;
        debug_assert_eq!(first, coat.first + (strand * (coat.strands.segments + 1)) as u32);
        let sin = (1.0 - direction.dot(hit.axis).powi(2)).max(1e-6).sqrt();
        RayOrigin { first, end: first + coat.strands.segments as u32 + 1, clear: 1.01 * hit.radius / sin }
    }

    /// Reflectance, smoothed normal and geometric normal of the skin where it is hit.
    pub fn skin(&self, hit: &SkinHit) -> (Vec3, Vec3, Vec3) {
        let corners = self.skin.triangles[hit.triangle as usize].map(|v| v as usize);
        let [l1, l2] = hit.lambda;
        let weights = [1.0 - l1 - l2, l1, l2];
        let mix = |values: &[Vec3]| -> Vec3 { (0..3).map(|k| weights[k] * values[corners[k]]).sum() };
        let position = mix(&self.skin.positions);
        let normal = mix(&self.skin.normals).normalize_or(Vec3::Y);
        let uv = self.skin.corner_uv.as_ref().map_or(Vec2::ZERO, |all| {
            let uv = all[hit.triangle as usize];
            (0..3).map(|k| weights[k] * uv[k]).sum()
        });
        let color = if self.skin.colors.is_empty() { Vec3::ONE } else { mix(&self.skin.colors) };
        let maps = Maps { groom: &self.groom.groom, texels: &self.groom.texels };
        let reflectance = maps.color(Parameter::BaseColor, &SkinPoint { position, normal, uv, color });
        let [a, b, c] = self.skin.corners(hit.triangle as usize);
        let flat = (b - a).cross(c - a).normalize_or(normal);
        (reflectance.clamp(Vec3::ZERO, Vec3::ONE), normal, flat)
    }
}

impl Coat {
    /// Hair and segment of a point.
    #[inline]
    fn place(&self, point: u32) -> (usize, usize) {
        let stride = self.strands.segments as u32 + 1;
        let at = point - self.first;
        ((at / stride) as usize, (at % stride) as usize)
    }
}

fn check(strands: &Strands) -> Result<()> {
    let points = (strands.segments + 1) * strands.hairs.len();
    let fits = (1..=64).contains(&strands.segments)
        && strands.points.len() == points
        && (strands.opacity.is_empty() || strands.opacity.len() == strands.segments + 1)
        && strands.points.iter().all(|p| p.is_finite());
    if fits {
        return Ok(());
    }
    Err(Error::Unsupported(format!(
        "{:?} hairs: {} hairs of {} segments (1 to 64) with {} points, expected {points} finite ones; {} opacities, expected none or {}",
        strands.layer,
        strands.hairs.len(),
        strands.segments,
        strands.points.len(),
        strands.opacity.len(),
        strands.segments + 1
    )))
}

/// Sets the sign of the radius where a point is no joint, and lists the parts of the segments that are there.
fn mark_ends(strands: &Strands, points: &mut [Vec4], first: u32, parts: &mut Vec<Part>) {
    let stride = strands.segments + 1;
    parts.reserve(points.len());
    for (i, hair) in strands.hairs.iter().enumerate() {
        let own = &mut points[i * stride..][..stride];
        let mut before: Option<Vec3A> = None;
        for k in 0..stride {
            let segment = (k < strands.segments && hair.present & (1 << k) != 0)
                .then(|| {
                    let (a, b) = (own[k], own[k + 1]);
                    Cone::new(Vec3A::from_vec4(a), Vec3A::from_vec4(b), [a.w.abs(), b.w.abs()])
                })
                .flatten();
            let joint = before.zip(segment).is_some_and(|(a, s)| a.dot(s.axis) > SHARPEST);
            let radius = own[k].w.abs();
            own[k].w = if joint { radius } else { -radius };
            before = segment.map(|s| s.axis);
            if let Some(cone) = segment {
                let count = pieces(&cone);
                let thing = first + (i * stride + k) as u32;
                parts.extend((0..count).map(|part| Part { thing, part, parts: count }));
            }
        }
    }
}

/// How many boxes hold a segment well: one along the axes, more across them.
fn pieces(cone: &Cone) -> u16 {
    let across = (cone.axis.abs() * cone.length).to_array();
    let [a, b, c] = across;
    let second = a.max(b).min(a.max(c)).min(b.max(c));
    (second / (12.0 * cone.radius.max(1e-6))).clamp(1.0, MOST_PARTS) as u16
}

/// Box around a part of a segment, a little larger than rounding can move it.
fn segment_bounds(points: &[Vec4], part: Part) -> Bounds {
    let at = part.thing as usize;
    let (a, b) = (points[at], points[at + 1]);
    let (start, end) = (Vec3A::from_vec4(a), Vec3A::from_vec4(b));
    let axis = (end - start).normalize_or_zero();
    let bend = |joint: usize, other: usize| {
        if points[joint].w.is_sign_negative() {
            return 0.0;
        }
        let next =
            (Vec3A::from_vec4(points[other + 1]) - Vec3A::from_vec4(points[other])).normalize_or_zero();
        let cos = axis.dot(next).clamp(0.0, 1.0);
        ((1.0 - cos) / (1.0 + cos)).sqrt()
    };
    let (from, to) =
        (f32::from(part.part) / f32::from(part.parts), f32::from(part.part + 1) / f32::from(part.parts));
    let disc = |s: f32, bend: f32| {
        let radius = a.w.abs() + (b.w.abs() - a.w.abs()) * s;
        (start.lerp(end, s), curve::extent(axis, radius * (1.0 + bend), bend))
    };
    let (p, p_extent) = disc(from, if part.part == 0 { bend(at, at.saturating_sub(1)) } else { 0.0 });
    let (q, q_extent) = disc(to, if part.part + 1 == part.parts { bend(at + 1, at + 1) } else { 0.0 });
    let pad = 4e-7 * (p.abs().max(q.abs()).max_element() + 1.0);
    Bounds { low: (p - p_extent).min(q - q_extent) - pad, high: (p + p_extent).max(q + q_extent) + pad }
}

/// Parts of a segment to reckon with before it has grown.
pub const USUAL_PARTS: u64 = 3;

/// Bytes that hairs of `segments` segments in all take while the hierarchy over their parts is built, which is the most.
pub fn bytes(hairs: u64, segments: u64, parts: u64) -> u64 {
    hairs * std::mem::size_of::<super::strands::Hair>() as u64
        + (segments + hairs) * 16
        + parts * bvh::BYTES_A_PART
        + bvh::BYTES_MORE
}

/// [`bytes`] of hairs that have grown.
pub fn bytes_of(strands: &Strands) -> u64 {
    let stride = strands.segments + 1;
    let of_hair = |points: &[Vec4]| -> u64 {
        points
            .windows(2)
            .filter_map(|p| {
                Cone::new(Vec3A::from_vec4(p[0]), Vec3A::from_vec4(p[1]), [p[0].w.abs(), p[1].w.abs()])
            })
            .map(|cone| u64::from(pieces(&cone)))
            .sum()
    };
    let parts = strands.points.par_chunks(stride).map(of_hair).sum();
    let hairs = strands.hairs.len() as u64;
    bytes(hairs, hairs * strands.segments as u64, parts)
}
