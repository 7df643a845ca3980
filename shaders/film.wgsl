// Step 7: film samples to pixels, by a separable reconstruction filter over the sample grid. The
// sum runs in a fixed order, so that the result does not depend on threads.
// In: `samples` (shared/film_sample), the filter's weights in `reconstruction`. Out: `pixels`,
// plane by plane: linear RGB and alpha; guard hairs, undercoat, skin; normal of the skin, with
// FEATURES that of what is visible, times opacity; transmittance; fragments; depth (cm) times
// opacity, and opacity; position (cm) times opacity; with FEATURES albedo, tangent, and coverages,
// and, if there are objects, coverages of the skin and of each object.

struct Reconstruction {
    origin: vec2i,          // first pixel of the tile, relative to the tile's first sample
    pixels: vec2u,          // of the tile
    grid: u32,              // samples along a pixel's edge
    reach: i32,             // samples on either side of a pixel's first sample
    taps: u32,              // samples per axis that the filter reads
    planes: u32,            // number of planes written: 4, 20, 23, with FEATURES all 32
    accumulate: u32,        // 1: adds to `pixels`, 0: overwrites them
    scale: f32,             // 1 / passes over the image
    objects: u32,           // number of objects
    padding: u32,
    weights: array<vec4f, 32>, // taps, four per vector
}

@group(0) @binding(1) var<uniform> reconstruction: Reconstruction;
@group(0) @binding(2) var<storage, read> samples: array<vec4u>;
@group(0) @binding(3) var<storage, read_write> pixels: array<f32>; // plane by plane

#import shared/frame
#import shared/index
#import shared/base
#import shared/film_sample

fn weight(k: u32) -> f32 {
    return reconstruction.weights[k / 4u][k % 4u];
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    let count = reconstruction.pixels.x * reconstruction.pixels.y;
    if i >= count {
        return;
    }
    let pixel = vec2i(vec2u(i % reconstruction.pixels.x, i / reconstruction.pixels.x));
    let corner = reconstruction.origin + pixel * i32(reconstruction.grid) - reconstruction.reach;
    var guard = vec3f(0.0);
    var undercoat = vec3f(0.0);
    var base = vec3f(0.0);
    var through = 0.0;
    var fragments = 0.0;
    var z_sum = 0.0;
    var z_weight = 0.0;
    var normal = vec3f(0.0);
    var position = vec3f(0.0);
    var albedo = vec3f(0.0);
    var tangent = vec3f(0.0);
    var coverage = vec3f(0.0);
    for (var y = 0u; y < reconstruction.taps; y++) {
        for (var x = 0u; x < reconstruction.taps; x++) {
            let w = weight(x) * weight(y);
            let xy = clamp(corner + vec2i(vec2u(x, y)), vec2i(0), vec2i(frame.tile_size) - 1);
            let at = sample_vector(tile_index(vec2u(xy)));
            let s = unpack_film_sample(samples[at], samples[at + 1u]);
            guard += w * s.guard;
            undercoat += w * s.undercoat;
            base += w * s.base;
            through += w * s.through;
            fragments += w * f32(s.fragments);
            if s.z < NO_BASE {
                let opacity = w * (1.0 - s.through);
                z_sum += opacity * s.z;
                z_weight += opacity;
                if reconstruction.planes > 20u {
                    position += opacity * (frame.eye + s.z * sample_ray(vec2u(xy)));
                }
            }
            if FEATURES {
                let more = unpack_feature_sample(samples[at + 2u], samples[at + 3u]);
                albedo += w * more.albedo;
                normal += w * more.normal;
                tangent += w * more.tangent;
                coverage += w * more.coverage;
            } else if s.normal != 0u {
                normal += w * unpack_direction(s.normal);
            }
        }
    }
    let all = guard + undercoat + base;
    var values = array<f32, 32>(all.r, all.g, all.b, 1.0 - through, guard.r, guard.g, guard.b,
        undercoat.r, undercoat.g, undercoat.b, base.r, base.g, base.b, normal.x, normal.y, normal.z,
        through, fragments, z_sum, z_weight, position.x, position.y, position.z,
        albedo.r, albedo.g, albedo.b, tangent.x, tangent.y, tangent.z, coverage.x, coverage.y, coverage.z);
    for (var p = 0u; p < reconstruction.planes; p++) {
        let at = p * count + i;
        let before = select(0.0, pixels[at], reconstruction.accumulate == 1u);
        pixels[at] = before + reconstruction.scale * values[p];
    }
}

// Coverages of the skin and of each object, behind the other planes.
@compute @workgroup_size(64)
fn objects(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    let count = reconstruction.pixels.x * reconstruction.pixels.y;
    if i >= count * (1u + reconstruction.objects) {
        return;
    }
    let object = i / count;
    let place = i % count;
    let pixel = vec2i(vec2u(place % reconstruction.pixels.x, place / reconstruction.pixels.x));
    let corner = reconstruction.origin + pixel * i32(reconstruction.grid) - reconstruction.reach;
    var sum = 0.0;
    for (var y = 0u; y < reconstruction.taps; y++) {
        for (var x = 0u; x < reconstruction.taps; x++) {
            let xy = clamp(corner + vec2i(vec2u(x, y)), vec2i(0), vec2i(frame.tile_size) - 1);
            let at = sample_vector(tile_index(vec2u(xy)));
            let s = unpack_feature_sample(samples[at + 2u], samples[at + 3u]);
            if s.object == object {
                sum += weight(x) * weight(y) * s.coverage.z;
            }
        }
    }
    let at = reconstruction.planes * count + i;
    let before = select(0.0, pixels[at], reconstruction.accumulate == 1u);
    pixels[at] = before + reconstruction.scale * sum;
}
