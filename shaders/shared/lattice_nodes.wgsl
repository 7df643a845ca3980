// Numbers of the lattice's nodes: `levels + 1` per column, consecutive.
// Needs: fur (uniform FurParameters).

// The nodes around a place, with weights: three columns, two levels.
struct LatticeCell {
    columns: vec3u,
    weights: vec3f,
    level: u32,     // the lower of two
    fraction: f32,  // towards the upper
}

// A height between two levels.
struct Level {
    lower: u32,
    fraction: f32,  // towards the upper
}

fn node_index(column: u32, level: u32) -> u32 {
    return column * (fur.lattice.levels + 1u) + level;
}

fn node_count() -> u32 {
    return fur.lattice.columns * (fur.lattice.levels + 1u);
}

fn column_of_node(node: u32) -> u32 {
    return node / (fur.lattice.levels + 1u);
}

fn level_of_node(node: u32) -> u32 {
    return node % (fur.lattice.levels + 1u);
}

// The levels around height t, in shell heights.
fn level_at(t: f32) -> Level {
    let height = clamp(t / fur.lattice.reach, 0.0, 1.0) * f32(fur.lattice.levels);
    let lower = min(u32(height), fur.lattice.levels - 1u);
    return Level(lower, height - f32(lower));
}
