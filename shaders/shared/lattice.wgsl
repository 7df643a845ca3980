// The optical-depth lattice: columns of `levels + 1` nodes over a triangular grid on each skin
// triangle. Columns at the skin's vertices come first, then those within edges, then those within
// triangles. Neighbours share columns, so that lookups are continuous. Cf. deep opacity maps,
// [YukselKeyser2008].
// Needs: fur (uniform FurParameters); shared/shell.

#import shared/lattice_nodes

// Column at grid point k of the edge from vertex a to b, counted from a.
fn edge_column(edge: u32, a: u32, b: u32, k: u32) -> u32 {
    return fur.lattice.vertices + edge * (fur.lattice.cells - 1u) + select(fur.lattice.cells - k, k, a < b) - 1u;
}

// Column at barycentric coordinates (n - i - j, i, j) / n of a triangle.
fn column_index(prism: u32, vertices: vec3u, edges: vec3u, i: u32, j: u32) -> u32 {
    let n = fur.lattice.cells;
    if i + j == 0u { return vertices.x; }
    if i == n { return vertices.y; }
    if j == n { return vertices.z; }
    if j == 0u { return edge_column(edges.z, vertices.x, vertices.y, i); }
    if i == 0u { return edge_column(edges.y, vertices.x, vertices.z, j); }
    if i + j == n { return edge_column(edges.x, vertices.y, vertices.z, j); }
    let inner = (n - 1u) * (n - 2u) / 2u;
    return fur.lattice.vertices + fur.lattice.edges * (n - 1u) + prism * inner + (j - 1u) * (n - 1u) - (j - 1u) * j / 2u + i - 1u;
}

// The lattice cell that contains a place.
fn lattice_cell(place: ptr<function, Place>) -> LatticeCell {
    var cell: LatticeCell;
    let level = level_at((*place).t);
    cell.level = level.lower;
    cell.fraction = level.fraction;
    let inside = max((*place).lambda, vec3f(0.0));
    let lambda = inside / (inside.x + inside.y + inside.z);
    let vertices = (*place).vertices;
    if fur.lattice.cells == 1u {
        cell.columns = vertices;
        cell.weights = lambda;
        return cell;
    }
    let n = fur.lattice.cells;
    let f = lambda.yz * f32(n);
    let i = min(u32(f.x), n - 1u);
    let j = min(u32(f.y), n - 1u - i);
    let r = f - vec2f(f32(i), f32(j));
    let upright = r.x + r.y <= 1.0 || i + j + 1u == n;
    let prism = (*place).prism;
    let edges = (*place).edges;
    if upright {
        cell.weights = vec3f(max(0.0, 1.0 - r.x - r.y), r);
        cell.columns = vec3u(column_index(prism, vertices, edges, i, j),
            column_index(prism, vertices, edges, i + 1u, j), column_index(prism, vertices, edges, i, j + 1u));
    } else {
        cell.weights = vec3f(r.x + r.y - 1.0, 1.0 - r.x, 1.0 - r.y);
        cell.columns = vec3u(column_index(prism, vertices, edges, i + 1u, j + 1u),
            column_index(prism, vertices, edges, i, j + 1u), column_index(prism, vertices, edges, i + 1u, j));
    }
    return cell;
}
