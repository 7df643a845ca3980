// Step 2: which lights the skin itself or an object blocks outside the shell, once for each column
// of the lattice: a ray from the lattice's top through a BVH over their triangles.
// In: triangles, `bvh_nodes`, `bvh_triangles`, `lights`. Out: `blocked` of `columns`, one bit
// per light.

@group(0) @binding(1) var<uniform> fur: FurParameters;
@group(0) @binding(2) var<uniform> lights: Lights;
@group(0) @binding(3) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(4) var<storage, read> prisms: array<Prism>;
@group(0) @binding(5) var<storage, read> bvh_nodes: array<BvhNode>;
@group(0) @binding(6) var<storage, read> bvh_triangles: array<u32>; // triangles in leaf order
@group(0) @binding(7) var<storage, read_write> columns: array<Column>;

#import shared/index
#import shared/undercoat_types
#import shared/shell
#import shared/column
#import shared/column_place
#import shared/lights
#import shared/bvh

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= fur.lattice.columns {
        return;
    }
    var place: Place;
    // Slightly above the skin even where there is no undercoat.
    let origin = enter_node(&place, i, fur.lattice.levels) + normalize(cross(place.e1, place.e2)) * 1e-3;
    var bits = vec2u(0u);
    for (var j = 0u; j < fur.lights.count; j++) {
        if blocked(origin, lights.lights[j].direction) {
            bits[blocked_word(j)] |= blocked_bit(j);
        }
    }
    columns[i].blocked = bits;
}
