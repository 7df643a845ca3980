//! Arithmetic that several modules need.

/// The cubic with zero slope at both ends, x² (3 − 2x): 0 at 0 and 1 at 1.
#[inline]
pub fn ease(x: f32) -> f32 {
    x * x * (3.0 - 2.0 * x)
}

/// The inverse of [`ease`] on 0..1.
pub fn inverse_ease(y: f32) -> f32 {
    0.5 - ((1.0 - 2.0 * y.clamp(0.0, 1.0)).asin() / 3.0).sin()
}

/// `smoothstep` of WGSL: [`ease`], stretched to `low..high`.
#[inline]
pub fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    ease(((x - low) / (high - low)).clamp(0.0, 1.0))
}
