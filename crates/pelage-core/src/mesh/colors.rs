//! Vertex colours: their range and encoding.

use glam::Vec3;

/// Brings colours that a text has as numbers to 0..=1, and returns notes of what it did.
///
/// A program writes either 0..1 or 0..255. One value cannot tell: rounding gives 1.0001. They are
/// taken as 0..255 if at least two values are 2 or more, and more of these than of fractions
/// between 0 and 1. Values that are then too large are clamped, and so are negative ones; a colour
/// with a channel that is not a finite number becomes white.
pub(super) fn to_unit_range(colors: &mut [Vec3]) -> Vec<String> {
    let mut notes = Vec::new();
    let mut replaced = |what: &str, bad: &dyn Fn(Vec3) -> bool, by: &dyn Fn(Vec3) -> Vec3| {
        let found = colors.iter_mut().filter(|c| bad(**c));
        let n = found.map(|c| *c = by(*c)).count();
        if n > 0 {
            notes.push(format!("{n} vertex colours {what}"));
        }
    };
    replaced("that are not finite numbers, taken as white", &|c| !c.is_finite(), &|_| Vec3::ONE);
    replaced("below 0 clamped", &|c| c.min_element() < 0.0, &|c| c.max(Vec3::ZERO));
    notes.extend(scaled(colors));
    notes
}

/// Brings colours of finite numbers of at least 0 to 0..=1.
fn scaled(colors: &mut [Vec3]) -> Option<String> {
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

/// Clamps colours that a file has in 0..=1 by definition, and returns a note of how many it
/// changed.
pub(super) fn clamped(colors: &mut [Vec3]) -> Option<String> {
    let mut n = 0;
    for c in colors {
        let unit = if c.is_finite() { c.clamp(Vec3::ZERO, Vec3::ONE) } else { Vec3::ONE };
        n += usize::from(unit != *c);
        *c = unit;
    }
    (n > 0).then(|| format!("{n} vertex colours outside 0..1 clamped"))
}
