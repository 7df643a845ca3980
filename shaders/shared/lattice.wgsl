// The light lattice: nodes on a triangular grid over each skin triangle, `levels + 1` of them above one another (a
// column). With one cell a triangle the columns are the skin's vertices, shared by all triangles; finer lattices keep
// their columns triangle by triangle. Needs: fur (uniform Fur).

struct LatticeCell {
    columns: vec3u,
    weights: vec3f,
    level: u32,     // lower of two
    fraction: f32,  // towards the upper
}

fn columns_per_triangle() -> u32 {
    return (fur.lattice + 1u) * (fur.lattice + 2u) / 2u;
}

fn column_index(prism: u32, vertices: vec3u, i: u32, j: u32) -> u32 {
    if fur.lattice == 1u {
        return select(select(vertices.x, vertices.y, i == 1u), vertices.z, j == 1u);
    }
    return prism * columns_per_triangle() + j * (fur.lattice + 1u) - (j * j - j) / 2u + i;
}

// The lattice cell of a place; `t` in shell heights.
fn lattice_cell(prism: u32, vertices: vec3u, lambda: vec3f, t: f32) -> LatticeCell {
    var cell: LatticeCell;
    let height = clamp(t / fur.light_reach, 0.0, 1.0) * f32(fur.levels);
    cell.level = min(u32(height), fur.levels - 1u);
    cell.fraction = height - f32(cell.level);
    if fur.lattice == 1u {
        let inside = max(lambda, vec3f(0.0));
        cell.columns = vertices;
        cell.weights = inside / (inside.x + inside.y + inside.z);
        return cell;
    }
    let n = fur.lattice;
    let f = clamp(lambda.yz, vec2f(0.0), vec2f(1.0)) * f32(n);
    var ij = min(vec2u(f), vec2u(n - 1u));
    if ij.x + ij.y > n - 1u {
        ij.x = n - 1u - min(ij.y, n - 1u);
    }
    let r = clamp(f - vec2f(ij), vec2f(0.0), vec2f(1.0));
    if r.x + r.y <= 1.0 || ij.x + ij.y + 2u > n {
        let sum = max(1.0, r.x + r.y);
        cell.weights = vec3f(1.0 - (r.x + r.y) / sum, r.x / sum, r.y / sum);
        cell.columns = vec3u(column_index(prism, vertices, ij.x, ij.y), column_index(prism, vertices, ij.x + 1u, ij.y),
            column_index(prism, vertices, ij.x, ij.y + 1u));
    } else {
        cell.weights = vec3f(r.x + r.y - 1.0, 1.0 - r.x, 1.0 - r.y);
        cell.columns = vec3u(column_index(prism, vertices, ij.x + 1u, ij.y + 1u),
            column_index(prism, vertices, ij.x, ij.y + 1u), column_index(prism, vertices, ij.x + 1u, ij.y));
    }
    return cell;
}

fn node_index(column: u32, level: u32) -> u32 {
    return column * (fur.levels + 1u) + level;
}
