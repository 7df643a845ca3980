// Places of the lattice's nodes.
// Needs: columns (array<Column>), fur (uniform FurParameters); shared/shell, shared/column.

// Height above the skin of a level, in shell heights.
fn level_height(level: u32) -> f32 {
    return f32(level) / f32(fur.lattice.levels) * fur.lattice.reach;
}

// Sets `place` to a node; returns its position (world, cm).
fn enter_node(place: ptr<function, Place>, column: u32, level: u32) -> vec3f {
    enter_prism(place, columns[column].prism);
    let l = column_lambda(columns[column].grid);
    (*place).lambda = l;
    (*place).t = level_height(level);
    return skin_at(place, l) + (*place).t * extrusion(place);
}
