// Tables of the undercoat's scattering lie behind the light's nodes: the kernels that march have no binding to spare.
// Needs: source (array<vec4u>).

#import shared/halves

fn far_texel(i: u32) -> vec4f {
    let two = source[i / 2u];
    return unpack_half4(select(two.xy, two.zw, (i & 1u) == 1u));
}
