//! Hairs as the curves that remain where some of their segments are absent.

use glam::{Vec3, Vec4};
use pelage_fur::Layer;
use pelage_pathtrace::strands::Strands;

/// A maximal run of present segments of a hair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Run<'a> {
    /// Number of the hair.
    pub hair: usize,
    /// Index of the first point on the hair.
    pub first: usize,
    /// Positions in world space and radii, cm; at least two points.
    pub points: &'a [Vec4],
}

/// One segment: a frustum between two points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// Number of the hair.
    pub hair: usize,
    /// Index of the segment on the hair.
    pub number: usize,
    /// Positions in world space and radii, cm.
    pub ends: [Vec4; 2],
}

/// The runs of all hairs, in order, from root to tip. A hair with gaps has several.
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

/// All segments that are present and have a length.
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

/// Counts of a layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Runs of present segments.
    pub runs: u64,
    /// Points of all runs.
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

/// Description of the layer, with counts.
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

/// The colour of all hairs of the layer, if it is the same for all from root to tip.
pub fn one_color(strands: &Strands) -> Option<Vec3> {
    let first = strands.hairs.first()?.color_root;
    let same = strands.hairs.iter().all(|h| h.color_root == first && h.color_tip == first);
    same.then_some(first.clamp(Vec3::ZERO, Vec3::ONE))
}
