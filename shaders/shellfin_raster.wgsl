// Shells and fins: draws the skin, fins at the silhouette, and textured shells from the skin
// outwards; `to_samples` turns the image into film samples. Colours are premultiplied linear RGB.
// In: baked textures, `row_positions` (cm) and `row_lights` of shellfin_rows. Out: the colour and
// depth targets; `samples`.
// [Lengyel2001] sec. 2.3, [Tariq2007]

struct FurCorner {
    vertex: u32,
    patch_index: u32, // its outline masks the texture where patches overlap
    uv: vec2f,       // on the patch, cm
    skin_uv: vec2f,
}

struct FinEdge {
    a: u32,
    b: u32,
    opposite: vec2u, // third vertices of the faces at the edge; the second is NONE at a border
}

@group(0) @binding(1) var<uniform> shellfin: Shellfin;
@group(0) @binding(2) var<uniform> groom: Groom;
@group(0) @binding(3) var<storage, read> maps_and_tables: array<vec2u>;
@group(0) @binding(4) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(5) var<storage, read> base_light: array<vec2u>;
@group(0) @binding(6) var<storage, read> fur_corners: array<FurCorner>;
@group(0) @binding(7) var<storage, read> fin_edges: array<FinEdge>;
@group(0) @binding(8) var<storage, read> shell_rows: array<ShellRow>;
@group(0) @binding(9) var<storage, read> row_positions: array<vec4f>;
@group(0) @binding(10) var<storage, read> row_lights: array<vec4u>;
@group(0) @binding(11) var layers: texture_2d_array<f32>;
@group(0) @binding(12) var guard_layers: texture_2d_array<f32>;
@group(0) @binding(13) var fin: texture_2d_array<f32>; // all hairs, and the guard hairs' part
@group(0) @binding(14) var repeating: sampler;
@group(0) @binding(15) var upright: sampler; // repeats along u only
@group(0) @binding(16) var color_target: texture_2d<f32>;
@group(0) @binding(17) var depth_target: texture_depth_2d;
@group(0) @binding(18) var<storage, read_write> samples: array<vec4u>;
@group(0) @binding(19) var<storage, read> vertex_uv: array<vec2f>;
@group(0) @binding(20) var<storage, read> outlines: array<vec2f>; // OUTLINE points per patch, cm

#import shared/constants
#import shared/frame
#import shared/index
#import shared/random
#import shared/shell_types
#import shared/groom
#import shared/base
#import shared/film_sample
#import shared/shellfin_types

// Features that the scene does not use are compiled out.
override GUARD: bool = true;  // guard hairs have separate layers
override DETAIL: bool = true; // rows change from one level of detail to the next
override SHADOW: bool = true; // shadow between hairs
override OUTLINE: u32 = 0u;    // points of a patch's outline, 0 where patches do not overlap
override MAPPED: bool = true; // colour or length come from an image or from vertex colours

// Coverage below which a fragment is discarded and writes no depth.
const LEAST_COVERAGE: f32 = 0.002;

struct SkinVarying {
    @builtin(position) clip: vec4f,
    @location(0) light: vec3f,
}

@vertex
fn skin_vertex(@builtin(vertex_index) i: u32) -> SkinVarying {
    let v = fur_corners[i].vertex;
    return SkinVarying(clip_from_world(shell_vertices[v].position), unpack_half4(base_light[v]).xyz);
}

@fragment
fn skin_fragment(in: SkinVarying, @builtin(front_facing) front: bool) -> @location(0) vec4f {
    return vec4f(in.light * side_factor(front), 1.0);
}

struct ShellVarying {
    @builtin(position) clip: vec4f,
    @location(0) uv: vec2f,        // repeats
    @location(1) position: vec3f,
    @location(2) normal: vec3f,
    @location(3) tangent: vec3f,
    @location(4) undercoat: vec3f,
    @location(5) guard: vec3f,
    @location(6) skin_uv: vec2f,
    @location(7) color: vec4f,
    @location(8) lean: vec3f,      // direction of hairs other than guard hairs
    @location(9) @interpolate(flat) row: u32,
    @location(10) @interpolate(flat) patch_index: u32,
    @location(11) length: f32,     // 0 where a part is bare
}

struct Lit {
    undercoat: vec3f,
    guard: vec3f,
}

// Unpacks the light of an entry of `row_lights`.
fn light_of(word: vec4u) -> Lit {
    let colors = unpack_half3x2(word.xyz);
    return Lit(colors[0], colors[1]);
}

@vertex
fn shell_vertex(@builtin(vertex_index) i: u32, @builtin(instance_index) row: u32) -> ShellVarying {
    let corner = fur_corners[shellfin.first_corner + i];
    let at = row * shellfin.vertices + corner.vertex;
    let p = row_positions[at];
    let lit = light_of(row_lights[at]);
    let skin = shell_vertices[corner.vertex];
    let tangent = unpack_direction(bitcast<u32>(p.w));
    let lean = unpack_direction(row_lights[at].w);
    var length = 1.0;
    if COATS > 1u {
        length = scalar(SHELL_LENGTH, point_of_vertex(skin, corner.skin_uv, corner.vertex));
    }
    return ShellVarying(clip_from_world(p.xyz), corner.uv / shellfin.torus, p.xyz, skin.normal, tangent,
        lit.undercoat, lit.guard, corner.skin_uv, unpack4x8unorm(skin.color), lean, row, corner.patch_index,
        length);
}

// Lit colour of a texel `whole`, of which `guard` is guard hair.
fn lit_color(whole: vec4f, guard: vec4f, lit: Lit) -> vec4f {
    return vec4f(max(whole.rgb - guard.rgb, vec3f(0.0)) * lit.undercoat + guard.rgb * lit.guard, whole.a);
}

// Lit colour for a path length through the layer `slant` times that of the texture. The mean
// transmittance of the layer is raised to that power, not that of the texel: a shorter path scales
// the coverage evenly, a longer one adds fog of the layer's mean colour.
fn slanted_color(row: ShellRow, color: vec4f, slant: f32, lit: Lit) -> vec4f {
    let mean_through = 1.0 - min(row.coverage, 0.9999);
    if slant <= 1.0 {
        return color * ((1.0 - pow(mean_through, slant)) / max(row.coverage, 1e-6));
    }
    let more = (1.0 - color.a) * (1.0 - pow(mean_through, slant - 1.0));
    let fog = mix(row.undercoat * lit.undercoat, row.guard * lit.guard, row.share);
    return color + more * vec4f(fog, 1.0);
}

// The fine layer blended with the coarser one; a row that the coarser level lacks fades out.
// [Lengyel2001] sec. 2.4
fn layer_texel(texture: texture_2d_array<f32>, row: ShellRow, uv: vec2f) -> vec4f {
    let fine = textureSample(texture, repeating, uv, row.fine);
    if !DETAIL {
        return fine;
    }
    let coarse = textureSample(texture, repeating, uv, select(row.coarse, row.fine, row.coarse == NONE));
    return mix(fine, select(coarse, vec4f(0.0), row.coarse == NONE), row.blend);
}

// Opacity of the shadow between hairs: where the texture covers more at a small offset towards the
// light, the difference is composited as black under the layer. [Xbdev]
// DEVIATION: the offset is towards the light instead of along the view-space normal, and coverages
// are compared instead of grey levels.
fn shadow(in: ShellVarying, n: vec3f, layer: u32) -> f32 {
    // Texture coordinates as a function of position, from screen-space derivatives.
    let dx = dpdx(in.position);
    let dy = dpdy(in.position);
    let toward = shellfin.shadow_direction - n * dot(n, shellfin.shadow_direction);
    let area = dot(cross(dx, dy), n);
    let steps = vec2f(dot(cross(toward, dy), n), dot(cross(dx, toward), n)) / away_from_zero(area, 1e-12);
    let shift = dpdx(in.uv) * steps.x + dpdy(in.uv) * steps.y;
    let ahead = in.uv + shift / max(length(shift), 1e-6) * shellfin.shadow_offset;
    let more = textureSampleLevel(layers, repeating, ahead, layer, 0.0).a
        - textureSampleLevel(layers, repeating, in.uv, layer, 0.0).a;
    return shellfin.shadow_strength * clamp(more, 0.0, 1.0);
}

// Mean sine of the angle between a view direction and hairs whose directions spread about the
// tangent with `variance` per axis.
fn spread_sine(tangent: vec3f, view: vec3f, variance: f32) -> f32 {
    let c = dot(tangent, view);
    return sqrt(max(0.0, 1.0 - mix(c * c, 1.0, variance) / (1.0 + 2.0 * variance)));
}

// Whether a point of a patch (cm) lies within its outline, a polygon that is star-shaped around the
// origin, with corners at equal angles. [Praun2000]
fn in_outline(p: vec2f, patch_index: u32) -> bool {
    let points = max(OUTLINE, 1u);
    let turn = atan2(p.y, p.x) / TAU;
    let k = min(u32(fract(turn) * f32(points)), points - 1u);
    let a = outlines[patch_index * points + k];
    let b = outlines[patch_index * points + (k + 1u) % points];
    let ab = b - a;
    let ap = p - a;
    return ab.x * ap.y - ab.y * ap.x >= 0.0;
}

@fragment
fn shell_fragment(in: ShellVarying) -> @location(0) vec4f {
    let row = shell_rows[in.row];
    let whole = layer_texel(layers, row, in.uv);
    var guard = vec4f(0.0);
    if GUARD {
        guard = layer_texel(guard_layers, row, in.uv);
    }
    let n = normalize(in.normal);
    var tint = vec3f(1.0);
    var bald = in.length <= 0.0;
    if MAPPED {
        // Parts have no values of their own but the length of bare skin, which is interpolated.
        let at = SkinPoint(in.position, n, in.skin_uv, in.color, vec3u(0u), vec3f(0.0));
        tint = coat_color(0u, SHELL_COLOR, at);
        bald = bald || coat_scalar(0u, SHELL_LENGTH, at) <= 0.0;
    }
    let lit = Lit(in.undercoat, in.guard);
    var out = lit_color(whole, guard, lit);
    var edge = 1.0;
    if shellfin.slanted == 1u {
        let view = to_eye(in.position);
        let facing = abs(dot(n, view));
        let undercoat = spread_sine(normalize(in.lean), view, row.jitter);
        let guard_hair = spread_sine(normalize(in.tangent), view, shellfin.spread * shellfin.spread);
        let slant = mix(undercoat, guard_hair, row.share) / max(facing, 0.08);
        // Near the silhouette a textured shell is seen edge-on, as a line; fins replace it there.
        edge = mix(1.0, smoothstep(0.0, 0.35, facing), shellfin.edge_fade);
        out = slanted_color(row, out, slant, lit) * edge;
    }
    out = vec4f(out.rgb * tint, out.a);
    if SHADOW {
        out.a += (1.0 - out.a) * edge * shadow(in, n, row.fine);
    }
    if OUTLINE > 0u && !in_outline(in.uv * shellfin.torus, in.patch_index) {
        discard;
    }
    if out.a < LEAST_COVERAGE || bald {
        discard;
    }
    return out;
}

struct FinVarying {
    @builtin(position) clip: vec4f,
    @location(0) uv: vec2f,
    @location(1) undercoat: vec3f,
    @location(2) guard: vec3f,
    @location(3) tint: vec3f,
    @location(4) fade: f32,
}

// Opacity of a fin by its angle to the view direction, 0..1.
fn fin_fade(edge: FinEdge) -> f32 {
    let a = shell_vertices[edge.a].position;
    let b = shell_vertices[edge.b].position;
    let view = to_eye(0.5 * (a + b));
    let n1 = normalize(cross(b - a, shell_vertices[edge.opposite.x].position - a));
    var n2 = n1;
    if edge.opposite.y != NONE {
        n2 = normalize(cross(shell_vertices[edge.opposite.y].position - a, b - a));
    }
    // [Lengyel2001] sec. 2.3
    // DEVIATION: uses the vertex normals, along which the fur stands, instead of the normals of the
    // two faces: otherwise every dent of a scanned skin would raise fins.
    let across = normalize(cross(normalize(b - a), shell_vertices[edge.a].normal + shell_vertices[edge.b].normal));
    let cosine = max(0.0, 2.0 * abs(dot(across, view)) - 1.0);
    if shellfin.fade == 0u {
        return cosine;
    }
    // On the silhouette or near it; a border always counts. [Tariq2007]
    let c1 = dot(n1, view);
    let c2 = dot(n2, view);
    let nearest = min(abs(c1), abs(c2));
    let on = c1 * c2 < 0.0 || edge.opposite.y == NONE;
    if shellfin.fade == 1u {
        return select(0.0, 1.0, on || nearest < shellfin.fin_threshold);
    }
    return select(clamp(2.0 - 2.0 * nearest / max(shellfin.fin_threshold, 1e-4), 0.0, 1.0), 1.0, on);
}

@vertex
fn fin_vertex(@builtin(vertex_index) i: u32, @builtin(instance_index) edge_index: u32) -> FinVarying {
    let edge = fin_edges[edge_index];
    let fade = fin_fade(edge);
    if fade <= 0.0 {
        return FinVarying(vec4f(0.0, 0.0, 0.0, 1.0), vec2f(0.0), vec3f(0.0), vec3f(0.0), vec3f(0.0), 0.0);
    }
    // Two triangles between each pair of rows.
    let corner = i % 6u;
    let upper = corner == 2u || corner == 4u || corner == 5u;
    let right = corner == 1u || corner == 2u || corner == 4u;
    let row = shellfin.shells + i / 6u + select(0u, 1u, upper);
    let v = select(edge.a, edge.b, right);
    let at = row * shellfin.vertices + v;
    let skin = shell_vertices[v];
    let lit = light_of(row_lights[at]);
    let width = distance(shell_vertices[edge.a].position, shell_vertices[edge.b].position);
    let seed = hash2(edge.a, edge.b);
    let u = random(seed, 0u) + select(0.0, width / shellfin.fin_length, right);
    var tint = vec3f(1.0);
    if MAPPED {
        tint = coat_color(0u, SHELL_COLOR, point_of_vertex(skin, vertex_uv[v], v));
    }
    return FinVarying(clip_from_world(row_positions[at].xyz), vec2f(u, shell_rows[row].height), lit.undercoat,
        lit.guard, tint, fade);
}

@fragment
fn fin_fragment(in: FinVarying) -> @location(0) vec4f {
    let whole = textureSample(fin, upright, in.uv, 0);
    var guard = vec4f(0.0);
    if GUARD {
        guard = textureSample(fin, upright, in.uv, 1);
    }
    let lit = lit_color(whole, guard, Lit(in.undercoat, in.guard));
    let out = vec4f(lit.rgb * in.tint, lit.a) * in.fade;
    if out.a < LEAST_COVERAGE {
        discard;
    }
    return out;
}

// The image as film samples. All fur counts as undercoat: once blended, the layers cannot be told
// apart.
@compute @workgroup_size(64)
fn to_samples(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= tile_samples() {
        return;
    }
    let xy = vec2i(tile_xy(i));
    let c = textureLoad(color_target, xy, 0);
    let d = textureLoad(depth_target, xy, 0);
    let z = select(NO_BASE, frame.near / max(d, 1e-12), d > 0.0);
    let packed = pack_film_sample(FilmSample(vec3f(0.0), c.rgb, vec3f(0.0), 1.0 - c.a, z, 0u, 0u));
    let at = sample_vector(i);
    samples[at] = packed[0];
    samples[at + 1u] = packed[1];
}
