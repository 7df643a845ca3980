// Step 1: the prism shell, extruded along smoothed normals, [Andersen2016] sec. 3 and fig. 3.
// `fold` finds how far each vertex can be extruded before a prism folds over, `spread` limits the
// slope of the top, `vertices` extrudes, `prisms_of_triangles` writes the prisms.
// In: `skin_vertices`, height map (cm), `triangles`, `neighbours`. Out: `shell_vertices`, `prisms`.

struct ShellCounts {
    vertices: u32,
    triangles: u32,
}

@group(0) @binding(1) var<uniform> shell_counts: ShellCounts;
@group(0) @binding(2) var<uniform> groom: Groom;
@group(0) @binding(3) var<storage, read> maps_and_tables: array<vec2u>;
@group(0) @binding(4) var<storage, read> skin_vertices: array<ShellVertex>; // height: unused
@group(0) @binding(5) var<storage, read> triangles: array<u32>;
@group(0) @binding(6) var<storage, read> vertex_uv: array<vec2f>;
@group(0) @binding(7) var<storage, read_write> reach: array<atomic<u32>>; // bits of the height, cm
@group(0) @binding(8) var<storage, read> reach_before: array<u32>;
@group(0) @binding(9) var<storage, read_write> shell_vertices: array<ShellVertex>;
@group(0) @binding(10) var<storage, read> neighbours: array<u32>;
@group(0) @binding(11) var<storage, read> subdivisions: array<vec2u>; // level d, first subelement
@group(0) @binding(12) var<storage, read> edge_numbers: array<u32>;
@group(0) @binding(13) var<storage, read_write> prisms: array<Prism>;

#import shared/index
#import shared/shell_types
#import shared/groom

const FOLD_STEPS: u32 = 16u;

fn triangle_vertices(t: u32) -> vec3u {
    return vec3u(triangles[3u * t], triangles[3u * t + 1u], triangles[3u * t + 2u]);
}

// Shell height that the groom asks for at a vertex, cm.
fn wanted_height(v: u32) -> f32 {
    let s = skin_vertices[v];
    return max(0.0, scalar(UNDERCOAT_HEIGHT, point_of_vertex(s, vertex_uv[v], v)));
}

// Where normals converge below the wanted height, the shell would fold over: the three vertices of
// the triangle are lowered until the prism's top keeps a fifth of the skin triangle's area. The
// last step is a twentieth of the height, so that no spot is bald.
@compute @workgroup_size(64)
fn fold(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let t = linear_index(id, groups);
    if t >= shell_counts.triangles {
        return;
    }
    let v = triangle_vertices(t);
    let h = vec3f(wanted_height(v.x), wanted_height(v.y), wanted_height(v.z));
    let p0 = skin_vertices[v.x].position;
    let p1 = skin_vertices[v.y].position;
    let p2 = skin_vertices[v.z].position;
    let n = cross(p1 - p0, p2 - p0);
    var part = 1.0;
    for (var step = 0u; step < FOLD_STEPS; step++) {
        let q0 = p0 + part * h.x * skin_vertices[v.x].normal;
        let q1 = p1 + part * h.y * skin_vertices[v.y].normal;
        let q2 = p2 + part * h.z * skin_vertices[v.z].normal;
        if dot(cross(q1 - q0, q2 - q0), n) > 0.2 * dot(n, n) || step + 1u == FOLD_STEPS {
            for (var k = 0u; k < 3u; k++) {
                atomicMin(&reach[v[k]], bitcast<u32>(part * h[k]));
            }
            return;
        }
        part *= 0.82;
    }
}

// Largest rise of the shell's top along an edge, relative to the edge's length. `spread` lowers the
// surroundings of lowered vertices accordingly, or creases would tear holes. Each round reads one
// table and takes minima into the other, so that the order of triangles does not matter.
const STEEPEST: f32 = 0.8;

@compute @workgroup_size(64)
fn spread(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let t = linear_index(id, groups);
    if t >= shell_counts.triangles {
        return;
    }
    for (var k = 0u; k < 3u; k++) {
        let a = triangles[3u * t + k];
        let b = triangles[3u * t + (k + 1u) % 3u];
        let low_a = bitcast<f32>(reach_before[a]);
        let low_b = bitcast<f32>(reach_before[b]);
        let rise = STEEPEST * distance(skin_vertices[a].position, skin_vertices[b].position);
        atomicMin(&reach[a], bitcast<u32>(min(low_a, low_b + rise)));
        atomicMin(&reach[b], bitcast<u32>(min(low_b, low_a + rise)));
    }
}

@compute @workgroup_size(64)
fn vertices(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let v = linear_index(id, groups);
    if v >= shell_counts.vertices {
        return;
    }
    var s = skin_vertices[v];
    s.height = min(wanted_height(v), bitcast<f32>(atomicLoad(&reach[v])));
    shell_vertices[v] = s;
}

@compute @workgroup_size(64)
fn prisms_of_triangles(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let t = linear_index(id, groups);
    if t >= shell_counts.triangles {
        return;
    }
    let first = 3u * t;
    prisms[t] = Prism(triangle_vertices(t), subdivisions[t].y,
        vec3u(neighbours[first], neighbours[first + 1u], neighbours[first + 2u]), subdivisions[t].x,
        vec3u(edge_numbers[first], edge_numbers[first + 1u], edge_numbers[first + 2u]), 0u);
}
