// Step 4: the skin, and which objects are seen. The raster stage writes only which triangle of both
// is nearest at each sample; `shade` turns that of the skin into base records, lit from the
// lattice's columns. [Andersen2016] table 1
// In: `shell_vertices`, `prisms`, `base_light` (radiance at the columns). Out: `base_records`, one
// per sample (shared/base): depth in cm, linear RGB radiance, normal.

@group(0) @binding(1) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(2) var<storage, read> prisms: array<Prism>;
@group(0) @binding(3) var<uniform> fur: FurParameters;
@group(0) @binding(4) var<storage, read> base_light: array<vec2u>;
@group(0) @binding(5) var triangle_ids: texture_2d<u32>;
@group(0) @binding(6) var<storage, read_write> base_records: array<vec4u>;
@group(0) @binding(7) var<storage, read> columns: array<Column>;
// With FEATURES, the skin's albedo (shared/record) waits in the sample for the resolve pass.
@group(0) @binding(8) var<storage, read_write> samples: array<vec4u>;

#import shared/frame
#import shared/index
#import shared/undercoat_types
#import shared/shell
#import shared/lattice
#import shared/skin
#import shared/base
#import shared/column
#import shared/record
#import shared/film_sample

struct Varying {
    @builtin(position) clip: vec4f,
    @interpolate(flat) @location(0) triangle: u32,
}

@vertex
fn vertex(@builtin(vertex_index) i: u32) -> Varying {
    let triangle = i / 3u;
    let v = prisms[triangle].vertices[i % 3u];
    return Varying(clip_from_world(shell_vertices[v].position), triangle + 1u);
}

@fragment
fn fragment(in: Varying) -> @location(0) u32 {
    return in.triangle;
}

@compute @workgroup_size(64)
fn shade(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= tile_samples() {
        return;
    }
    let xy = tile_xy(i);
    let seen = textureLoad(triangle_ids, vec2i(xy), 0).x;
    if seen == 0u {
        base_records[i] = vec4u(bitcast<u32>(NO_BASE), 0u, 0u, 0u);
        return;
    }
    let prism = seen - 1u;
    if prisms[prism].object != 0u {
        return; // written by `objects`
    }
    var place: Place;
    enter_prism(&place, prism);
    let p0 = place.p0;
    let e1 = place.e1;
    let e2 = place.e2;
    let n = cross(e1, e2);
    let ray = sample_ray(xy);
    let along = dot(ray, n);
    let z = dot(p0 - frame.eye, n) / away_from_zero(along, 1e-20);
    let a = frame.eye + z * ray - p0;
    let lambda = barycentric_at(a, e1, e2, n, 1.0 / dot(n, n));
    place.lambda = lambda;
    let cell = lattice_cell(&place);
    var radiance = vec3f(0.0);
    for (var k = 0u; k < 3u; k++) {
        radiance += cell.weights[k] * unpack_half4(base_light[cell.columns[k]]).xyz;
    }
    radiance *= side_factor(along < 0.0);
    base_records[i] = pack_base(z, radiance, skin_normal(place.vertices, lambda));
    if FEATURES {
        var albedo = vec3f(0.0);
        for (var k = 0u; k < 3u; k++) {
            albedo += cell.weights[k] * unpack_albedo(columns[cell.columns[k]].color_base);
        }
        let at = sample_vector(i) + 2u;
        samples[at].x = pack_albedo(albedo);
        samples[at].y = 0u;
    }
}
