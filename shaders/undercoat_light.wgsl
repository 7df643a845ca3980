// Step 2: optical depth from every node of the light lattice to every light, and to the eye: one march a node and light instead
// of a nested march at every step of the eye's ray. Undercoat and guard hairs count alike.

@group(0) @binding(1) var<uniform> fur: Fur;
@group(0) @binding(2) var<uniform> noise: Noise;
@group(0) @binding(3) var<uniform> lights: Lights;
@group(0) @binding(4) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(5) var<storage, read> prisms: array<Prism>;
@group(0) @binding(6) var<storage, read> cells: array<u32>;
@group(0) @binding(7) var<storage, read> columns: array<Column>;
@group(0) @binding(8) var<storage, read> guard_extinction: array<f32>;
@group(0) @binding(9) var<storage, read_write> tau: array<u32>; // pairs of halves

#import shared/frame
#import shared/index
#import shared/random
#import shared/noise
#import shared/octahedral
#import shared/undercoat
#import shared/clumps
#import shared/shell
#import shared/uv_in_cells
#import shared/volume
#import shared/lattice
#import shared/column
#import shared/lights

// Extinction by undercoat and guard hairs at a place, towards w.
fn fur_extinction(place: ptr<function, Place>, w: vec3f) -> f32 {
    let cell = lattice_cell((*place).prism, (*place).vertices, (*place).lambda, (*place).t);
    var guard = 0.0;
    var density = 0.0;
    for (var k = 0u; k < 3u; k++) {
        let node = node_index(cell.columns[k], cell.level);
        guard += cell.weights[k] * mix(guard_extinction[node], guard_extinction[node + 1u], cell.fraction);
        density += cell.weights[k] * columns[cell.columns[k]].density;
    }
    var sigma = guard * 0.7853982; // pi/4: the mean sine
    if (*place).t <= 1.0 && fur.extinction > 0.0 {
        sigma += density * extinction(medium_at(place), w);
    }
    return sigma;
}

// Optical depth from x in the place towards w.
fn optical_depth(start: ptr<function, Place>, x: vec3f, w: vec3f, behind: bool) -> f32 {
    var place = *start;
    var sum = 0.0;
    // The first half step covers the node's own surroundings.
    var step = 0.5 * fur.light_step;
    var distance = 0.0;
    for (var i = 0u; i < 400u; i++) {
        let state = locate(&place, x + (distance + 0.5 * step) * w, w, 2u);
        if state != INSIDE || place.t > fur.light_reach {
            break;
        }
        if place.t < -0.02 {
            return TAU_BLOCKED;
        }
        sum += fur_extinction(&place, w) * step;
        if sum >= TAU_BLOCKED {
            return TAU_BLOCKED;
        }
        distance += step;
        step = min(fur.light_step, step * 1.5);
    }
    return select(sum, TAU_BLOCKED, behind);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    let nodes = fur.columns * (fur.levels + 1u);
    let pairs = tau_pairs();
    if i >= nodes * pairs {
        return;
    }
    let node = i / pairs;
    let pair = i % pairs;
    let column = node / (fur.levels + 1u);
    let spot = column_spot(column, columns[column].corner);
    var place: Place;
    enter_prism(&place, spot.prism);
    place.lambda = spot.lambda;
    place.t = f32(node % (fur.levels + 1u)) / f32(fur.levels) * fur.light_reach;
    let l = spot.lambda;
    let x = place.p0 + l.y * place.e1 + l.z * place.e2 + place.t * (place.v0 + l.y * place.w1 + l.z * place.w2);
    var values = vec2f(0.0);
    for (var k = 0u; k < 2u; k++) {
        let j = 2u * pair + k;
        if j < fur.lights {
            let behind = (columns[column].blocked[j >> 5u] & (1u << (j & 31u))) != 0u;
            values[k] = optical_depth(&place, x, lights.lights[j].direction, behind);
        } else if j == fur.lights {
            values[k] = optical_depth(&place, x, normalize(frame.eye - x), false);
        }
    }
    tau[i] = pack2x16float(values);
}
