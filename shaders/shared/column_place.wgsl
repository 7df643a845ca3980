// Where a node of the light lattice stands. Needs: columns, shared/shell, shared/column.

// Height above the skin of a level, in shell heights.
fn level_height(level: u32) -> f32 {
    return f32(level) / f32(fur.levels) * fur.light_reach;
}

// Sets the place of a node; returns its position.
fn enter_node(place: ptr<function, Place>, column: u32, level: u32) -> vec3f {
    enter_prism(place, columns[column].prism);
    let l = column_lambda(columns[column].grid);
    (*place).lambda = l;
    (*place).t = level_height(level);
    return (*place).p0 + l.y * (*place).e1 + l.z * (*place).e2 + (*place).t * extrusion(place);
}

// From the skin to the shell's top at the place's barycentric coordinates.
fn extrusion(place: ptr<function, Place>) -> vec3f {
    return (*place).v0 + (*place).lambda.y * (*place).w1 + (*place).lambda.z * (*place).w2;
}
