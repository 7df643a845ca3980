// Corner uv for passes that evaluate densities: no volume is stored then, and its buffer `cells`
// carries the uv. Needs: cells (array<u32>).

fn uv_of_corner(corner: u32) -> vec2f {
    return bitcast<vec2f>(vec2u(cells[2u * corner], cells[2u * corner + 1u]));
}
