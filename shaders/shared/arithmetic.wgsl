// Small arithmetic that several passes need.

// A divisor: x, or `least` (with its sign) where |x| is smaller than it.
fn away_from_zero(x: f32, least: f32) -> f32 {
    return select(x, least, abs(x) < abs(least));
}

// Bilinear interpolation between four texels, a and b of the lower row, c and d of the upper one.
fn mix_bilinear(a: vec4f, b: vec4f, c: vec4f, d: vec4f, f: vec2f) -> vec4f {
    return mix(mix(a, b, f.x), mix(c, d, f.x), f.y);
}

// Lower of the two entries around a place counted in entries, and the weight of the upper one. `last` is the last entry's number.
fn lower_entry(at: f32, last: f32) -> vec2f {
    let low = min(floor(at), last - 1.0);
    return vec2f(low, at - low);
}
