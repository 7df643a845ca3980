// Adds to the lists of shared/oit.
// Needs: fragment_lists (array<atomic<u32>>); shared/oit, shared/frame.

#import shared/halves
#import shared/octahedral
#import shared/record

// Adds a fragment to the list of a sample. `color`: premultiplied. Returns the node's first word; 0
// if it does not fit.
fn add_fragment(sample_index: u32, z: f32, source: u32, color: vec4f) -> u32 {
    let node = atomicAdd(&fragment_lists[0], 1u) + 1u;
    if node > frame.node_capacity {
        return 0u;
    }
    let at = node_word(node);
    let next = atomicExchange(&fragment_lists[head_word(sample_index)], node);
    atomicStore(&fragment_lists[at], next);
    atomicStore(&fragment_lists[at + NODE_Z], bitcast<u32>(z));
    atomicStore(&fragment_lists[at + NODE_SOURCE], source);
    let packed = pack_half4(color);
    atomicStore(&fragment_lists[at + NODE_COLOR], packed.x);
    atomicStore(&fragment_lists[at + NODE_COLOR + 1u], packed.y);
    return at;
}

// With FEATURES: completes the node that begins at a word returned by `add_fragment`.
fn add_features(at: u32, albedo: vec3f, tangent: vec3f) {
    if at != 0u {
        atomicStore(&fragment_lists[at + NODE_ALBEDO], pack_albedo(albedo));
        atomicStore(&fragment_lists[at + NODE_TANGENT], pack_direction(tangent));
    }
}
