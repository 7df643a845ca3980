// Reads the lists of shared/oit in order. Needs: fragment_lists (array<u32>, read); shared/oit,
// shared/frame.

#import shared/halves
#import shared/octahedral
#import shared/record

const BATCH: u32 = 24u;

// The nodes that follow a given fragment in order of depth, at most BATCH of them.
struct Batch {
    count: u32,
    more: bool,              // whether further nodes follow
    length: u32,             // of the whole list
    z: array<f32, BATCH>,
    source: array<u32, BATCH>,
    node: array<u32, BATCH>,
}

fn node_color(node: u32) -> vec4f {
    let at = node_word(node);
    return unpack_half4(vec2u(fragment_lists[at + NODE_COLOR], fragment_lists[at + NODE_COLOR + 1u]));
}

// With FEATURES: albedo of a node's hairs.
fn node_albedo(node: u32) -> vec3f {
    return unpack_albedo(fragment_lists[node_word(node) + NODE_ALBEDO]);
}

// With FEATURES: direction of a node's hairs, from root to tip.
fn node_tangent(node: u32) -> vec3f {
    return unpack_direction(fragment_lists[node_word(node) + NODE_TANGENT]);
}

// Where the next batch is read from: the last node of a batch if the list is sorted, otherwise 0,
// the whole list again.
fn read_from(node: u32) -> u32 {
    return select(0u, node, (frame.flags & FLAG_SORTED_LISTS) != 0u);
}

// Collects the nodes that follow (z_after, source_after), by insertion sort. Lists longer than a
// batch take several calls. `first`: 0, or a node of a sorted list that none of these precedes.
fn read_batch(batch: ptr<function, Batch>, sample_index: u32, z_after: f32, source_after: u32, first: u32) {
    (*batch).count = 0u;
    (*batch).more = false;
    (*batch).length = 0u;
    var node = first;
    if first == 0u {
        node = fragment_lists[head_word(sample_index)];
    }
    while node != 0u && !(first != 0u && (*batch).more) {
        (*batch).length++;
        let at = node_word(node);
        let z = bitcast<f32>(fragment_lists[at + NODE_Z]);
        let source = fragment_lists[at + NODE_SOURCE];
        if lies_before(z_after, source_after, z, source) {
            var slot = (*batch).count;
            let full = slot == BATCH;
            if full {
                (*batch).more = true;
                slot = BATCH - 1u;
            }
            if !full || lies_before(z, source, (*batch).z[BATCH - 1u], (*batch).source[BATCH - 1u]) {
                while slot > 0u {
                    let before = (*batch).z[slot - 1u];
                    if lies_before(before, (*batch).source[slot - 1u], z, source) {
                        break;
                    }
                    (*batch).z[slot] = before;
                    (*batch).source[slot] = (*batch).source[slot - 1u];
                    (*batch).node[slot] = (*batch).node[slot - 1u];
                    slot--;
                }
                (*batch).z[slot] = z;
                (*batch).source[slot] = source;
                (*batch).node[slot] = node;
                (*batch).count = min((*batch).count + 1u, BATCH);
            }
        }
        node = fragment_lists[at];
    }
}
