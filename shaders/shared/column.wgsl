// Columns of the light lattice. Needs: shared/lattice.

struct Column {
    corner: u32,      // 3 x triangle + corner, where the lattice has one cell a triangle
    area: f32,        // its share of the skin, cm2
    density: f32,     // undercoat density relative to the mean
    color_root: u32,  // albedo of the undercoat at the skin and at the tips
    color_tip: u32,
    color_base: u32,  // reflectance of the skin
    blocked: vec2u,   // one bit a light: the skin itself stands in the way outside the shell
}

// Where a column stands.
struct Spot {
    prism: u32,
    lambda: vec3f,
}

fn column_spot(column: u32, corner: u32) -> Spot {
    if fur.lattice == 1u {
        let k = corner % 3u;
        return Spot(corner / 3u, vec3f(f32(k == 0u), f32(k == 1u), f32(k == 2u)));
    }
    let per_triangle = columns_per_triangle();
    let prism = column / per_triangle;
    var i = column % per_triangle;
    var j = 0u;
    while i > fur.lattice - j {
        i -= fur.lattice - j + 1u;
        j++;
    }
    let l = vec2f(f32(i), f32(j)) / f32(fur.lattice);
    return Spot(prism, vec3f(1.0 - l.x - l.y, l));
}
