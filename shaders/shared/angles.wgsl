// Angles between unit vectors, and unit vectors perpendicular to one.

// Sine of an angle in [0, pi] from its cosine, or cosine of one in [-pi/2, pi/2] from its sine.
fn complement(c: f32) -> f32 {
    return sqrt(max(0.0, 1.0 - c * c));
}

// Sine of the angle between two unit vectors.
fn sine_between(a: vec3f, b: vec3f) -> f32 {
    return complement(dot(a, b));
}

// Sine of the inclination of w from the plane normal to the tangent; both unit.
fn inclination_sine(tangent: vec3f, w: vec3f) -> f32 {
    return clamp(dot(tangent, w), -1.0, 1.0);
}

// Cosine of the angle between two vectors of any length; rounding may take it out of [-1, 1].
fn cosine_between(a: vec3f, b: vec3f) -> f32 {
    return dot(a, b) * inverseSqrt(max(dot(a, a) * dot(b, b), 1e-12));
}

// Two unit vectors that form an orthonormal frame with a third.
struct Sides {
    side: vec3f,
    other: vec3f,
}

fn sides_of(n: vec3f) -> Sides {
    let side = normalize(cross(select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), abs(n.x) > 0.7), n));
    return Sides(side, cross(n, side));
}

// The unit vector at `azimuth` (radians) in the plane of the two vectors, from `side` towards
// `other`.
fn side_at(sides: Sides, azimuth: f32) -> vec3f {
    return cos(azimuth) * sides.side + sin(azimuth) * sides.other;
}
