// Corner uv of the skin from the buffer `corner_uv`. Needs: corner_uv (array<vec2f>).

fn uv_of_corner(corner: u32) -> vec2f {
    return corner_uv[corner];
}
