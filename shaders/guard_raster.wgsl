// Step 6: coverage of the guard hairs' ribbons, one invocation per segment.
// DEVIATION: [Andersen2016] draws quads; walking the samples along a segment in compute gives the
// coverage of the camera-facing ribbon analytically (a box filter one sample wide across the hair),
// at any width, without aliasing.
// In: the tile's `bins`, `strand_vertices` (cm), `shades` (linear RGB radiance), `base_records`.
// Out: strand fragments in `fragment_lists`, premultiplied.

struct Bin {
    start: u32,
    strands: u32,
}

@group(0) @binding(1) var<uniform> bin: Bin;
@group(0) @binding(2) var<uniform> groom: Groom;
@group(0) @binding(3) var<storage, read> bins: array<u32>;
@group(0) @binding(4) var<storage, read> roots: array<Root>;
@group(0) @binding(5) var<storage, read> strand_vertices: array<vec4f>;
@group(0) @binding(6) var<storage, read> shades: array<vec2u>;
@group(0) @binding(7) var<storage, read> base_records: array<vec4u>;
@group(0) @binding(8) var<storage, read_write> fragment_lists: array<atomic<u32>>;

#import shared/frame
#import shared/index
#import shared/random
#import shared/groom_types
#import shared/root_types
#import shared/strands
#import shared/oit
#import shared/oit_write
#import shared/coverage
#import shared/base
#import shared/record
#import shared/shade

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= bin.strands * groom.segments {
        return;
    }
    let strand = bins[bin.start + i / groom.segments];
    let k = i % groom.segments;
    let at = strand * (groom.segments + 1u) + k;
    let shade_a = unpack_half4(shades[shade_word(at)]);
    let shade_b = unpack_half4(shades[shade_word(at + 1u)]);
    if shade_a.w > 0.5 && shade_b.w > 0.5 {
        return; // hidden from the camera
    }
    // A hidden end is not shaded: the other end's shade is used.
    let color_a = select(shade_a.xyz, shade_b.xyz, shade_a.w > 0.5);
    let color_b = select(shade_b.xyz, color_a, shade_b.w > 0.5);
    let va = strand_vertices[at];
    let vb = strand_vertices[at + 1u];
    var a = film_from_world(va.xyz);
    var b = film_from_world(vb.xyz);
    if a.z <= frame.near || b.z <= frame.near {
        return; // crosses the near plane: the camera is inside the fur
    }
    let radius_a = strand_radius(va) * samples_per_slope() / a.z;
    let radius_b = strand_radius(vb) * samples_per_slope() / b.z;
    let opacity_a = strand_opacity(va);
    let opacity_b = strand_opacity(vb);
    let source = fragment_source(KIND_STRAND, hash2(roots[strand].seed, k));
    // Along the major axis every sample column is visited once; consecutive segments share none.
    let d = b.xy - a.xy;
    let steep = abs(d.y) > abs(d.x);
    let a_major = select(a.x, a.y, steep);
    let b_major = select(b.x, b.y, steep);
    let a_minor = select(a.y, a.x, steep);
    let d_minor = select(d.y, d.x, steep);
    let tile_low = select(frame.tile_origin, frame.tile_origin.yx, steep);
    let tile_high = tile_low + vec2i(select(frame.tile_size, frame.tile_size.yx, steep));
    let span = b_major - a_major;
    let cosine = abs(span) * inverseSqrt(max(dot(d, d), 1e-20));
    let first = max(tile_low.x, i32(ceil(min(a_major, b_major) - 0.5)));
    let end = min(tile_high.x, i32(ceil(max(a_major, b_major) - 0.5)));
    for (var column = first; column < end; column++) {
        let u = (f32(column) + 0.5 - a_major) / span;
        // Parameter along the hair in space: perspective-correct.
        let w = u * a.z / mix(b.z, a.z, u);
        let z = mix(a.z, b.z, w);
        let radius = mix(radius_a, radius_b, u);
        let middle = a_minor + u * d_minor;
        let reach = (radius + 0.5) / cosine;
        let low = max(tile_low.y, i32(ceil(middle - reach - 0.5)));
        let high = min(tile_high.y - 1, i32(floor(middle + reach - 0.5)));
        for (var row = low; row <= high; row++) {
            let across = abs(f32(row) + 0.5 - middle) * cosine;
            let alpha = ribbon_coverage(across, radius) * mix(opacity_a, opacity_b, w);
            if alpha < 1e-4 {
                continue;
            }
            let xy = vec2u(select(vec2i(column, row), vec2i(row, column), steep) - frame.tile_origin);
            let index = tile_index(xy);
            if z < base_depth(base_records[index]) {
                let node = add_fragment(index, z, source, vec4f(mix(color_a, color_b, w) * alpha, alpha));
                if FEATURES {
                    let words_a = shades[shade_word(at) + 1u];
                    let words_b = shades[shade_word(at + 1u) + 1u];
                    let albedo = mix(unpack_albedo(words_a.x), unpack_albedo(words_b.x), w);
                    let tangent = mix(unpack_direction(words_a.y), unpack_direction(words_b.y), w);
                    // Directions at the ends of a segment are less than a right angle apart.
                    add_features(node, albedo, tangent * inverseSqrt(max(dot(tangent, tangent), 1e-12)));
                }
            }
        }
    }
}
