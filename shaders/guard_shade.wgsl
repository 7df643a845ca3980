// Step 3: shading of the guard hairs, once at each strand vertex for all lights. Each strand is
// followed through the prism shell to look up the optical depths towards each light and towards the
// camera in the lattice.
// In: `roots`, `strand_vertices` (cm), `tau`, `response_table`, groom and lights. Out: `shades`,
// linear RGB radiance towards the camera.

@group(0) @binding(1) var<uniform> strand_batch: StrandBatch;
@group(0) @binding(2) var<uniform> fur: FurParameters;
@group(0) @binding(3) var<uniform> groom: Groom;
@group(0) @binding(4) var<uniform> lights: Lights;
@group(0) @binding(5) var<uniform> guard_fibre: Fibre;
@group(0) @binding(6) var<storage, read> maps_and_tables: array<vec2u>;
@group(0) @binding(7) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(8) var<storage, read> prisms: array<Prism>;
@group(0) @binding(9) var<storage, read> corner_uv: array<vec2f>;
@group(0) @binding(10) var<storage, read> roots: array<Root>;
@group(0) @binding(11) var<storage, read> strand_vertices: array<vec4f>;
@group(0) @binding(12) var<storage, read> tau: array<u32>;
// Four halves: radiance; 1 if hidden. With FEATURES, albedo and tangent (shared/shade).
@group(0) @binding(13) var<storage, read_write> shades: array<vec2u>;
@group(0) @binding(14) var table_sampler: sampler;
@group(0) @binding(15) var field_table: texture_2d_array<f32>;
@group(0) @binding(16) var sent_table: texture_2d_array<f32>;
@group(0) @binding(17) var response_table: texture_2d_array<f32>;

#import shared/frame
#import shared/index
#import shared/random
#import shared/undercoat_types
#import shared/shell
#import shared/lattice
#import shared/tau
#import shared/transmittance
#import shared/halves
#import shared/lights
#import shared/groom
#import shared/roots
#import shared/strands
#import shared/map_table
#import shared/fibre
#import shared/guard_fibre
#import shared/transport
#import shared/dual
#import shared/shade
#import shared/record
#import shared/octahedral

// Optical depth towards the camera beyond which a vertex counts as hidden and is not shaded.
const HIDDEN_TAU: f32 = 14.0;

// Least optical depth towards the camera at the cell's corners.
fn eye_tau(cell: LatticeCell) -> f32 {
    var least = TAU_BLOCKED;
    for (var k = 0u; k < 3u; k++) {
        let node = node_index(cell.columns[k], cell.level);
        least = min(least, min(node_tau(node, fur.lights.count), node_tau(node + 1u, fur.lights.count)));
    }
    return least;
}

// Weight of the tip's colour at s (0 root, 1 tip) in the transition from root to tip.
fn tip_share(transition: vec2f, s: f32) -> f32 {
    let half_width = 0.5 * transition.y;
    return smoothstep(transition.x - half_width, transition.x + half_width + 1e-4, s);
}

// Mean scattered radiance from above and from below in a lattice cell.
fn scattered_light(cell: LatticeCell) -> array<vec3f, 2> {
    var sum = array<vec2f, 3>();
    for (var k = 0u; k < 3u; k++) {
        let low = scattered_word(node_index(cell.columns[k], cell.level));
        let high = low + fur.lattice.tau_stride;
        for (var word = 0u; word < 3u; word++) {
            sum[word] += cell.weights[k]
                * mix(unpack2x16float(tau[low + word]), unpack2x16float(tau[high + word]), cell.fraction);
        }
    }
    return array<vec3f, 2>(vec3f(sum[0], sum[1].x), vec3f(sum[1].y, sum[2]));
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= strand_batch.strands {
        return;
    }
    let root = roots[i];
    let at = skin_point(root.prism, root_lambda(root));
    let hairs = hairs_at(at);
    let tone = 1.0 + hairs.color_variation * (2.0 * random(root.seed, 6u) - 1.0);
    let color_root = color(GUARD_COLOR_ROOT, at) * tone;
    let color_tip = color(GUARD_COLOR_TIP, at) * tone;
    let glint_angle = radians(30.0 + 15.0 * random(root.seed, 7u));
    let first = i * (groom.segments + 1u);
    var place: Place;
    enter_prism(&place, root.prism);
    place.t = 0.0;
    place.lambda = root_lambda(root);
    let root_place = place;
    let inverse_height = 1.0 / max(length(extrusion(&place)), 1e-3);
    var inside = true;
    for (var k = 0u; k <= groom.segments; k++) {
        let x = strand_vertices[first + k].xyz;
        let tangent = strand_tangent(first, k, groom.segments);
        let view = to_eye(x);
        let s = f32(k) / f32(groom.segments);
        let albedo = clamp(mix(color_root, color_tip, tip_share(hairs.color_transition, s)), vec3f(0.0), vec3f(1.0));
        let word = shade_word(first + k);
        if FEATURES {
            shades[word + 1u] = vec2u(pack_albedo(albedo), pack_direction(tangent));
        }
        if inside {
            inside = locate(&place, x, tangent, 3u) == INSIDE;
        }
        if !inside {
            // Beyond the border of the skin, or where the shell folds: use the column above the
            // root, at the height of the vertex.
            place = root_place;
            place.t = max(0.0, dot(x - at.position, at.normal) * inverse_height);
        }
        let cell = lattice_cell(&place);
        if fur.undercoat.opacity_cut > 0.0 && inside && eye_tau(cell) > HIDDEN_TAU {
            shades[word] = pack_half4(vec4f(0.0, 0.0, 0.0, 1.0));
            continue;
        }
        var radiance = vec3f(0.0);
        for (var j = 0u; j < fur.lights.count; j++) {
            let depth = select(0.0, cell_tau(cell, j), groom.paper == 0u);
            let through = light_through(depth, albedo);
            if MULTIPLE == MULTIPLE_DUAL {
                radiance += lights.lights[j].irradiance
                    * dual_scatter(ROW_DUAL_GUARD, albedo, tangent, lights.lights[j].direction, view, depth);
            }
            radiance += lights.lights[j].irradiance * through
                * scatter_guard(tangent, lights.lights[j].direction, view, albedo, glint_angle);
        }
        if MULTIPLE == MULTIPLE_TRANSPORT {
            let scattered = scattered_light(cell);
            let normal = extrusion_direction(&place, place.lambda);
            radiance += guard_response(albedo, tangent, view, normal, scattered[0], scattered[1]);
        }
        if groom.paper == 1u {
            // Darkening that grows exponentially towards the skin. [Andersen2016] sec. 3.1
            radiance *= 1.0 - hairs.root_darkening.x * exp(-s / hairs.root_darkening.y);
        }
        shades[word] = pack_half4(vec4f(radiance, 0.0));
    }
}
