// Groom parameters: a constant, the vertex colour or an image map, read at a point of the skin.
// Parts of the skin have values of their own, which go over into each other.
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
const PART_MASK: u32 = 16u;

const SOURCE_BELOW: u32 = 4u;
const NO_LANE: u32 = 0xffffffffu;

override COATS: u32 = 1u; // the scene's own and those of its parts

// A point of the skin where parameters are read.
struct SkinPoint {
    position: vec3f,
    normal: vec3f,
    uv: vec2f,
    color: vec4f,   // vertex colour and alpha
    rows: vec3u,    // coverage rows that are interpolated
    weights: vec3f, // their weights
}

// The point at vertex v of the skin.
fn point_of_vertex(vertex: ShellVertex, uv: vec2f, v: u32) -> SkinPoint {
    return SkinPoint(vertex.position, vertex.normal, uv, unpack4x8unorm(vertex.color),
        vec3u(groom.vertex_rows + v), vec3f(1.0, 0.0, 0.0));
}

// Factor on a parameter's constant at a point of the skin.
fn parameter_texel(coat: u32, parameter: u32, at: SkinPoint) -> vec4f {
    return map_value(groom.coats[coat].parameters[parameter], at.position - groom.origin, at.normal, at.uv, at.color);
}

// A scalar parameter of one coat at a point of the skin.
fn coat_scalar(coat: u32, parameter: u32, at: SkinPoint) -> f32 {
    let p = groom.coats[coat].parameters[parameter].value.x;
    return p * parameter_texel(coat, parameter, at)[groom.coats[coat].parameters[parameter].channel]
        + groom.coats[coat].parameters[parameter].offset;
}

// A colour parameter of one coat at a point of the skin, linear RGB.
fn coat_color(coat: u32, parameter: u32, at: SkinPoint) -> vec3f {
    return groom.coats[coat].parameters[parameter].value.rgb * parameter_texel(coat, parameter, at).rgb;
}

// Coverage of a lane in a row: 1 on the part's sections, falling by 1 over the width of its edge.
fn row_coverage(row: u32, lane: u32) -> f32 {
    let texel = groom.coverage_base + row * groom.coverage_texels + lane / 4u;
    return unpack_half4(maps_and_tables[texel])[lane % 4u];
}

// How much of the skin at a point belongs to a part rather than to what lies below it, 0..1. Values
// a little below 1 count as 1: interpolation rounds.
fn part_share(coat: u32, at: SkinPoint) -> f32 {
    var share = clamp(coat_scalar(coat, PART_MASK, at), 0.0, 1.0);
    let lane = groom.coats[coat].lane;
    if lane != NO_LANE {
        let corners = vec3f(row_coverage(at.rows.x, lane), row_coverage(at.rows.y, lane), row_coverage(at.rows.z, lane));
        share *= clamp(dot(at.weights, corners), 0.0, 1.0);
    }
    return min(1.001 * share, 1.0);
}

// Whether a coat has a value of its own for a parameter.
fn has_value(coat: u32, parameter: u32) -> bool {
    return groom.coats[coat].parameters[parameter].source != SOURCE_BELOW;
}

// The value of what lies below, with the share of a part's value.
fn over(below: f32, part: f32, share: f32) -> f32 {
    return select(below + share * (part - below), part, share >= 1.0);
}

fn over2(below: vec2f, part: vec2f, share: f32) -> vec2f {
    return select(below + share * (part - below), part, share >= 1.0);
}

fn over3(below: vec3f, part: vec3f, share: f32) -> vec3f {
    return select(below + share * (part - below), part, share >= 1.0);
}

// A scalar parameter at a point of the skin.
fn scalar(parameter: u32, at: SkinPoint) -> f32 {
    var value = coat_scalar(0u, parameter, at);
    for (var coat = 1u; coat < COATS; coat++) {
        if has_value(coat, parameter) {
            let share = part_share(coat, at);
            if share > 0.0 {
                value = over(value, coat_scalar(coat, parameter, at), share);
            }
        }
    }
    return value;
}

// A colour parameter at a point of the skin, linear RGB.
fn color(parameter: u32, at: SkinPoint) -> vec3f {
    var value = coat_color(0u, parameter, at);
    for (var coat = 1u; coat < COATS; coat++) {
        if has_value(coat, parameter) {
            let share = part_share(coat, at);
            if share > 0.0 {
                value = over3(value, coat_color(coat, parameter, at), share);
            }
        }
    }
    return value;
}

// Share of the hairs of a coat at a point: bare skin leaves the shape of hairs as it is.
fn hair_share(coat: u32, at: SkinPoint) -> f32 {
    return select(part_share(coat, at), 0.0, groom.coats[coat].bare == 1u);
}

// The guard hairs at a point of the skin.
fn hairs_at(at: SkinPoint) -> GuardHairs {
    var hairs = groom.coats[0].hairs;
    for (var coat = 1u; coat < COATS; coat++) {
        let share = hair_share(coat, at);
        if share > 0.0 {
            let part = groom.coats[coat].hairs;
            hairs.comb_direction = over3(hairs.comb_direction, part.comb_direction, share);
            hairs.widest = over(hairs.widest, part.widest, share);
            hairs.diameter = over3(hairs.diameter, part.diameter, share);
            hairs.spread = over(hairs.spread, part.spread, share);
            hairs.color_transition = over2(hairs.color_transition, part.color_transition, share);
            hairs.color_variation = over(hairs.color_variation, part.color_variation, share);
            hairs.length_variation = over(hairs.length_variation, part.length_variation, share);
            hairs.gravity = over(hairs.gravity, part.gravity, share);
            hairs.clump_density = over(hairs.clump_density, part.clump_density, share);
            hairs.curl_frequency = over(hairs.curl_frequency, part.curl_frequency, share);
            hairs.frizz_frequency = over(hairs.frizz_frequency, part.frizz_frequency, share);
            hairs.root_darkening = over2(hairs.root_darkening, part.root_darkening, share);
            hairs.opacity = over(hairs.opacity, part.opacity, share);
            hairs.tip_fade = over(hairs.tip_fade, part.tip_fade, share);
        }
    }
    return hairs;
}

// Lean by the comb of one coat at a point of the skin with normal n.
fn coat_lean(coat: u32, at: SkinPoint, n: vec3f) -> vec3f {
    let direction = groom.coats[coat].hairs.comb_direction;
    return (direction - n * dot(n, direction)) * coat_scalar(coat, GUARD_COMB, at);
}

// Lean by the comb at a point of the skin, its length the tangent of the angle; tangential to n.
fn combed_lean(at: SkinPoint, n: vec3f) -> vec3f {
    var lean = coat_lean(0u, at, n);
    for (var coat = 1u; coat < COATS; coat++) {
        let share = hair_share(coat, at);
        if share > 0.0 {
            lean = over3(lean, coat_lean(coat, at, n), share);
        }
    }
    return lean;
}
