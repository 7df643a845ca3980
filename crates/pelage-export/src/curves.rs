//! Hairs cut into the pieces that are there.

use glam::{Vec3, Vec4};
use pelage_fur::Layer;
use pelage_pathtrace::strands::Strands;

/// Neighbouring segments of a hair that are all present.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run<'a> {
    /// Number of the hair.
    pub hair: usize,
    /// Number of the first point on the hair.
    pub first: usize,
    /// World space and radius, cm; at least two.
    pub points: &'a [Vec4],
}

/// One segment: a frustum between two points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Number of the hair.
    pub hair: usize,
    /// Number of the segment on the hair.
    pub number: usize,
    /// World space and radius, cm.
    pub ends: [Vec4; 2],
}

/// The pieces of all hairs, in order, root first. Where segments are cut out, a hair becomes several.
pub fn runs(strands: &Strands) -> impl Iterator<Item = Run<'_>> {
    strands.points.chunks_exact(strands.segments + 1).enumerate().flat_map(move |(hair, points)| {
        let present = strands.hairs.get(hair).map_or(0, |h| h.present);
        let there = move |k: usize| k < strands.segments.min(64) && present >> k & 1 == 1;
        (0..strands.segments).filter(move |k| there(*k) && (*k == 0 || !there(*k - 1))).map(move |first| {
            let end = (first..).find(|k| !there(*k)).unwrap_or(first);
            Run { hair, first, points: &points[first..=end] }
        })
    })
}

/// All segments that are there and have a length.
pub fn segments(strands: &Strands) -> impl Iterator<Item = Segment> + '_ {
    runs(strands).flat_map(|run| {
        run.points.windows(2).enumerate().filter_map(move |(k, ends)| {
            let ends = [ends[0], ends[1]];
            let length = ends[0].truncate().distance_squared(ends[1].truncate());
            (length > 0.0).then_some(Segment { hair: run.hair, number: run.first + k, ends })
        })
    })
}

/// Colour of a hair at point `k` (fractions lie between points), linear RGB.
pub fn color(strands: &Strands, hair: usize, k: f32) -> Vec3 {
    strands.color(hair, k / strands.segments as f32)
}

/// How much there is of a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Pieces of hairs.
    pub runs: u64,
    /// Points of all pieces.
    pub points: u64,
}

impl Counts {
    /// Counts a layer.
    pub fn of(strands: &Strands) -> Self {
        runs(strands).fold(Self::default(), |c, run| Self {
            runs: c.runs + 1,
            points: c.points + run.points.len() as u64,
        })
    }
}

/// The layer in words, with counts.
pub fn holds(strands: &Strands) -> String {
    let Counts { runs, points } = Counts::of(strands);
    let cut = if runs == strands.hairs.len() as u64 { String::new() } else { format!(" in {runs} pieces") };
    format!("{} hairs of the {}{cut}, {} segments", strands.hairs.len(), name(strands.layer), points - runs)
}

/// The layer's name in files.
pub fn name(layer: Layer) -> &'static str {
    match layer {
        Layer::Guard => "guard",
        Layer::Undercoat => "undercoat",
    }
}

/// Whether all hairs of the layer have the same colour from root to tip.
pub fn one_color(strands: &Strands) -> Option<Vec3> {
    let first = strands.hairs.first()?.color_root;
    let same = strands.hairs.iter().all(|h| h.color_root == first && h.color_tip == first);
    same.then_some(first.clamp(Vec3::ZERO, Vec3::ONE))
}
