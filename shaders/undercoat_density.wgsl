// Step 2: densities and tangents of the undercoat's subelements from simplex noise, [Andersen2016]
// sec. 3.2; four bytes per subelement. One invocation fills one layer of one prism.
// In: `shell_vertices`, `prisms`, `noise`, `corner_uv`. Out: `media_or_uv`, packed media
// (shared/undercoat).

struct DensityCounts {
    triangles: u32,
}

@group(0) @binding(1) var<uniform> density_counts: DensityCounts;
@group(0) @binding(2) var<uniform> fur: FurParameters;
@group(0) @binding(3) var<uniform> noise: Noise;
@group(0) @binding(4) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(5) var<storage, read> prisms: array<Prism>;
@group(0) @binding(6) var<storage, read> corner_uv: array<vec2f>;
@group(0) @binding(7) var<storage, read_write> media_or_uv: array<u32>;

#import shared/index
#import shared/random
#import shared/noise
#import shared/octahedral
#import shared/undercoat
#import shared/clumps
#import shared/shell
#import shared/uv_in_corners
#import shared/volume

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= density_counts.triangles * fur.undercoat.layers {
        return;
    }
    let layer = i % fur.undercoat.layers;
    var place: Place;
    enter_prism(&place, i / fur.undercoat.layers);
    for (var cell = 0u; cell < (1u << (2u * place.subdivision)); cell++) {
        media_or_uv[volume_index(&place, layer, cell)] = pack_medium(subelement_medium(&place, layer, cell));
    }
}
