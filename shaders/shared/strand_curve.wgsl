// The curve of a combed strand: a cubic Bezier whose control polygon has three legs of equal
// length. [Andersen2016] sec. 2 names Bezier shaping; the formulas are ours. Vectors are relative
// to the root.

// Control points 1 to 3; point 0 is the root.
struct ControlPolygon {
    p1: vec3f,
    p2: vec3f,
    p3: vec3f,
}

// Unit directions of the three legs. `n`: normal of the skin; `lean`: tangential, its length is the
// tangent of the angle.
fn leg_directions(n: vec3f, lean: vec3f, gravity: f32) -> array<vec3f, 3> {
    let fall = vec3f(0.0, -gravity, 0.0);
    return array<vec3f, 3>(normalize(n + 0.5 * lean), normalize(n + 0.9 * lean + 0.35 * fall),
        normalize(n + 1.25 * lean + fall));
}

// Joins the legs. Control points 2 and 3 are raised to the tangent plane if they lie below it.
fn control_polygon(n: vec3f, leg1: vec3f, leg2: vec3f, leg3: vec3f) -> ControlPolygon {
    let p1 = leg1;
    let p2 = p1 + leg2;
    // The third leg starts at the second control point before that is raised.
    let p3 = p2 + leg3;
    return ControlPolygon(p1, above_plane(p2, n), above_plane(p3, n));
}

// p, raised to the tangent plane at the root if it lies below.
fn above_plane(p: vec3f, n: vec3f) -> vec3f {
    return p - n * min(0.0, dot(p, n));
}

// The curve at s (0 root, 1 tip).
fn bezier(polygon: ControlPolygon, s: f32) -> vec3f {
    let r = 1.0 - s;
    return 3.0 * r * r * s * polygon.p1 + 3.0 * r * s * s * polygon.p2 + s * s * s * polygon.p3;
}
