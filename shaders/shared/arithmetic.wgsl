// Arithmetic that several passes need.

// A safe divisor: x, or `least` where x is closer to zero.
fn away_from_zero(x: f32, least: f32) -> f32 {
    return select(x, least, abs(x) < abs(least));
}

// Bilinear interpolation between four texels, a and b of the lower row, c and d of the upper one.
fn mix_bilinear(a: vec4f, b: vec4f, c: vec4f, d: vec4f, f: vec2f) -> vec4f {
    return mix(mix(a, b, f.x), mix(c, d, f.x), f.y);
}

// For linear interpolation between entries 0 to `last` of a table: the entry below `at` and the
// weight of the next one.
fn lower_entry(at: f32, last: f32) -> vec2f {
    let low = min(floor(at), last - 1.0);
    return vec2f(low, at - low);
}
