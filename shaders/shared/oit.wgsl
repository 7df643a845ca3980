// Per-sample linked lists of fragments in one buffer: word 0 counts the nodes, then one head a sample, then the nodes.
// A head or link of 0 ends a list, so that a cleared buffer is valid. A node that finds no room is counted, not stored:
// the counter then exceeds the capacity and the tile is rendered again in smaller parts. After [Andersen2016] sec. 4.

const NODE_WORDS: u32 = 5u;
const KIND_STRAND: u32 = 0u;
const KIND_ENTRY: u32 = 1u;
const KIND_VOLUME: u32 = 2u;
const KIND_SHIFT: u32 = 30u;
const ID_MASK: u32 = 0x3fffffffu;

struct Node {
    next: u32,
    z: f32,        // depth, cm
    source: u32,   // kind and id: breaks ties of depth, so that the order of arrival does not show
    color: vec4f,  // premultiplied; of an entry: unused
}

fn head_word(sample_index: u32) -> u32 {
    return 1u + sample_index;
}

fn node_word(node: u32) -> u32 {
    return 1u + frame.tile_size.x * frame.tile_size.y + (node - 1u) * NODE_WORDS;
}
