// Step 2: optical depth from every node of the lattice towards every light and towards the camera,
// instead of a nested march at every step of the view ray. Undercoat and guard hairs both count.
// Level by level from the top: a ray that climbs is marched to the next level and takes the rest
// from there; any other is marched to its end. Cf. [YukselKeyser2008]
// In: `lattice_extinction` (1/cm), `columns`. Out: `tau` (shared/tau), `light_counters`.

struct Sweep {
    level: u32,
}

@group(0) @binding(1) var<uniform> sweep: Sweep;
@group(0) @binding(2) var<uniform> fur: FurParameters;
@group(0) @binding(3) var<uniform> lights: Lights;
@group(0) @binding(4) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(5) var<storage, read> prisms: array<Prism>;
@group(0) @binding(6) var<storage, read> columns: array<Column>;
@group(0) @binding(7) var<storage, read> lattice_extinction: array<u32>;
@group(0) @binding(8) var<storage, read_write> tau: array<u32>; // pairs of halves, see shared/tau

// Number of paths towards lights that reached the last step of `march_out`.
@group(0) @binding(9) var<storage, read_write> light_counters: array<atomic<u32>>;

#import shared/constants
#import shared/frame
#import shared/index
#import shared/octahedral
#import shared/undercoat
#import shared/shell
#import shared/lattice
#import shared/column
#import shared/column_place
#import shared/lights
#import shared/tau
#import shared/transmittance

// Extinction by undercoat and guard hairs at a place towards w, 1/cm. It is read from the lattice,
// not from the finer volume, as the optical depths are stored no finer either.
fn fur_extinction(place: ptr<function, Place>, w: vec3f) -> f32 {
    let cell = lattice_cell(place);
    var sum = vec2f(0.0);
    for (var k = 0u; k < 3u; k++) {
        let node = node_index(cell.columns[k], cell.level);
        sum += cell.weights[k] * mix(unpack2x16float(lattice_extinction[node]),
            unpack2x16float(lattice_extinction[node + 1u]), cell.fraction);
    }
    let normal = extrusion_direction(place, (*place).lambda);
    let tangent = mean_tangent(normal, min((*place).t, 1.0));
    return sum.x * relative_projection(tangent, w) + sum.y * FRAC_PI_4; // the mean sine
}

// Largest number of steps of `march_out`; paths that need more are counted.
const OUT_LIMIT: u32 = 200u;

// Optical depth from x, which lies at `start`, towards w, marched to the end of the medium.
fn march_out(start: ptr<function, Place>, x: vec3f, w: vec3f) -> f32 {
    var place = *start;
    var sum = 0.0;
    var step = 0.5 * fur.undercoat.light_step;
    var distance = 0.0;
    for (var i = 0u; i < OUT_LIMIT; i++) {
        let state = locate(&place, x + (distance + 0.5 * step) * w, w, 2u);
        if state != INSIDE || place.t > fur.lattice.reach {
            break;
        }
        if place.t < -0.02 {
            return TAU_BLOCKED;
        }
        sum += fur_extinction(&place, w) * step;
        if sum >= TAU_BLOCKED {
            return TAU_BLOCKED;
        }
        if i + 1u == OUT_LIMIT {
            atomicAdd(&light_counters[0], 1u);
        }
        distance += step;
        step = min(fur.undercoat.light_step, step * 1.5);
    }
    return sum;
}

// Optical depth at a place on or above the level that was swept before.
fn known_tau(place: ptr<function, Place>, light: u32) -> f32 {
    (*place).t = max((*place).t, level_height(sweep.level + 1u));
    return cell_tau(lattice_cell(place), light);
}

// Longest distance to the next level that is crossed in two steps, in units of the light step.
const CLIMB_LIMIT: f32 = 6.0;

// Height change per path length, both in cm, below which a descending ray counts as blocked.
const STEEP: f32 = -0.5;

// Optical depth from x, which lies at `start`, towards w. `behind`: whether the skin blocks the
// light outside the shell.
fn optical_depth(start: ptr<function, Place>, x: vec3f, w: vec3f, light: u32, behind: bool) -> f32 {
    var place = *start;
    solve(&place, x, w, 0u);
    let slope = place.dt_dz;
    if sweep.level == fur.lattice.levels {
        if slope > 0.0 {
            return select(0.0, TAU_BLOCKED, behind);
        }
    } else {
        let distance = (level_height(sweep.level + 1u) - place.t) / slope;
        if slope > 0.0 && distance < CLIMB_LIMIT * fur.undercoat.light_step {
            var sum = 0.0;
            var state = INSIDE;
            for (var part = 0u; part < 2u; part++) {
                state = locate(&place, x + distance * (0.25 + 0.5 * f32(part)) * w, w, 1u);
                if state != INSIDE {
                    return select(sum, TAU_BLOCKED, behind);
                }
                sum += fur_extinction(&place, w) * distance * 0.5;
            }
            state = locate(&place, x + distance * w, w, 1u);
            if state != INSIDE {
                return select(sum, TAU_BLOCKED, behind);
            }
            return min(TAU_BLOCKED, sum + known_tau(&place, light));
        }
    }
    // A steeply descending ray would leave the fur again only through the thinnest limb.
    if slope * fur.undercoat.height < STEEP {
        return TAU_BLOCKED;
    }
    place = *start;
    return select(march_out(&place, x, w), TAU_BLOCKED, behind);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    let pairs = tau_pairs();
    if i >= fur.lattice.columns * pairs {
        return;
    }
    // Consecutive invocations march towards the same lights.
    let column = i % fur.lattice.columns;
    let pair = i / fur.lattice.columns;
    var place: Place;
    let x = enter_node(&place, column, sweep.level);
    var values = vec2f(0.0);
    for (var k = 0u; k < 2u; k++) {
        let j = 2u * pair + k;
        if j < fur.lights.count {
            let behind = (columns[column].blocked[blocked_word(j)] & blocked_bit(j)) != 0u;
            values[k] = optical_depth(&place, x, lights.lights[j].direction, j, behind);
        } else if j == fur.lights.count {
            values[k] = optical_depth(&place, x, to_eye(x), j, false);
        }
    }
    tau[node_index(column, sweep.level) * fur.lattice.tau_stride + pair] = pack2x16float(values);
}
