// Step 4: objects. Where base_raster finds a triangle of an object, its base record is written
// here: depth, normal, and the light of every light source that neither skin nor objects block,
// attenuated by the fur.
// In: `triangle_ids`, triangles, `bvh_nodes`, `fur_cells`, `object_materials`, `maps_and_tables`,
// `lights`. Out: `base_records` of samples that see an object. Each dispatch adds a few lights to
// sums that wait in `samples`, because shadow rays of all lights may take more rounds of loops than
// Mesa's software adapter allows an invocation.
// DEVIATION: glossy objects reflect the lights alone, not fur, other objects or the sky between the
// lights; as on the skin, what these scatter onto an object is left out.

@group(0) @binding(1) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(2) var<storage, read> prisms: array<Prism>;
@group(0) @binding(3) var<storage, read> bvh_nodes: array<BvhNode>;
@group(0) @binding(4) var<storage, read> bvh_triangles: array<u32>;
@group(0) @binding(5) var<uniform> object_materials: ObjectMaterials;
@group(0) @binding(6) var<storage, read> maps_and_tables: array<vec2u>;
@group(0) @binding(7) var<storage, read> fur_cells: array<vec4u>;
@group(0) @binding(8) var<storage, read_write> base_records: array<vec4u>;
@group(0) @binding(9) var<uniform> fur: FurParameters;
@group(0) @binding(10) var<uniform> lights: Lights;
@group(0) @binding(11) var<uniform> fur_grid: FurGrid;
@group(0) @binding(12) var triangle_ids: texture_2d<u32>;
// Sums; with FEATURES, the object's albedo (shared/record) and number wait there for `resolve`.
@group(0) @binding(13) var<storage, read_write> samples: array<vec4u>;
@group(0) @binding(14) var<uniform> light_batch: LightBatch;

#import shared/frame
#import shared/arithmetic
#import shared/index
#import shared/angles
#import shared/constants
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
#import shared/record
#import shared/film_sample

struct ObjectMaterial {
    color: Parameter,
    roughness: f32,
    metallic: f32,
    clearcoat: f32,
    clearcoat_roughness: f32,
    origin: vec3f,         // translation of the mesh, cm
    shadow_catcher: u32,
}

struct ObjectMaterials {
    materials: array<ObjectMaterial, 256>,
}

// The lights of a dispatch; the last one writes the records.
struct LightBatch {
    first: u32,
    end: u32,
}

// Distance that keeps shadow rays off their triangle, relative to the size of the coordinates.
const OFFSET: f32 = 4e-6;
// Largest radiance that a base record holds.
const LARGEST: f32 = 6e4;

fn luminance(c: vec3f) -> f32 {
    return dot(c, vec3f(0.2126, 0.7152, 0.0722));
}

// A direction from the part of the sky that a light stands for, mirrored to above the surface.
fn within_light(l: vec3f, spread: f32, u: vec2f, up: vec3f) -> vec3f {
    if spread == 0.0 {
        return l;
    }
    let cosine = 1.0 - u.x * (1.0 - cos(2.0 * spread));
    let d = cosine * l + sqrt(max(1.0 - cosine * cosine, 0.0)) * side_at(sides_of(l), TAU * u.y);
    return d - 2.0 * min(dot(d, up), 0.0) * up;
}

// How far a point lies below the plane through a corner with its smoothed normal, along the normal.
fn below_corner(x: vec3f, corner: vec3f, normal: vec3f) -> vec3f {
    return -min(dot(x - corner, normal), 0.0) * normal;
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
    let material = object_materials.materials[triangle.object - 1u];
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
    let tint = interpolate4(lambda, unpack4x8unorm(va.color), unpack4x8unorm(vb.color), unpack4x8unorm(vc.color));
    let color = clamp(material.color.value.rgb
        * map_value(material.color, x - material.origin, smoothed, uv, tint).rgb, vec3f(0.0), vec3f(1.0));
    let surface = Material(color, material.roughness, material.metallic, material.clearcoat,
        material.clearcoat_roughness);
    // Both sides are alike.
    let view = -normalize(ray);
    let outside = select(-1.0, 1.0, dot(n, view) > 0.0);
    let normal = smoothed * outside;
    // Shadow rays begin on the curved surface that the smoothed normals stand for, so that a coarse
    // mesh does not show its triangles where the light grazes it. [Hanika2021]
    let curved = x + interpolate3(lambda, below_corner(x, va.position, va.normal * outside),
        below_corner(x, vb.position, vb.normal * outside), below_corner(x, vc.position, vc.normal * outside));
    let largest = max(abs(x.x), max(abs(x.y), abs(x.z)));
    let up = normalize(n) * outside;
    let origin = curved + up * (OFFSET * (1.0 + largest));
    // Rays through the fur start anywhere within a cell, which hides the cells' walls.
    let film = vec2u(frame.tile_origin + vec2i(xy));
    let seed = hash2(frame.seed, hash2(film.x, film.y));
    let jitter = (random3(seed, 0u) - 0.5) * fur_grid.cell;

    let at = sample_vector(i);
    var radiance = vec3f(0.0);
    var arriving = 0.0;   // luminance of the irradiance
    var unshadowed = 0.0; // that without shadows
    if light_batch.first > 0u {
        let sums = bitcast<vec4f>(samples[at]);
        radiance = sums.rgb;
        arriving = sums.a;
        unshadowed = bitcast<f32>(samples[at + 1u].x);
    }
    for (var j = light_batch.first; j < light_batch.end; j++) {
        let l = lights.lights[j].direction;
        let cosine = dot(normal, l);
        if cosine <= 0.0 {
            continue;
        }
        let irradiance = lights.lights[j].irradiance * cosine;
        unshadowed += luminance(irradiance);
        let way = within_light(l, lights.lights[j].spread, random2(seed, 3u + 2u * j), up);
        if blocked(origin, way) {
            continue;
        }
        let lit = irradiance * exp(-fur_depth(x + jitter, way)); // [Max1995]
        arriving += luminance(lit);
        radiance += lit * scatter_material(surface, normal, view, l, lights.lights[j].spread);
    }
    if light_batch.end < fur.lights.count {
        samples[at] = bitcast<vec4u>(vec4f(radiance, arriving));
        samples[at + 1u].x = bitcast<u32>(unshadowed);
        return;
    }
    if material.shadow_catcher == 1u {
        let share = select(1.0, arriving / max(unshadowed, 1e-20), unshadowed > 0.0);
        base_records[i] = pack_translucent_base(z, vec3f(0.0), share, normal);
    } else {
        base_records[i] = pack_base(z, min(radiance, vec3f(LARGEST)), normal);
    }
    if FEATURES {
        samples[at + 2u].x = pack_albedo(select(color, vec3f(0.0), material.shadow_catcher == 1u));
        samples[at + 2u].y = triangle.object;
    }
}
