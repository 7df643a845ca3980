// Step 6: which strands touch which tile, so that a small tile needs no pass over all strands.
// `count` sizes the bins and `fill` writes them; the order within a bin does not matter. Where the
// strands exceed the memory budget, `gather` picks the roots whose strands may touch one tile, and
// only those are grown.
// In: `tile_grid`, `strand_vertices` (cm) or `roots`. Out: `bin_counts`, `bins`, `tile_roots`.

struct TileGrid {
    origin: vec2i,   // of the grid, samples
    size: vec2u,     // of a tile, samples
    grid: vec2u,     // tiles
    margin: f32,     // samples by which a tile extends past its edge
    length: f32,     // of the longest strand including all displacements, cm
}

@group(0) @binding(1) var<uniform> strand_batch: StrandBatch;
@group(0) @binding(2) var<uniform> tile_grid: TileGrid;
@group(0) @binding(3) var<uniform> groom: Groom;
@group(0) @binding(4) var<storage, read> strand_vertices: array<vec4f>;
@group(0) @binding(5) var<storage, read_write> bin_counts: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read> bin_starts: array<u32>;
@group(0) @binding(7) var<storage, read_write> bins: array<u32>;
@group(0) @binding(8) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(9) var<storage, read> prisms: array<Prism>;
@group(0) @binding(10) var<storage, read> roots: array<Root>;
@group(0) @binding(11) var<storage, read_write> tile_roots: array<Root>;

#import shared/frame
#import shared/index
#import shared/groom_types
#import shared/root_types
#import shared/skin
#import shared/strands

// First and last tile that a strand touches, x and y each; last < first if it touches none.
fn touched(strand: u32) -> vec4i {
    let first = strand * (groom.segments + 1u);
    var low = vec2f(1e30);
    var high = vec2f(-1e30);
    var crosses_near = false;
    var in_front = false;
    for (var k = 0u; k <= groom.segments; k++) {
        let v = strand_vertices[first + k];
        let p = film_from_world(v.xyz);
        if p.z <= frame.near {
            crosses_near = true;
            continue;
        }
        in_front = true;
        let pad = strand_radius(v) * samples_per_slope() / p.z + 2.0;
        low = min(low, p.xy - pad);
        high = max(high, p.xy + pad);
    }
    if !in_front {
        return vec4i(0, 0, -1, -1);
    }
    if crosses_near {
        return vec4i(vec2i(0), vec2i(tile_grid.grid) - 1);
    }
    let origin = vec2f(tile_grid.origin);
    let size = vec2f(tile_grid.size);
    let a = vec2i(clamp(floor((low - tile_grid.margin - origin) / size), vec2f(0.0), vec2f(tile_grid.grid)));
    let b = vec2i(clamp(floor((high + tile_grid.margin - origin) / size), vec2f(-1.0), vec2f(tile_grid.grid) - 1.0));
    return vec4i(a, b);
}

@compute @workgroup_size(64)
fn count(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= strand_batch.strands {
        return;
    }
    let t = touched(i);
    for (var y = t.y; y <= t.w; y++) {
        for (var x = t.x; x <= t.z; x++) {
            atomicAdd(&bin_counts[u32(y) * tile_grid.grid.x + u32(x)], 1u);
        }
    }
}

@compute @workgroup_size(64)
fn fill(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= strand_batch.strands {
        return;
    }
    let t = touched(i);
    for (var y = t.y; y <= t.w; y++) {
        for (var x = t.x; x <= t.z; x++) {
            let bin = u32(y) * tile_grid.grid.x + u32(x);
            bins[bin_starts[bin] + atomicAdd(&bin_counts[bin], 1u)] = i;
        }
    }
}

@compute @workgroup_size(64)
fn gather(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= strand_batch.strands {
        return;
    }
    let root = roots[i];
    let p = film_from_world(skin_position(prisms[root.prism].vertices, root_lambda(root)));
    if p.z + tile_grid.length < frame.near {
        return;
    }
    let nearest = p.z - tile_grid.length;
    if nearest > frame.near {
        // A sphere around the root; away from the view axis its image is slightly elongated.
        let slope = max(frame.tan_x, frame.tan_y);
        let radius = tile_grid.length * samples_per_slope() / nearest * sqrt(1.0 + 2.0 * slope * slope) + tile_grid.margin;
        let low = vec2f(frame.tile_origin) - radius;
        let high = vec2f(frame.tile_origin + vec2i(frame.tile_size)) + radius;
        if any(p.xy < low) || any(p.xy > high) {
            return;
        }
    }
    let slot = atomicAdd(&bin_counts[0], 1u);
    tile_roots[slot] = root;
    bins[slot] = slot;
}
