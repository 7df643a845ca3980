//! Vertex colours: their range and encoding.

use glam::Vec3;

/// Brings colours that a text has as numbers to 0..=1, and says what it did.
///
/// A program writes either 0..1 or 0..255. One value cannot tell: rounding gives 1.0001. They are
/// taken as 0..255 if at least two values are 2 or more, and more of these than of fractions
/// between 0 and 1. Values that are then too large are clamped.
pub(super) fn to_unit_range(colors: &mut [Vec3]) -> Option<String> {
    let values = || colors.iter().flat_map(|c| c.to_array());
    let largest = values().fold(0.0, f32::max);
    if largest <= 1.0 {
        return None;
    }
    let large = values().filter(|v| *v >= 2.0).count();
    let fractions = values().filter(|v| *v > 0.0 && *v < 1.0).count();
    let bytes = large >= 2 && large > fractions;
    let limit = if bytes { 255.0 } else { 1.0 };
    let mut clamped = 0;
    for c in colors.iter_mut() {
        clamped += usize::from(c.max_element() > limit);
        *c = c.min(Vec3::splat(limit)) / limit;
    }
    Some(match (bytes, clamped) {
        (true, 0) => format!("vertex colours go up to {largest}: read as 0..255"),
        (true, n) => format!("vertex colours go up to {largest}: read as 0..255, {n} above 255 clamped"),
        (false, n) => format!("{n} vertex colours above 1 clamped (the largest value is {largest})"),
    })
}
