// Linked lists of fragments, one per sample, in one buffer: word 0 counts the nodes, then come one
// head per sample and the nodes. A head or link of 0 ends a list, so that a cleared buffer is
// valid. A node that does not fit is counted but not stored: the counter then exceeds the capacity,
// and the tile is rendered again in smaller parts. [Yang2010], [Andersen2016] sec. 4

#import shared/features

const NODE_WORDS: u32 = 5u;
// Words that a node has in addition with FEATURES.
const NODE_FEATURE_WORDS: u32 = 2u;
const KIND_STRAND: u32 = 0u;
const KIND_ENTRY: u32 = 1u;
const KIND_VOLUME: u32 = 2u;
const KIND_SHIFT: u32 = 30u;
const ID_MASK: u32 = 0x3fffffffu;

// Offsets of the words of a node. Word 0 is the link to the next node.
const NODE_Z: u32 = 1u;        // depth, cm
const NODE_SOURCE: u32 = 2u;   // kind and id; breaks ties of depth independently of arrival
const NODE_COLOR: u32 = 3u;    // premultiplied, four halves; of an entry: unused
const NODE_ALBEDO: u32 = 5u;   // with FEATURES: packed as in shared/record
const NODE_TANGENT: u32 = 6u;  // with FEATURES: a packed direction

fn head_word(sample_index: u32) -> u32 {
    return 1u + sample_index;
}

fn node_word(node: u32) -> u32 {
    return 1u + tile_samples() + (node - 1u) * (NODE_WORDS + select(0u, NODE_FEATURE_WORDS, FEATURES));
}

fn fragment_source(kind: u32, id: u32) -> u32 {
    return (kind << KIND_SHIFT) | (id & ID_MASK);
}

fn fragment_kind(source: u32) -> u32 {
    return source >> KIND_SHIFT;
}

fn fragment_id(source: u32) -> u32 {
    return source & ID_MASK;
}

// Order of the fragments of a sample: by depth, then by source. Strict.
fn lies_before(z_a: f32, source_a: u32, z_b: f32, source_b: u32) -> bool {
    return z_a < z_b || (z_a == z_b && source_a < source_b);
}
