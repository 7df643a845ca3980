//! Segments of hairs as a hierarchy takes them: checked, with their ends marked, cut into parts
//! that boxes hold closely.

use super::{
    bvh::{Bounds, Part},
    curve::{self, Cone},
    strands::Strands,
};
use glam::{Vec3A, Vec4};
use pelage_core::{Error, Result};

/// Most parts that a segment is cut into where it lies oblique to the axes.
const MOST_PARTS: f32 = 4.0;

/// Cosine of the sharpest bend that gets a mitred joint, a right angle; hairs that bend more are
/// cut square there.
const SHARPEST: f32 = 0.0;

/// Whether points, hairs and opacities fit each other.
///
/// # Errors
/// [`Error::Unsupported`] with the numbers found and expected.
pub(super) fn check(strands: &Strands) -> Result<()> {
    let points = (strands.segments + 1) * strands.hairs.len();
    let fits = (1..=64).contains(&strands.segments)
        && strands.points.len() == points
        && [0, strands.segments + 1, points].contains(&strands.opacity.len())
        && [0, strands.hairs.len()].contains(&strands.color_transitions.len())
        && strands.points.iter().all(|p| p.is_finite());
    if fits {
        return Ok(());
    }
    Err(Error::Unsupported(format!(
        "{:?}: found {} hairs of {} segments (expected 1 to 64) with {} points (expected {points}, all finite) and {} opacities (expected none, {} or {points}) and {} colour transitions (expected none or one for each hair)",
        strands.layer,
        strands.hairs.len(),
        strands.segments,
        strands.points.len(),
        strands.opacity.len(),
        strands.segments + 1,
        strands.color_transitions.len()
    )))
}

/// Makes the radius negative where a point is no joint between two segments, and appends the parts
/// of the segments that are present. `first` is the number of the first point.
pub(super) fn mark_ends(strands: &Strands, points: &mut [Vec4], first: u32, parts: &mut Vec<Part>) {
    let stride = strands.segments + 1;
    parts.reserve(points.len());
    for (i, hair) in strands.hairs.iter().enumerate() {
        let own = &mut points[i * stride..][..stride];
        let mut before: Option<Vec3A> = None;
        for k in 0..stride {
            let segment = (k < strands.segments && hair.present & (1 << k) != 0)
                .then(|| Cone::of_segment(own[k], own[k + 1]))
                .flatten();
            let joint = before.zip(segment).is_some_and(|(a, s)| a.dot(s.axis) > SHARPEST);
            let radius = own[k].w.abs();
            own[k].w = if joint { radius } else { -radius };
            before = segment.map(|s| s.axis);
            if let Some(cone) = segment {
                let count = part_count(&cone);
                let thing = first + (i * stride + k) as u32;
                parts.extend((0..count).map(|part| Part { thing, part, parts: count }));
            }
        }
    }
}

/// Number of boxes that hold a segment closely: one where it lies along an axis, more where it lies
/// oblique to them.
pub(super) fn part_count(cone: &Cone) -> u16 {
    let across = (cone.axis.abs() * cone.length).to_array();
    let [a, b, c] = across;
    let second = a.max(b).min(a.max(c)).min(b.max(c));
    (second / (12.0 * cone.radius.max(1e-6))).clamp(1.0, MOST_PARTS) as u16
}

/// Box around a part of a segment, with a margin for rounding.
pub(super) fn part_bounds(points: &[Vec4], part: Part) -> Bounds {
    let at = part.thing as usize;
    let (a, b) = (points[at], points[at + 1]);
    let (start, end) = (Vec3A::from_vec4(a), Vec3A::from_vec4(b));
    let axis = (end - start).normalize_or_zero();
    // Tangent of half the angle between the segments at a joint.
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
