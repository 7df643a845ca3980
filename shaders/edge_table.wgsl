// Step 1: neighbours of the triangles over their edges, [Andersen2016] sec. 3.2. A hash table over
// 64-bit keys of directed edges: `insert` enters every edge in counter-clockwise direction,
// `lookup` finds the reversed key. A slot holds the number of the edge that came first; its key is
// read from the triangles, so that no 64-bit atomics are needed.
// In: `triangles`, three vertices each. Out: `neighbours`, the triangle over the edge opposite each
// corner, or NONE.

struct EdgeCounts {
    edges: u32,
    mask: u32, // number of slots - 1; that number is a power of two
}

@group(0) @binding(1) var<uniform> edge_counts: EdgeCounts;
@group(0) @binding(2) var<storage, read> triangles: array<u32>;
@group(0) @binding(3) var<storage, read_write> slots: array<atomic<u32>>;  // edge + 1; 0: free
@group(0) @binding(4) var<storage, read_write> owners: array<atomic<u32>>; // edges with the key
@group(0) @binding(5) var<storage, read_write> neighbours: array<u32>;

#import shared/constants
#import shared/random
#import shared/index

// Vertices of a directed edge. Edge 3 t + k of triangle t is opposite corner k: from corner k + 1
// to corner k + 2.
fn edge_key(edge: u32) -> vec2u {
    let base = edge - edge % 3u;
    let k = edge % 3u;
    return vec2u(triangles[base + (k + 1u) % 3u], triangles[base + (k + 2u) % 3u]);
}

fn first_slot(key: vec2u) -> u32 {
    return hash2(key.x, key.y) & edge_counts.mask;
}

@compute @workgroup_size(64)
fn insert(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let edge = linear_index(id, groups);
    if edge >= edge_counts.edges {
        return;
    }
    let key = edge_key(edge);
    var slot = first_slot(key);
    loop {
        let seen = atomicCompareExchangeWeak(&slots[slot], 0u, edge + 1u);
        if !seen.exchanged && seen.old_value == 0u {
            continue; // a weak exchange may fail spuriously
        }
        if seen.exchanged || all(edge_key(seen.old_value - 1u) == key) {
            atomicAdd(&owners[slot], 1u);
            return;
        }
        slot = (slot + 1u) & edge_counts.mask;
    }
}

// The slot of a key, or NONE.
fn find(key: vec2u) -> u32 {
    var slot = first_slot(key);
    var entry = atomicLoad(&slots[slot]);
    while entry != 0u {
        if all(edge_key(entry - 1u) == key) {
            return slot;
        }
        slot = (slot + 1u) & edge_counts.mask;
        entry = atomicLoad(&slots[slot]);
    }
    return NONE;
}

// Edges with several owners (non-manifold or inconsistently wound) count as boundaries.
@compute @workgroup_size(64)
fn lookup(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let edge = linear_index(id, groups);
    if edge >= edge_counts.edges {
        return;
    }
    let key = edge_key(edge);
    let own = find(key);
    let other = find(key.yx);
    var neighbour = NONE;
    if own != NONE && other != NONE {
        if atomicLoad(&owners[own]) == 1u && atomicLoad(&owners[other]) == 1u {
            neighbour = (atomicLoad(&slots[other]) - 1u) / 3u;
        }
    }
    neighbours[edge] = neighbour;
}
