// Groom parameters: a constant, the vertex colour or an image map, read at a point of the skin.
// Needs: groom (uniform Groom), maps_and_tables (array<vec2u>, four halves per texel).

#import shared/map_lookup
#import shared/shell_types

const GUARD_DENSITY: u32 = 0u;
const GUARD_LENGTH: u32 = 1u;
const GUARD_THICKNESS: u32 = 2u;
const GUARD_COMB: u32 = 3u;
const GUARD_CLUMP: u32 = 4u;
const GUARD_CURL: u32 = 5u;
const GUARD_FRIZZ: u32 = 6u;
const GUARD_COLOR_ROOT: u32 = 7u;
const GUARD_COLOR_TIP: u32 = 8u;
const UNDERCOAT_DENSITY: u32 = 9u;
const UNDERCOAT_HEIGHT: u32 = 10u;
const UNDERCOAT_COLOR_ROOT: u32 = 11u;
const UNDERCOAT_COLOR_TIP: u32 = 12u;
const BASE_COLOR: u32 = 13u;
const SHELL_COLOR: u32 = 14u;
const SHELL_LENGTH: u32 = 15u;

// The point at a vertex of the skin.
fn point_of_vertex(vertex: ShellVertex, uv: vec2f) -> SkinPoint {
    return SkinPoint(vertex.position, vertex.normal, uv, unpack4x8unorm(vertex.color).rgb);
}

// A scalar parameter at a point of the skin.
fn scalar(parameter: u32, at: SkinPoint) -> f32 {
    let p = groom.parameters[parameter].value.x;
    return p * parameter_texel(groom.parameters[parameter], at)[groom.parameters[parameter].channel] + groom.parameters[parameter].offset;
}

// A colour parameter at a point of the skin, linear RGB.
fn color(parameter: u32, at: SkinPoint) -> vec3f {
    return color_of(groom.parameters[parameter], at);
}
