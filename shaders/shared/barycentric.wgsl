// Barycentric coordinates in a triangle, and interpolation by them.

// All three coordinates from those at corners 1 and 2.
fn barycentric(l: vec2f) -> vec3f {
    return vec3f(1.0 - l.x - l.y, l);
}

// Barycentric coordinates of the point at `a` relative to corner 0 of a triangle with edges e1 and
// e2 from there. `n`: their cross product; `inverse`: 1 / dot(n, n).
fn barycentric_at(a: vec3f, e1: vec3f, e2: vec3f, n: vec3f, inverse: f32) -> vec3f {
    return barycentric(vec2f(dot(cross(a, e2), n) * inverse, dot(cross(e1, a), n) * inverse));
}

fn interpolate2(lambda: vec3f, a: vec2f, b: vec2f, c: vec2f) -> vec2f {
    return lambda.x * a + lambda.y * b + lambda.z * c;
}

fn interpolate3(lambda: vec3f, a: vec3f, b: vec3f, c: vec3f) -> vec3f {
    return lambda.x * a + lambda.y * b + lambda.z * c;
}

fn interpolate4(lambda: vec3f, a: vec4f, b: vec4f, c: vec4f) -> vec4f {
    return lambda.x * a + lambda.y * b + lambda.z * c;
}
