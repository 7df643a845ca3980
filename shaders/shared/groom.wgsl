// Groom parameters: a constant, the vertex colour or an image map, read at a point of the skin.
// Needs: groom (uniform Groom), maps_and_tables (array<vec2u>, four halves per texel).

#import shared/arithmetic
#import shared/groom_types
#import shared/halves
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

// A point of the skin where parameters are read.
struct SkinPoint {
    position: vec3f,
    normal: vec3f,
    uv: vec2f,
    color: vec4f, // vertex colour and alpha
}

// The point at a vertex of the skin.
fn point_of_vertex(vertex: ShellVertex, uv: vec2f) -> SkinPoint {
    return SkinPoint(vertex.position, vertex.normal, uv, unpack4x8unorm(vertex.color));
}

// A texel of a parameter's map, which repeats.
fn texel(parameter: u32, x: i32, y: i32) -> vec4f {
    let size = vec2i(groom.parameters[parameter].size);
    let column = ((x % size.x) + size.x) % size.x;
    let row = ((y % size.y) + size.y) % size.y;
    return unpack_half4(maps_and_tables[groom.parameters[parameter].texel_base + u32(row * size.x + column)]);
}

// Bilinear lookup in a map that repeats; v = 0 is the lower edge.
fn bilinear(parameter: u32, uv: vec2f) -> vec4f {
    let size = vec2f(groom.parameters[parameter].size);
    let p = vec2f(fract(uv.x), 1.0 - fract(uv.y)) * size - 0.5;
    let base = floor(p);
    let f = p - base;
    let x = i32(base.x);
    let y = i32(base.y);
    return mix_bilinear(texel(parameter, x, y), texel(parameter, x + 1, y),
        texel(parameter, x, y + 1), texel(parameter, x + 1, y + 1), f);
}

// For skins without uv: three planar lookups, one repeat per 10 cm, weighted by the normal.
// [Geiss2007]
fn triplanar(parameter: u32, position: vec3f, normal: vec3f) -> vec4f {
    let n2 = normal * normal;
    let w = n2 * n2 / dot(n2, n2);
    let p = position / 10.0;
    return w.x * bilinear(parameter, p.yz) + w.y * bilinear(parameter, p.xz) + w.z * bilinear(parameter, p.xy);
}

// Factor on a parameter's constant at a point of the skin.
fn parameter_texel(parameter: u32, at: SkinPoint) -> vec4f {
    switch groom.parameters[parameter].source {
        case 1u: { return at.color; }
        case 2u: { return bilinear(parameter, at.uv); }
        case 3u: { return triplanar(parameter, at.position - groom.origin, at.normal); }
        default: { return vec4f(1.0); }
    }
}

// A scalar parameter at a point of the skin.
fn scalar(parameter: u32, at: SkinPoint) -> f32 {
    let p = groom.parameters[parameter].value.x;
    return p * parameter_texel(parameter, at)[groom.parameters[parameter].channel] + groom.parameters[parameter].offset;
}

// A colour parameter at a point of the skin, linear RGB.
fn color(parameter: u32, at: SkinPoint) -> vec3f {
    return groom.parameters[parameter].value.rgb * parameter_texel(parameter, at).rgb;
}
