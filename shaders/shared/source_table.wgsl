// Scattering tables of the undercoat, behind the lattice's nodes in `node_light`: the kernels that
// march have no storage binding left. Needs: node_light (array<vec4u>).

#import shared/halves

fn far_texel(i: u32) -> vec4f {
    let two = node_light[i / 2u];
    return unpack_half4(select(two.xy, two.zw, (i & 1u) == 1u));
}
