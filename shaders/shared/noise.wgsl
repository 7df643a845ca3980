// Simplex noise with the permutation and gradients of the `noise` crate, which tests compare with.
// Range -1..1. [Perlin2001], [Gustavson2005]
// Needs: noise (uniform Noise).

struct Noise {
    permutation: array<vec4u, 16>, // 256 bytes, four per word
    gradients2: array<vec4f, 8>,   // xy
    gradients3: array<vec4f, 32>,  // xyz
}

fn permuted(index: u32) -> u32 {
    let i = index & 255u;
    return (noise.permutation[i >> 4u][(i >> 2u) & 3u] >> ((i & 3u) * 8u)) & 255u;
}

// Contribution of a corner. `offset`: squared distance; `slope`: dot product of gradient and
// offset.
fn surflet(offset: f32, slope: f32) -> f32 {
    let t = max(0.0, 1.0 - 2.0 * offset);
    let t2 = t * t;
    return (2.0 * t2 + t2 * t2) * slope;
}

fn corner2(cell: vec2i, d: vec2f) -> f32 {
    let h = permuted(permuted(u32(cell.x)) ^ (u32(cell.y) & 255u));
    return surflet(dot(d, d), dot(d, noise.gradients2[h & 7u].xy));
}

fn simplex2(p: vec2f) -> f32 {
    const SKEW = 0.36602540;
    const UNSKEW = 0.21132487;
    let base = floor(p + (p.x + p.y) * SKEW);
    let cell = vec2i(base);
    let d0 = p - (base - (base.x + base.y) * UNSKEW);
    let order = select(vec2i(0, 1), vec2i(1, 0), d0.x > d0.y);
    return corner2(cell, d0)
        + corner2(cell + order, d0 - vec2f(order) + UNSKEW)
        + corner2(cell + 1, d0 - 1.0 + 2.0 * UNSKEW);
}

fn corner3(cell: vec3i, d: vec3f) -> f32 {
    let h = permuted(permuted(permuted(u32(cell.x)) ^ (u32(cell.y) & 255u)) ^ (u32(cell.z) & 255u));
    return surflet(dot(d, d), dot(d, noise.gradients3[h & 31u].xyz));
}

fn simplex3(p: vec3f) -> f32 {
    const SKEW = 0.33333333;
    const UNSKEW = 0.16666667;
    let base = floor(p + (p.x + p.y + p.z) * SKEW);
    let cell = vec3i(base);
    let d0 = p - (base - (base.x + base.y + base.z) * UNSKEW);
    // Which of the six tetrahedra: ranks of the three offsets.
    let x_ge_y = d0.x >= d0.y;
    let y_ge_z = d0.y >= d0.z;
    let x_ge_z = d0.x >= d0.z;
    let first = vec3i(i32(x_ge_y && x_ge_z), i32(!x_ge_y && y_ge_z), i32(!x_ge_z && !y_ge_z));
    let second = 1 - vec3i(i32(!x_ge_y && !x_ge_z), i32(x_ge_y && !y_ge_z), i32(x_ge_z && y_ge_z));
    return corner3(cell, d0)
        + corner3(cell + first, d0 - vec3f(first) + UNSKEW)
        + corner3(cell + second, d0 - vec3f(second) + 2.0 * UNSKEW)
        + corner3(cell + 1, d0 - 1.0 + 3.0 * UNSKEW);
}
