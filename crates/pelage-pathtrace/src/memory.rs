//! How much main memory hairs and the hierarchy over them take.

use super::{
    bvh,
    curve::Cone,
    segments::part_count,
    strands::{Hair, Strands},
};
use glam::Vec4;
use rayon::prelude::*;

/// Parts of a segment to expect before hairs have grown.
pub const EXPECTED_PARTS: u64 = 3;

/// Peak memory, bytes, of `hairs` hairs with `segments` segments in all: while the hierarchy over
/// their `parts` is built.
pub fn of_counts(hairs: u64, segments: u64, parts: u64) -> u64 {
    hairs * std::mem::size_of::<Hair>() as u64
        + (segments + hairs) * 16
        + parts * bvh::BYTES_A_PART
        + bvh::BYTES_MORE
}

/// [`of_counts`] for hairs that have grown.
pub fn of_strands(strands: &Strands) -> u64 {
    let stride = strands.segments + 1;
    let parts_of_hair = |points: &[Vec4]| -> u64 {
        points
            .windows(2)
            .filter_map(|p| Cone::of_segment(p[0], p[1]))
            .map(|cone| u64::from(part_count(&cone)))
            .sum()
    };
    let parts = strands.points.par_chunks(stride).map(parts_of_hair).sum();
    let hairs = strands.hairs.len() as u64;
    of_counts(hairs, hairs * strands.segments as u64, parts)
}

/// Bytes as GiB.
pub fn gib(bytes: u64) -> f64 {
    bytes as f64 / (1u64 << 30) as f64
}
