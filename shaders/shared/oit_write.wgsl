// Adding to the lists of shared/oit. Needs: fragment_lists (array<atomic<u32>>).

fn add_fragment(sample_index: u32, z: f32, source: u32, color: vec4f) {
    let node = atomicAdd(&fragment_lists[0], 1u) + 1u;
    if node > frame.node_capacity {
        return;
    }
    let at = node_word(node);
    let next = atomicExchange(&fragment_lists[head_word(sample_index)], node);
    atomicStore(&fragment_lists[at], next);
    atomicStore(&fragment_lists[at + 1u], bitcast<u32>(z));
    atomicStore(&fragment_lists[at + 2u], source);
    atomicStore(&fragment_lists[at + 3u], pack2x16float(color.rg));
    atomicStore(&fragment_lists[at + 4u], pack2x16float(color.ba));
}
