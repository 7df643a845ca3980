// Scattering tables of hairs, behind the texels of the maps: the kernels that shade have no storage
// binding left. Needs: maps_and_tables (array<vec2u>).

#import shared/halves

fn far_texel(i: u32) -> vec4f {
    return unpack_half4(maps_and_tables[i]);
}
