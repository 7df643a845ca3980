// Adds to the lists of shared/oit.
// Needs: fragment_lists (array<atomic<u32>>); shared/oit, shared/frame.

#import shared/halves

// Adds a fragment to the list of a sample. `color`: premultiplied.
fn add_fragment(sample_index: u32, z: f32, source: u32, color: vec4f) {
    let node = atomicAdd(&fragment_lists[0], 1u) + 1u;
    if node > frame.node_capacity {
        return;
    }
    let at = node_word(node);
    let next = atomicExchange(&fragment_lists[head_word(sample_index)], node);
    atomicStore(&fragment_lists[at], next);
    atomicStore(&fragment_lists[at + NODE_Z], bitcast<u32>(z));
    atomicStore(&fragment_lists[at + NODE_SOURCE], source);
    let packed = pack_half4(color);
    atomicStore(&fragment_lists[at + NODE_COLOR], packed.x);
    atomicStore(&fragment_lists[at + NODE_COLOR + 1u], packed.y);
}
