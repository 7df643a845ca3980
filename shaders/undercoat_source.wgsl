// Step 2: the light that the march and the skin look up: optical depths towards the two key lights,
// and one radiance towards the camera that sums all other lights and multiple scattering.
// In: `tau`, `columns`, `field_table`, `sent_table`, `response_table`. Out: `node_light`, one entry
// per node of the lattice; `base_light`, linear RGB radiance of the skin at each column; with
// multiple scattering by transport, the scattered radiance that falls on guard hairs, in `tau`.

@group(0) @binding(1) var<uniform> fur: FurParameters;
@group(0) @binding(2) var<uniform> lights: Lights;
@group(0) @binding(3) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(4) var<storage, read> prisms: array<Prism>;
@group(0) @binding(5) var<storage, read> columns: array<Column>;
@group(0) @binding(6) var<storage, read_write> tau: array<u32>;
@group(0) @binding(7) var<storage, read_write> node_light: array<vec4u>;
@group(0) @binding(8) var<storage, read_write> base_light: array<vec2u>; // three halves
@group(0) @binding(9) var<uniform> undercoat_fibre: Fibre;
@group(0) @binding(10) var table_sampler: sampler;
@group(0) @binding(11) var field_table: texture_2d_array<f32>;
@group(0) @binding(12) var sent_table: texture_2d_array<f32>;
@group(0) @binding(13) var response_table: texture_2d_array<f32>;

#import shared/constants
#import shared/frame
#import shared/index
#import shared/octahedral
#import shared/undercoat
#import shared/shell
#import shared/column
#import shared/column_place
#import shared/lights
#import shared/skin
#import shared/tau
#import shared/transmittance
#import shared/halves
#import shared/record
#import shared/source_table
#import shared/fibre
#import shared/undercoat_fibre
#import shared/transport
#import shared/dual

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let node = linear_index(id, groups);
    if node >= node_count() {
        return;
    }
    let column = column_of_node(node);
    let level = level_of_node(node);
    var place: Place;
    let x = enter_node(&place, column, level);
    let t = min(place.t, 1.0);
    let normal = skin_normal(place.vertices, place.lambda);
    let tangent = mean_tangent(normal, t);
    let view = to_eye(x);
    let albedo = mix(unpack_albedo(columns[column].color_root), unpack_albedo(columns[column].color_tip), t);
    // Light that leaves the undercoat has been both deep in it and near its top.
    let mean_albedo = mean_color(unpack_albedo(columns[column].color_root), unpack_albedo(columns[column].color_tip));
    var ambient = vec3f(0.0);
    var scattered = vec3f(0.0);   // multiple scattering towards the camera
    var key_tau = vec2f(0.0);
    var field = mat3x4f();        // scattered radiance in four zones
    var above = vec3f(0.0);       // radiance that falls on guard hairs
    var below = vec3f(0.0);
    for (var j = 0u; j < fur.lights.count; j++) {
        let depth = node_tau(node, j);
        let light = lights.lights[j];
        if light.undercoat == 1u && MULTIPLE == MULTIPLE_DUAL {
            scattered += light.irradiance * dual_scatter(ROW_DUAL_UNDERCOAT, albedo, tangent, light.direction, view, depth);
        }
        if light.undercoat == 1u && MULTIPLE == MULTIPLE_TRANSPORT {
            let sent = sent_radiance(mean_albedo, depth, dot(normal, light.direction), dot(normal, view));
            scattered += light.irradiance * sent[0];
            above += light.irradiance * sent[1];
            below += light.irradiance * sent[2];
            let of_light = scattered_field(mean_albedo, depth, dot(normal, light.direction));
            field += mat3x4f(light.irradiance.r * of_light[0], light.irradiance.g * of_light[1],
                light.irradiance.b * of_light[2]);
        }
        if j == fur.lights.key_lights.x && fur.lights.keys > 0u {
            key_tau.x = depth;
        } else if j == fur.lights.key_lights.y && fur.lights.keys > 1u {
            key_tau.y = depth;
        } else if light.undercoat == 1u {
            ambient += light.irradiance * light_through(depth, albedo)
                * scatter_undercoat(tangent, light.direction, view, albedo);
        }
    }
    if MULTIPLE == MULTIPLE_TRANSPORT {
        let first = scattered_word(node);
        let packed = pack_half3x2(above, below);
        tau[first] = packed.x;
        tau[first + 1u] = packed.y;
        tau[first + 2u] = packed.z;
    }
    ambient += scattered / max(undercoat_factor(albedo), vec3f(1e-3));
    let log_ambient = log2(max(ambient, vec3f(1e-7)));
    node_light[node] = vec4u(pack_half4(vec4f(log_ambient, columns[column].density)), pack2x16float(key_tau),
        pack_albedo(albedo));
    if level == 0u {
        var radiance = vec3f(0.0);
        for (var j = 0u; j < fur.lights.count; j++) {
            let facing = max(0.0, dot(normal, lights.lights[j].direction));
            radiance += lights.lights[j].irradiance * facing * light_through(node_tau(node, j), albedo);
        }
        radiance += field_irradiance(field);
        radiance *= unpack_albedo(columns[column].color_base) * FRAC_1_PI;
        base_light[column] = pack_half4(vec4f(radiance, 0.0));
    }
}
