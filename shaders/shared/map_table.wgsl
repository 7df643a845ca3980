// Tables of the hairs' scattering lie behind the texels of the maps: the kernels that shade have no binding to spare.
// Needs: map_texels (array<vec2u>).

fn far_texel(i: u32) -> vec4f {
    let texel = map_texels[i];
    return vec4f(unpack2x16float(texel.x), unpack2x16float(texel.y));
}
