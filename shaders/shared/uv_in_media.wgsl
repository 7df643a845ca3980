// Corner uv for kernels that evaluate densities: no volume is stored then, and the buffer
// `media_or_uv` holds the uv. Needs: media_or_uv (array<u32>).

fn uv_of_corner(corner: u32) -> vec2f {
    return bitcast<vec2f>(vec2u(media_or_uv[2u * corner], media_or_uv[2u * corner + 1u]));
}
