// Strand vertices: xyz position (cm); in w radius (units of 0.01 cm) and opacity as halves.
// Needs: strand_vertices (array<vec4f>).

// Position and radius in cm.
fn pack_strand_vertex(p: vec3f, radius: f32, opacity: f32) -> vec4f {
    return vec4f(p, bitcast<f32>(pack2x16float(vec2f(radius * 100.0, opacity))));
}

fn strand_radius(v: vec4f) -> f32 {
    return unpack2x16float(bitcast<u32>(v.w)).x * 0.01;
}

fn strand_opacity(v: vec4f) -> f32 {
    return unpack2x16float(bitcast<u32>(v.w)).y;
}

// Unit tangent at vertex k of a strand that starts at `first`.
fn strand_tangent(first: u32, k: u32, segments: u32) -> vec3f {
    let before = strand_vertices[first + select(k - 1u, 0u, k == 0u)].xyz;
    let after = strand_vertices[first + min(k + 1u, segments)].xyz;
    let d = after - before;
    return d * inverseSqrt(max(dot(d, d), 1e-20));
}
