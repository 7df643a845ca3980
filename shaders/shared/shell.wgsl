// The prism shell: coordinates in a prism, subelement index, hops to neighbours.
// Needs: shell_vertices (array<ShellVertex>), prisms (array<Prism>), fur (uniform FurParameters).

#import shared/arithmetic
#import shared/barycentric
#import shared/constants
#import shared/shell_types

const HOP_LIMIT: u32 = 16u;

// Coordinates of a point in the shell, and the geometry of its prism.
struct Place {
    prism: u32,
    t: f32,          // height, 0 at the skin, 1 at the top
    lambda: vec3f,   // barycentric in the triangle at height t
    dt_dz: f32,      // derivative of t along the ray of the last `solve` or `locate`
    p0: vec3f, e1: vec3f, e2: vec3f,   // skin triangle: corner and edges
    v0: vec3f, w1: vec3f, w2: vec3f,   // extrusion at corner 0; those at corners 1 and 2 less v0
    vertices: vec3u,
    neighbours: vec3u,
    edges: vec3u,
    cell_base: u32,
    subdivision: u32,
}

// Loads the geometry of a prism.
fn enter_prism(place: ptr<function, Place>, index: u32) {
    let prism = prisms[index];
    let a = shell_vertices[prism.vertices.x];
    let b = shell_vertices[prism.vertices.y];
    let c = shell_vertices[prism.vertices.z];
    (*place).prism = index;
    (*place).p0 = a.position;
    (*place).e1 = b.position - a.position;
    (*place).e2 = c.position - a.position;
    (*place).v0 = a.normal * a.height;
    (*place).w1 = b.normal * b.height - (*place).v0;
    (*place).w2 = c.normal * c.height - (*place).v0;
    (*place).vertices = prism.vertices;
    (*place).neighbours = prism.neighbours;
    (*place).edges = prism.edges;
    (*place).cell_base = prism.cell_base;
    (*place).subdivision = prism.subdivision;
}

// The skin's point at barycentric coordinates of the place's prism.
fn skin_at(place: ptr<function, Place>, lambda: vec3f) -> vec3f {
    return (*place).p0 + lambda.y * (*place).e1 + lambda.z * (*place).e2;
}

// The vector from there to the shell's top, cm.
fn extrusion_at(place: ptr<function, Place>, lambda: vec3f) -> vec3f {
    return (*place).v0 + lambda.y * (*place).w1 + lambda.z * (*place).w2;
}

// Its direction; the triangle's normal where the shell has no height.
fn extrusion_direction(place: ptr<function, Place>, lambda: vec3f) -> vec3f {
    let v = extrusion_at(place, lambda);
    return normalize(select(cross((*place).e1, (*place).e2), v, dot(v, v) > 0.0));
}

// The vector at the barycentric coordinates of the place.
fn extrusion(place: ptr<function, Place>) -> vec3f {
    return extrusion_at(place, (*place).lambda);
}

// The triangle that the prism cuts out of the layer at height t.
struct Layer {
    e1: vec3f,
    e2: vec3f,
    n: vec3f,   // cross product of the edges
}

fn layer_at(place: ptr<function, Place>, t: f32) -> Layer {
    let e1 = (*place).e1 + t * (*place).w1;
    let e2 = (*place).e2 + t * (*place).w2;
    return Layer(e1, e2, cross(e1, e2));
}

// Derivative with respect to t of F, whose root `solve` finds. `a`: x relative to corner 0 of the
// layer.
fn volume_slope(place: ptr<function, Place>, layer: Layer, a: vec3f) -> f32 {
    return dot(a, cross((*place).w1, layer.e2) + cross(layer.e1, (*place).w2)) - dot((*place).v0, layer.n);
}

// Sets height and barycentric coordinates of x: the exact inverse of
// x(t, lambda) = sum lambda_k (p_k + t v_k), by Newton's method on the cubic F(t) = a . (e1 x e2)
// from the t in `place`. `ray`: the direction for dt_dz.
// DEVIATION: [Andersen2016] sec. 3.2 takes t from distances to the prism's top, which disagrees
// between neighbours and shows seams.
fn solve(place: ptr<function, Place>, x: vec3f, ray: vec3f, iterations: u32) {
    var t = (*place).t;
    for (var i = 0u; i < iterations; i++) {
        let a = x - (*place).p0 - t * (*place).v0;
        let layer = layer_at(place, t);
        let slope = volume_slope(place, layer, a);
        t = clamp(t - dot(a, layer.n) / away_from_zero(slope, -1e-12), -0.5, 1.5 * fur.lattice.reach);
    }
    let a = x - (*place).p0 - t * (*place).v0;
    let layer = layer_at(place, t);
    let slope = volume_slope(place, layer, a);
    (*place).t = t;
    (*place).lambda = barycentric_at(a, layer.e1, layer.e2, layer.n, 1.0 / max(dot(layer.n, layer.n), 1e-30));
    (*place).dt_dz = -dot(ray, layer.n) / away_from_zero(slope, -1e-12);
}

const INSIDE: u32 = 0u;
const LEFT_BORDER: u32 = 1u;  // left the shell over a boundary edge of the skin
const LOST: u32 = 2u;         // too many hops

// Finds the prism of x, hopping over the most negative barycentric coordinate.
// DEVIATION: [Andersen2016] sec. 3.2 names the closest edge; taken literally (unsigned distance)
// that loses most rays. The code loads and solves in one place, because all lanes pay for the whole
// loop body as long as one of them needs it.
fn locate(place: ptr<function, Place>, x: vec3f, ray: vec3f, iterations: u32) -> u32 {
    var index = (*place).prism;
    var state = LOST;
    for (var hop = 0u; hop < HOP_LIMIT; hop++) {
        enter_prism(place, index);
        solve(place, x, ray, iterations);
        let l = (*place).lambda;
        let least = min(l.x, min(l.y, l.z));
        let neighbours = (*place).neighbours;
        let next = select(select(neighbours.z, neighbours.y, l.y == least), neighbours.x, l.x == least);
        // A point on the border wall may lie outside by rounding.
        let inside = least >= select(-1e-5, -2e-3, next == NONE);
        if inside || next == NONE {
            state = select(LEFT_BORDER, INSIDE, inside);
            break;
        }
        index = next;
    }
    return state;
}

// Subelement of a triangle of level d, [Andersen2016] eq. 1 and 2; e_x is the edge opposite
// corner x, so that the ratio of distances is lambda_x. Both clamps are needed: points on an edge
// give i_x = 2^d, and rounding near grid vertices breaks the sum of the fractions.
fn subelement(lambda: vec3f, d: u32) -> u32 {
    let n = i32(1u << d);
    // [Andersen2016] eq. 1
    let i = clamp(vec3i(floor((1.0 - lambda) * f32(n))), vec3i(0), vec3i(n - 1));
    let offset = clamp(i.y - i.z, -i.x, i.x);
    return u32(i.x * (1 + i.x) + offset); // [Andersen2016] eq. 2
}

// Barycentric centroid of a subelement: the inverse of `subelement`.
fn subelement_centroid(id: u32, d: u32) -> vec3f {
    let n = i32(1u << d);
    var row = i32(sqrt(f32(id)));
    row += i32((row + 1) * (row + 1) <= i32(id)) - i32(row * row > i32(id));
    let offset = i32(id) - row * (row + 1);
    let upright = ((offset - row) & 1) == 0;
    let sum = select(2 * n - 1, 2 * n - 2, upright);
    let i = vec3i(row, (sum - row + offset) / 2, (sum - row - offset) / 2);
    return 1.0 - (vec3f(i) + select(1.0 / 3.0, 2.0 / 3.0, upright)) / f32(n);
}

// Index of a subelement in the volume. The level d varies between prisms.
fn volume_index(place: ptr<function, Place>, layer: u32, id: u32) -> u32 {
    return (*place).cell_base + (layer << (2u * (*place).subdivision)) + id; // [Andersen2016] eq. 3
}

// Density of hairs with direction `tangent` at height t of the place's prism, relative to that on
// the skin: hairs spread over a layer of different area, and across leaning hairs the layer's area
// is foreshortened.
fn crowding(place: ptr<function, Place>, t: f32, tangent: vec3f) -> f32 {
    let skin = length(cross((*place).e1, (*place).e2));
    let layer = layer_at(place, t).n;
    return skin / max(dot(layer, tangent), 0.3 * max(length(layer), skin * 0.1));
}
