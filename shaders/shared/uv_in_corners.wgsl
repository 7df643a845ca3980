// Corner uv of the skin from their own buffer. Needs: corner_uv (array<vec2f>).

fn uv_of_corner(corner: u32) -> vec2f {
    return corner_uv[corner];
}
