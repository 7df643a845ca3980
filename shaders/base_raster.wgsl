// Step 4: the skin. The raster stage only writes which triangle is nearest; `shade` makes the base fragments of it.

@group(0) @binding(1) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(2) var<storage, read> prisms: array<Prism>;
@group(0) @binding(3) var<uniform> fur: FurParameters;
@group(0) @binding(4) var<storage, read> base_light: array<vec2u>;
@group(0) @binding(5) var triangle_ids: texture_2d<u32>;
@group(0) @binding(6) var<storage, read_write> base_records: array<vec4u>;

#import shared/frame
#import shared/index
#import shared/undercoat_types
#import shared/shell
#import shared/lattice
#import shared/octahedral
#import shared/base

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
    if i >= frame.tile_size.x * frame.tile_size.y {
        return;
    }
    let xy = vec2u(i % frame.tile_size.x, i / frame.tile_size.x);
    let seen = textureLoad(triangle_ids, vec2i(xy), 0).x;
    if seen == 0u {
        base_records[i] = vec4u(bitcast<u32>(NO_BASE), 0u, 0u, 0u);
        return;
    }
    let prism = seen - 1u;
    var place: Place;
    enter_prism(&place, prism);
    let p0 = place.p0;
    let e1 = place.e1;
    let e2 = place.e2;
    let v = place.vertices;
    let n = cross(e1, e2);
    let ray = sample_ray(xy);
    let along = dot(ray, n);
    let z = dot(p0 - frame.eye, n) / select(along, 1e-20, abs(along) < 1e-20);
    let a = frame.eye + z * ray - p0;
    let inverse = 1.0 / dot(n, n);
    let l1 = dot(cross(a, e2), n) * inverse;
    let l2 = dot(cross(e1, a), n) * inverse;
    let lambda = vec3f(1.0 - l1 - l2, l1, l2);
    place.lambda = lambda;
    let cell = lattice_cell(&place);
    var radiance = vec3f(0.0);
    for (var k = 0u; k < 3u; k++) {
        let word = base_light[cell.columns[k]];
        radiance += cell.weights[k] * vec3f(unpack2x16float(word.x), unpack2x16float(word.y).x);
    }
    // The inner side of an open skin shows itself unlit.
    radiance *= select(0.15, 1.0, along < 0.0);
    let normal = normalize(lambda.x * shell_vertices[v.x].normal + lambda.y * shell_vertices[v.y].normal + lambda.z * shell_vertices[v.z].normal);
    base_records[i] = vec4u(bitcast<u32>(z), pack2x16float(radiance.rg), pack2x16float(vec2f(radiance.b, 0.0)),
        pack2x16snorm(octahedral_encode(normal)));
}
