// Step 4: objects. Where base_raster finds a triangle of an object, its base record is written
// here: depth, normal, and the light of every light source that neither skin nor objects block,
// attenuated by the fur.
// In: `triangle_ids`, triangles, `bvh_nodes`, `fur_cells`, `object_materials`, `maps_and_tables`,
// `lights`. Out: `base_records` of samples that see an object.

@group(0) @binding(1) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(2) var<storage, read> prisms: array<Prism>;
@group(0) @binding(3) var<storage, read> bvh_nodes: array<BvhNode>;
@group(0) @binding(4) var<storage, read> bvh_triangles: array<u32>;
@group(0) @binding(5) var<storage, read> object_materials: array<ObjectMaterial>;
@group(0) @binding(6) var<storage, read> maps_and_tables: array<vec2u>;
@group(0) @binding(7) var<storage, read> fur_cells: array<vec4u>;
@group(0) @binding(8) var<storage, read_write> base_records: array<vec4u>;
@group(0) @binding(9) var<uniform> fur: FurParameters;
@group(0) @binding(10) var<uniform> lights: Lights;
@group(0) @binding(11) var<uniform> fur_grid: FurGrid;
@group(0) @binding(12) var triangle_ids: texture_2d<u32>;

#import shared/frame
#import shared/arithmetic
#import shared/index
#import shared/random
#import shared/undercoat_types
#import shared/barycentric
#import shared/shell_types
#import shared/lights
#import shared/map_lookup
#import shared/material
#import shared/bvh
#import shared/fur_grid
#import shared/base

struct ObjectMaterial {
    color: Parameter,
    roughness: f32,
    metallic: f32,
    clearcoat: f32,
    clearcoat_roughness: f32,
    origin: vec3f,         // translation of the mesh, cm
    shadow_catcher: u32,
}

// Distance that keeps shadow rays off their triangle, relative to the size of the coordinates.
const OFFSET: f32 = 4e-6;
// Largest radiance that a base record holds.
const LARGEST: f32 = 6e4;

fn luminance(c: vec3f) -> f32 {
    return dot(c, vec3f(0.2126, 0.7152, 0.0722));
}

@compute @workgroup_size(64)
fn shade(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= tile_samples() {
        return;
    }
    let xy = tile_xy(i);
    let seen = textureLoad(triangle_ids, vec2i(xy), 0).x;
    if seen == 0u || prisms[seen - 1u].object == 0u {
        return;
    }
    let triangle = prisms[seen - 1u];
    let material = object_materials[triangle.object - 1u];
    let va = shell_vertices[triangle.vertices.x];
    let vb = shell_vertices[triangle.vertices.y];
    let vc = shell_vertices[triangle.vertices.z];
    let e1 = vb.position - va.position;
    let e2 = vc.position - va.position;
    let n = cross(e1, e2);
    let ray = sample_ray(xy);
    let z = dot(va.position - frame.eye, n) / away_from_zero(dot(ray, n), 1e-20);
    let lambda = barycentric_at(frame.eye + z * ray - va.position, e1, e2, n, 1.0 / max(dot(n, n), 1e-30));
    let x = va.position + lambda.y * e1 + lambda.z * e2;
    let smoothed = normalize(interpolate3(lambda, va.normal, vb.normal, vc.normal));
    let uv = interpolate2(lambda, bitcast<vec2f>(triangle.neighbours.xy),
        bitcast<vec2f>(vec2u(triangle.neighbours.z, triangle.subdivision)), bitcast<vec2f>(triangle.edges.xy));
    let tint = interpolate3(lambda, unpack4x8unorm(va.color).rgb, unpack4x8unorm(vb.color).rgb,
        unpack4x8unorm(vc.color).rgb);
    let color = material.color.value.rgb
        * map_value(material.color, x - material.origin, smoothed, uv, vec4f(tint, 1.0)).rgb;
    let surface = Material(clamp(color, vec3f(0.0), vec3f(1.0)), material.roughness, material.metallic,
        material.clearcoat, material.clearcoat_roughness);
    // Both sides are alike.
    let view = -normalize(ray);
    let outside = select(-1.0, 1.0, dot(n, view) > 0.0);
    let flat = normalize(n) * outside;
    let normal = smoothed * outside;
    let largest = max(abs(x.x), max(abs(x.y), abs(x.z)));
    let origin = x + flat * (OFFSET * (1.0 + largest));
    // Rays through the fur start anywhere within a cell, which hides the cells' walls.
    let film = vec2u(frame.tile_origin + vec2i(xy));
    let seed = hash2(frame.seed, hash2(film.x, film.y));
    let jitter = (random3(seed, 0u) - 0.5) * fur_grid.cell;

    var radiance = vec3f(0.0);
    var arriving = vec3f(0.0);
    var unshadowed = vec3f(0.0);
    for (var j = 0u; j < fur.lights.count; j++) {
        let l = lights.lights[j].direction;
        let cosine = dot(normal, l);
        if cosine <= 0.0 || dot(flat, l) <= 0.0 {
            continue;
        }
        let irradiance = lights.lights[j].irradiance * cosine;
        unshadowed += irradiance;
        if blocked(origin, l) {
            continue;
        }
        let lit = irradiance * exp(-fur_depth(x + jitter, l)); // [Max1995]
        arriving += lit;
        radiance += lit * scatter_material(surface, normal, view, l, lights.lights[j].spread);
    }
    if material.shadow_catcher == 1u {
        let share = luminance(arriving) / max(luminance(unshadowed), 1e-20);
        base_records[i] = pack_translucent_base(z, vec3f(0.0), select(1.0, share, luminance(unshadowed) > 0.0), normal);
    } else {
        base_records[i] = pack_base(z, min(radiance, vec3f(LARGEST)), normal);
    }
}
