// The ray march through the undercoat, [Andersen2016] sec. 3.2: enters at an entry fragment, takes
// steps of fixed length, hops by the neighbour table. Depth z is the ray parameter (cm along the
// view axis).
// Needs: node_light (array<vec4u>), fur (uniform FurParameters), march_counters
// (array<atomic<u32>>); shared/march_counters, shared/volume, shared/lattice,
// shared/undercoat_fibre, shared/frame.

#import shared/halves
#import shared/transmittance
#import shared/features

struct March {
    marching: bool,   // inside the shell
    last: bool,       // the current step ends where the ray leaves the shell
    z: f32,           // depth up to which the ray has been marched
    z_end: f32,       // depth at which the current step ends
    dz: f32,          // length of the next step, cm of depth
    speed: f32,       // path length (cm) per cm of depth
    sigma: f32,       // extinction of the current step per cm of depth
    radiance: vec3f,  // source radiance of the current step
    albedo: vec3f,    // with FEATURES: that of its hairs
    tangent: vec3f,   // with FEATURES: their direction
    ray: vec3f,
    view: vec3f,      // unit, towards the camera
    lost: u32,        // number of steps whose prism was not found
}

// Number of steps that a ray may take without finding its prism: where the shell folds, prisms
// overlap and hops run in circles.
const LOST_LIMIT: u32 = 64u;

fn begin_ray(m: ptr<function, March>, ray: vec3f) {
    (*m).marching = false;
    (*m).ray = ray;
    (*m).speed = length(ray);
    (*m).view = -ray / (*m).speed;
    (*m).dz = fur.undercoat.step / (*m).speed;
    (*m).lost = 0u;
}

// Enters the prism shell through prism `index` at depth z; `phase` in (0, 1]: length of the first
// step, in steps.
fn enter_shell(m: ptr<function, March>, place: ptr<function, Place>, index: u32, z: f32, phase: f32) {
    (*place).prism = index;
    (*place).t = 1.0;
    (*m).marching = true;
    (*m).last = false;
    (*m).z = z;
    (*m).z_end = z;
    (*m).dz = fur.undercoat.step / (*m).speed * phase;
}

// Whether optical depths towards key lights are found by a nested march at every step, as in
// [Andersen2016] sec. 3.2, instead of by lookup in the lattice; for comparison. The nested march
// ignores guard hairs.
override NESTED: bool = false;

// Largest number of steps of the nested march; paths that need more are counted.
const NESTED_LIMIT: u32 = 400u;

// Optical depth of the undercoat from x, which lies at `start`, towards l.
fn nested_tau(start: ptr<function, Place>, x: vec3f, l: vec3f) -> f32 {
    var place = *start;
    var sum = 0.0;
    for (var i = 0u; i < NESTED_LIMIT; i++) {
        let state = locate(&place, x + (f32(i) + 0.5) * fur.undercoat.step * l, l, 2u);
        if state != INSIDE || place.t > 1.0 || sum > TAU_BLOCKED {
            break;
        }
        if place.t < 0.0 {
            sum = TAU_BLOCKED;
            break;
        }
        sum += extinction(medium_at(&place), l) * fur.undercoat.step;
        if i + 1u == NESTED_LIMIT {
            atomicAdd(&march_counters[LIGHT_PATHS_CUT], 1u);
        }
    }
    return sum;
}

// In-scattered radiance towards `view` per extinction at a place, and the density factor there.
// `seen`: with FEATURES, receives the albedo.
fn source_radiance(place: ptr<function, Place>, m: Medium, x: vec3f, view: vec3f, seen: ptr<function, vec3f>) -> vec4f {
    let cell = lattice_cell(place);
    var ambient = vec4f(0.0);  // log2 of the radiance from all but the key lights; density factor
    var tau = vec2f(0.0);
    var albedo = vec3f(0.0);
    for (var k = 0u; k < 3u; k++) {
        let node = node_index(cell.columns[k], cell.level);
        let low = node_light[node];
        let high = node_light[node + 1u];
        let w = cell.weights[k] * vec2f(1.0 - cell.fraction, cell.fraction);
        ambient += w.x * unpack_half4(low.xy) + w.y * unpack_half4(high.xy);
        tau += w.x * unpack2x16float(low.z) + w.y * unpack2x16float(high.z);
        albedo += w.x * unpack_albedo(low.w) + w.y * unpack_albedo(high.w);
    }
    var sum = exp2(ambient.rgb);
    for (var j = 0u; j < fur.lights.keys; j++) {
        let l = fur.lights.key_direction[j].xyz;
        if NESTED {
            tau[j] = nested_tau(place, x, l) * ambient.a;
        }
        let through = light_through(tau[j], albedo);
        sum += fur.lights.key_irradiance[j].rgb * through * scatter_undercoat(m.tangent, l, view, albedo);
    }
    if FEATURES {
        *seen = albedo;
    }
    return vec4f(sum * undercoat_factor(albedo), ambient.a);
}

// Prepares the next step: its end and its medium. If the ray has left the shell, `marching` becomes
// false. A step that leaves through the top or into the skin ends there, whether its middle is
// inside or not.
fn next_step(m: ptr<function, March>, place: ptr<function, Place>) {
    let dz = (*m).dz;
    (*m).dz = fur.undercoat.step / (*m).speed;
    let z_mid = (*m).z + 0.5 * dz;
    let before = (*place).prism;
    let t_before = (*place).t;
    let x = frame.eye + z_mid * (*m).ray;
    let found = locate(place, x, (*m).ray, 2u);
    let t = (*place).t;
    let slope = (*place).dt_dz;
    let climbs = slope > 0.0;
    // Depth at which a climbing ray meets the top, or a descending one the skin.
    let z_out = z_mid + (select(0.0, 1.0, climbs) - t) / away_from_zero(slope, 1e-12);
    // A place above the top counts as inside while the ray descends: by rounding, the first step
    // may begin there.
    let near = select(t <= 1.0 + abs(slope) * dz, t >= 0.0, climbs) && (z_out > (*m).z || (t >= 0.0 && t <= 1.0));
    let inside = found == INSIDE && near && !(*m).last;
    (*m).lost += u32(found == LOST && !(*m).last);
    (*m).marching = inside;
    // The skin cuts a step whose middle lies above it.
    (*m).last = select(t < 0.0, z_out < (*m).z + dz, climbs);
    (*m).z_end = select((*m).z + dz, z_out, (*m).last);
    (*place).t = clamp(t, 0.0, 1.0);
    let medium = medium_at(place);
    var albedo = vec3f(0.0);
    let source_density = source_radiance(place, medium, x, (*m).view, &albedo);
    let lost = found == LOST && (*m).lost < LOST_LIMIT;
    let sigma = extinction(medium, (*m).view) * source_density.a * (*m).speed;
    // Lost: continue with the medium of the previous step.
    (*m).sigma = select(sigma, (*m).sigma, lost);
    (*m).radiance = select(source_density.rgb, (*m).radiance, lost);
    if FEATURES {
        (*m).albedo = select(albedo, (*m).albedo, lost);
        (*m).tangent = select(medium.tangent, (*m).tangent, lost);
    }
    if lost {
        (*m).marching = true;
        (*m).last = false;
        (*m).z_end = (*m).z + dz;
        (*place).prism = before;
        (*place).t = t_before;
    }
}
