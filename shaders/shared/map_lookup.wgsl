// Parameters that maps may vary, read at a point of a surface.
// Needs: maps_and_tables (array<vec2u>, four halves per texel).

#import shared/arithmetic
#import shared/groom_types
#import shared/halves

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

// Factor on a parameter's constant at a point of a surface with the given vertex colour. The
// position is that before the mesh was moved to its place.
fn map_value(p: Parameter, position: vec3f, normal: vec3f, uv: vec2f, color: vec4f) -> vec4f {
    switch p.source {
        case 1u: { return color; }
        case 2u: { return bilinear(p, uv); }
        case 3u: { return triplanar(p, position, normal); }
        default: { return vec4f(1.0); }
    }
}
