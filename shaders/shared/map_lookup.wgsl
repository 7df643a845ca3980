// Parameters that maps may vary, read at a point of a surface.
// Needs: maps_and_tables (array<vec2u>, four halves per texel).

#import shared/arithmetic
#import shared/groom_types
#import shared/halves

// A point of the skin where parameters are read.
struct SkinPoint {
    position: vec3f,
    normal: vec3f,
    uv: vec2f,
    color: vec3f,
}

// A texel of a parameter's map, which repeats.
fn texel(p: Parameter, x: i32, y: i32) -> vec4f {
    let size = vec2i(p.size);
    let column = ((x % size.x) + size.x) % size.x;
    let row = ((y % size.y) + size.y) % size.y;
    return unpack_half4(maps_and_tables[p.texel_base + u32(row * size.x + column)]);
}

// Bilinear lookup in a map that repeats; v = 0 is the lower edge.
fn bilinear(p: Parameter, uv: vec2f) -> vec4f {
    let size = vec2f(p.size);
    let at = vec2f(fract(uv.x), 1.0 - fract(uv.y)) * size - 0.5;
    let base = floor(at);
    let f = at - base;
    let x = i32(base.x);
    let y = i32(base.y);
    return mix_bilinear(texel(p, x, y), texel(p, x + 1, y),
        texel(p, x, y + 1), texel(p, x + 1, y + 1), f);
}

// For skins without uv: three planar lookups, one repeat per 10 cm, weighted by the normal.
// [Geiss2007]
fn triplanar(p: Parameter, position: vec3f, normal: vec3f) -> vec4f {
    let n2 = normal * normal;
    let w = n2 * n2 / dot(n2, n2);
    let at = position / 10.0;
    return w.x * bilinear(p, at.yz) + w.y * bilinear(p, at.xz) + w.z * bilinear(p, at.xy);
}

// Factor on a parameter's constant at a point of the skin.
fn parameter_texel(p: Parameter, at: SkinPoint) -> vec4f {
    switch p.source {
        case 1u: { return vec4f(at.color, 1.0); }
        case 2u: { return bilinear(p, at.uv); }
        case 3u: { return triplanar(p, at.position, at.normal); }
        default: { return vec4f(1.0); }
    }
}

// A colour at a point of a surface, linear RGB.
fn color_of(p: Parameter, at: SkinPoint) -> vec3f {
    return p.value.rgb * parameter_texel(p, at).rgb;
}
