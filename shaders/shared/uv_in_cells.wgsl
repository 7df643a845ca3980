// Corner uv of the skin for passes that evaluate densities: there is no stored volume then, and its buffer carries the uv.

fn uv_of_corner(corner: u32) -> vec2f {
    return bitcast<vec2f>(vec2u(cells[2u * corner], cells[2u * corner + 1u]));
}
