// Which rays meet triangles of the skin or of objects: a binary BVH built by obvhs.
// Needs: bvh_nodes (array<BvhNode>), bvh_triangles (array<u32>, triangles in the order of the
// leaves), shell_vertices (array<ShellVertex>), prisms (array<Prism>).

#import shared/shell_types

struct BvhNode {
    low: vec3f,
    first: u32,   // first child, or first primitive
    high: vec3f,
    count: u32,   // primitives; 0 for an inner node
}

// Slab test. `inverse`: reciprocals of the ray's components. [KayKajiya1986]
fn hits_box(node: u32, origin: vec3f, inverse: vec3f) -> bool {
    let a = (bvh_nodes[node].low - origin) * inverse;
    let b = (bvh_nodes[node].high - origin) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    return min(far.x, min(far.y, far.z)) >= max(0.0, max(near.x, max(near.y, near.z)));
}

// Whether a ray hits either side of a triangle at a positive distance. [MollerTrumbore1997]
fn hits_triangle(triangle: u32, origin: vec3f, ray: vec3f) -> bool {
    let v = prisms[triangle].vertices;
    let p0 = shell_vertices[v.x].position;
    let e1 = shell_vertices[v.y].position - p0;
    let e2 = shell_vertices[v.z].position - p0;
    let h = cross(ray, e2);
    let det = dot(e1, h);
    if abs(det) < 1e-12 {
        return false;
    }
    let s = (origin - p0) / det;
    let u = dot(s, h);
    let q = cross(s, e1);
    let v2 = dot(ray, q);
    return u >= 0.0 && v2 >= 0.0 && u + v2 <= 1.0 && dot(e2, q) > 0.0;
}

// Whether the ray hits any triangle; depth-first traversal with a stack. The tree has fewer levels
// than the stack has entries (`prepare::occluders`).
fn blocked(origin: vec3f, ray: vec3f) -> bool {
    let inverse = 1.0 / select(ray, vec3f(1e-12), abs(ray) < vec3f(1e-12));
    var stack: array<u32, 48>;
    var depth = 1u;
    stack[0] = 0u;
    while depth > 0u {
        depth--;
        let node = stack[depth];
        if !hits_box(node, origin, inverse) {
            continue;
        }
        let first = bvh_nodes[node].first;
        let count = bvh_nodes[node].count;
        if count == 0u {
            stack[depth] = first;
            stack[depth + 1u] = first + 1u;
            depth += 2u;
            continue;
        }
        for (var i = first; i < first + count; i++) {
            if hits_triangle(bvh_triangles[i], origin, ray) {
                return true;
            }
        }
    }
    return false;
}
