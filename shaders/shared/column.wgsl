// Columns of the optical-depth lattice. Needs: fur (uniform FurParameters).

#import shared/barycentric

struct Column {
    prism: u32,       // one of the triangles on which it stands
    grid: u32,        // grid point in that triangle: i and j, 16 bits each
    area: f32,        // its share of the skin, cm2
    density: f32,     // undercoat density relative to fur.undercoat.density
    color_root: u32,  // albedo of the undercoat at the skin and at the tips
    color_tip: u32,
    color_base: u32,  // reflectance of the skin
    padding: u32,
    blocked: vec2u,   // one bit per light: blocked by the skin itself outside the shell
}

// Barycentric coordinates of a column in its triangle.
fn column_lambda(grid: u32) -> vec3f {
    return barycentric(vec2f(f32(grid & 0xffffu), f32(grid >> 16u)) / f32(fur.lattice.cells));
}

// Word and bit of a light in `blocked`.
fn blocked_word(light: u32) -> u32 {
    return light >> 5u;
}

fn blocked_bit(light: u32) -> u32 {
    return 1u << (light & 31u);
}
