// Reading the lists of shared/oit in order. Needs: fragment_lists (array<u32>, read).

const BATCH: u32 = 24u;

// The nearest nodes behind a key, in order; at most BATCH at a time.
struct Batch {
    count: u32,
    more: bool,              // there are nodes behind the batch
    length: u32,             // of the whole list
    z: array<f32, BATCH>,
    source: array<u32, BATCH>,
    node: array<u32, BATCH>,
}

fn node_color(node: u32) -> vec4f {
    let at = node_word(node);
    return vec4f(unpack2x16float(fragment_lists[at + 3u]), unpack2x16float(fragment_lists[at + 4u]));
}

// Collects the nodes behind (z_after, source_after) by insertion. Lists of any length are read in several rounds.
fn read_batch(batch: ptr<function, Batch>, sample_index: u32, z_after: f32, source_after: u32) {
    (*batch).count = 0u;
    (*batch).more = false;
    (*batch).length = 0u;
    var node = fragment_lists[head_word(sample_index)];
    while node != 0u {
        (*batch).length++;
        let at = node_word(node);
        let z = bitcast<f32>(fragment_lists[at + 1u]);
        let source = fragment_lists[at + 2u];
        let behind = z > z_after || (z == z_after && source > source_after);
        if behind {
            var slot = (*batch).count;
            let full = slot == BATCH;
            if full {
                (*batch).more = true;
                slot = BATCH - 1u;
            }
            let last_z = (*batch).z[BATCH - 1u];
            if !full || z < last_z || (z == last_z && source < (*batch).source[BATCH - 1u]) {
                while slot > 0u {
                    let before = (*batch).z[slot - 1u];
                    if before < z || (before == z && (*batch).source[slot - 1u] < source) {
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
