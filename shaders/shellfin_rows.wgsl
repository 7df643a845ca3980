// Shells and fins: position and light of the hair of each skin vertex at each row above the skin. A
// row is a textured shell or a row of a fin's vertices. Lengths, combing and forces are those of
// the frame.
// In: skin, `groom`, `tau` of the columns at the vertices, `shell_rows`. Out: `row_positions` (cm)
// and `row_lights` (linear RGB).
// [Lengyel2001] sec. 2.4, [Xbdev]

struct Brush {
    center: vec3f,    // cm
    radius: f32,      // cm
    direction: vec3f, // tangent of the lean, world
    padding: u32,
    tint: vec3f,      // factor on the light
    more_padding: u32,
}

struct LightingTable {
    values: array<vec4f, 256>, // 32 x 32, four per vector: u = T.L, v = T.H; [Banks1994]
}

@group(0) @binding(1) var<uniform> shellfin: Shellfin;
@group(0) @binding(2) var<uniform> fur: FurParameters;
@group(0) @binding(3) var<uniform> groom: Groom;
@group(0) @binding(4) var<uniform> lights: Lights;
@group(0) @binding(5) var<uniform> guard_fibre: Fibre;
@group(0) @binding(6) var<uniform> undercoat_fibre: Fibre;
@group(0) @binding(7) var<storage, read> maps_and_tables: array<vec2u>;
@group(0) @binding(8) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(9) var<storage, read> vertex_uv: array<vec2f>;
@group(0) @binding(10) var<storage, read> tau: array<u32>;
@group(0) @binding(11) var<storage, read> shell_rows: array<ShellRow>;
@group(0) @binding(12) var<storage, read> brushes: array<Brush>;
// xyz in cm; w: tangent, octahedral.
@group(0) @binding(13) var<storage, read_write> row_positions: array<vec4f>;
// Radiance of undercoat and guard hairs per unit of their colours, three halves each; the
// undercoat's tangent, octahedral.
@group(0) @binding(14) var<storage, read_write> row_lights: array<vec4u>;
// Last, because Mesa 22.3's software adapter writes past a table where a branch depends on the
// eighth uniform buffer.
@group(0) @binding(15) var<uniform> lighting_table: LightingTable;

#import shared/constants
#import shared/frame
#import shared/index
#import shared/octahedral
#import shared/undercoat
#import shared/shell_types
#import shared/lights
#import shared/tau
#import shared/transmittance
#import shared/groom
#import shared/map_table
#import shared/fibre
#import shared/undercoat_fibre
#import shared/guard_fibre
#import shared/strand_curve
#import shared/shellfin_types

// The hair of a vertex and what bends it.
struct HairRoot {
    at: SkinPoint,
    lean: vec3f,   // tangential; its length is the tangent of the angle
    height: f32,   // of the fur, cm above the skin at row height 1
    gravity: f32,
    tint: vec3f,   // factor on the light
}

fn root_of(v: u32) -> HairRoot {
    let vertex = shell_vertices[v];
    let at = point_of_vertex(vertex, vertex_uv[v], v);
    var lean = shellfin.comb;
    if shellfin.curved == 1u {
        // Projected below, together with the rest.
        lean += combed_lean(at, vec3f(0.0));
    }
    var tint = vec3f(1.0);
    for (var i = 0u; i < shellfin.brushes; i++) {
        let d = distance(at.position, brushes[i].center) / brushes[i].radius;
        let w = max(0.0, 1.0 - d * d);
        lean += w * w * brushes[i].direction;
        tint *= mix(vec3f(1.0), brushes[i].tint, w * w);
    }
    lean -= at.normal * dot(lean, at.normal);
    var height = shellfin.height * max(0.0, scalar(SHELL_LENGTH, at));
    if shellfin.curved == 1u {
        // Where the prism shell was lowered because it would fold over, so are the textured shells.
        height *= clamp(vertex.height / max(scalar(UNDERCOAT_HEIGHT, at), 1e-4), 0.0, 1.0);
    }
    return HairRoot(at, lean, height, hairs_at(at).gravity, tint);
}

// Position of the hair at row height s relative to its root, in units of the fur's height.
fn hair(root: HairRoot, s: f32) -> vec3f {
    let n = root.at.normal;
    var p = s * (n + root.lean);
    if shellfin.curved == 1u {
        // The groom's strand without its random parts (shaders/guard_strands.wgsl), scaled so that
        // its tip is as high as the fur. Heights grow linearly with s, as those of the texture's
        // layers do.
        let legs = leg_directions(n, root.lean, root.gravity);
        let polygon = control_polygon(n, legs[0] / 3.0, legs[1] / 3.0, legs[2] / 3.0);
        let b = bezier(polygon, s) / max(dot(polygon.p3, n), 0.25);
        p = b + n * (s - dot(b, n));
    }
    // Forces bend the tips most. [Xbdev]
    // DEVIATION: hairs keep their length; those of the tutorial stretch.
    let long = length(p);
    p += shellfin.bend * s * s * s;
    p *= long / max(length(p), 1e-4);
    return p + n * max(0.0, 0.1 * s - dot(p, n));
}

// Optical depth in column `v` at `height` (in shell heights) towards a light.
fn column_tau(v: u32, height: f32, light: u32) -> f32 {
    let level = level_at(height);
    return tau_between(node_index(v, level.lower), light, level.fraction);
}

fn table_texel(x: u32, y: u32) -> f32 {
    let i = 32u * y + x;
    return lighting_table.values[i / 4u][i % 4u];
}

// Bilinear; u and v from -1 to 1 at the centres of the outermost texels.
fn table(u: f32, v: f32) -> f32 {
    let p = clamp((vec2f(u, v) * 0.5 + 0.5) * 31.0, vec2f(0.0), vec2f(31.0));
    let i = min(vec2u(p), vec2u(30u));
    let f = p - vec2f(i);
    return mix(mix(table_texel(i.x, i.y), table_texel(i.x + 1u, i.y), f.x),
        mix(table_texel(i.x, i.y + 1u), table_texel(i.x + 1u, i.y + 1u), f.x), f.y);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= (shellfin.shells + shellfin.fin_rows) * shellfin.vertices {
        return;
    }
    let v = i % shellfin.vertices;
    let row = shell_rows[i / shellfin.vertices];
    let root = root_of(v);
    let n = root.at.normal;
    let offset = hair(root, row.height) * root.height;
    let x = root.at.position + offset;
    let tangent = normalize(hair(root, row.height + 0.02) - hair(root, max(row.height - 0.02, 0.0)));
    row_positions[i] = vec4f(x, bitcast<f32>(pack_direction(tangent)));

    let view = to_eye(x);
    var undercoat = vec3f(0.0);
    var guard = vec3f(0.0);
    let height = dot(offset, n) / max(shell_vertices[v].height, 1e-4);
    var lean = tangent;
    if shellfin.curved == 1u {
        lean = mean_tangent(n, min(height, 1.0));
    }
    if shellfin.lighting == 1u {
        for (var j = 0u; j < fur.lights.count; j++) {
            let l = lights.lights[j].direction;
            let value = table(dot(tangent, l), dot(tangent, normalize(l + view + n * 1e-4)));
            undercoat += lights.lights[j].irradiance * value;
        }
        undercoat *= row.shade;
        guard = undercoat;
    } else {
        let sides = sides_of(tangent);
        for (var j = 0u; j < fur.lights.count; j++) {
            let l = lights.lights[j].direction;
            let depth = column_tau(v, height, j);
            if lights.lights[j].undercoat == 1u {
                undercoat += lights.lights[j].irradiance * light_through(depth, row.undercoat)
                    * scatter_undercoat(lean, l, view, row.undercoat);
            }
            if shellfin.guard == 1u {
                // The hairs that a row represents lean slightly in all directions.
                let through = lights.lights[j].irradiance * light_through(depth, row.guard);
                for (var k = 0u; k < 4u; k++) {
                    let turn = FRAC_PI_4 + FRAC_PI_2 * f32(k);
                    let t = normalize(tangent - 1.25 * shellfin.spread * side_at(sides, turn));
                    guard += 0.25 * through * scatter_guard(t, l, view, row.guard, MEAN_GLINT);
                }
            }
        }
        guard /= max(row.guard, vec3f(1e-3));
        if UNDERCOAT_MODEL != MODEL_KAJIYA_KAY {
            undercoat /= max(row.undercoat, vec3f(1e-3));
        }
    }
    undercoat *= root.tint;
    guard *= root.tint;
    row_lights[i] = vec4u(pack_half3x2(undercoat, guard), pack_direction(lean));
}
