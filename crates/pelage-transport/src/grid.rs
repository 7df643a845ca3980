//! Sampling grids of the tables: the value that each index stands for, and the place of a value
//! among them.

/// Hair albedos in a table.
pub const ALBEDOS: usize = 10;
/// Optical depths towards the light in a table.
pub const DEPTHS: usize = 20;
/// Cosines to the skin's normal of a light or a view in a table, or sines of the inclination to a
/// hair.
pub const COSINES: usize = 16;
/// Angles between the skin's normal and a guard hair in a table, and as many azimuths of the normal
/// around the hair.
pub const TILTS: usize = 8;
/// Rows of `response_table` in `shaders/shared/transport.wgsl`.
pub const ROWS: usize = 5 + TILTS * TILTS;
/// Largest optical depth in a table; also that of a light that is blocked.
pub const DEEPEST: f32 = 18.0;

/// Albedo of index `i`. The reflectance of a deep coat is about linear in the square root of 1 -
/// albedo, so the albedos are evenly spaced in that root.
pub fn albedo(i: usize) -> f32 {
    let x = 1.0 - i as f32 / (ALBEDOS - 1) as f32;
    1.0 - x * x
}

/// Inverse of [`albedo`], as a fraction of the last index.
pub(crate) fn albedo_fraction(albedo: f32) -> f32 {
    1.0 - (1.0 - albedo).max(0.0).sqrt()
}

/// Optical depth of index `i`: denser where it is small, for there the light changes most.
pub fn depth(i: usize) -> f32 {
    let x = i as f32 / (DEPTHS - 1) as f32;
    DEEPEST * x * x
}

/// Inverse of [`depth`], as a fraction of the last index.
pub(crate) fn depth_fraction(tau: f32) -> f32 {
    (tau / DEEPEST).sqrt()
}

/// Cosine of index `i`: from `lowest`, which is 0 for lights and -1 for views, to 1. Sines of an
/// inclination use the same grid.
pub(crate) fn cosine(i: usize, lowest: f32) -> f32 {
    lowest + (1.0 - lowest) * i as f32 / (COSINES - 1) as f32
}

/// Inverse of [`cosine`] from -1, as a fraction of the last index.
pub(crate) fn signed_fraction(cosine: f32) -> f32 {
    0.5 * cosine + 0.5
}

/// The index below a `fraction` of the last of `count` indices, and the weight of the next.
pub(crate) fn place(fraction: f32, count: usize) -> (usize, f32) {
    let scaled = fraction.clamp(0.0, 1.0) * (count - 1) as f32;
    let index = (scaled as usize).min(count - 2);
    (index, scaled - index as f32)
}
