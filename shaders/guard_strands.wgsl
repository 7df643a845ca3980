// Step 3: guard hairs as tessellated cubic Bezier curves. [Andersen2016] sec. 2 names Bezier
// shaping, gravity and grooming by textures; the formulas are ours.
// In: `roots`, `groom`, `maps_and_tables`. Out: `strand_vertices` (shared/strands),
// `groom.segments + 1` per strand, in cm.

@group(0) @binding(1) var<uniform> strand_batch: StrandBatch;
@group(0) @binding(2) var<uniform> groom: Groom;
@group(0) @binding(3) var<storage, read> maps_and_tables: array<vec2u>;
@group(0) @binding(4) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(5) var<storage, read> prisms: array<Prism>;
@group(0) @binding(6) var<storage, read> corner_uv: array<vec2f>;
@group(0) @binding(7) var<storage, read> roots: array<Root>;
@group(0) @binding(8) var<storage, read_write> strand_vertices: array<vec4f>; // see shared/strands

#import shared/constants
#import shared/index
#import shared/random
#import shared/shell_types
#import shared/groom
#import shared/roots
#import shared/strands
#import shared/strand_curve

// Vector from p to the nearest clump centre, of which there are so many 1/cm2; a jittered grid has
// one in each cell. [Worley1996]
fn to_clump(p: vec3f, clump_density: f32) -> vec3f {
    let size = inverseSqrt(max(clump_density, 1e-6));
    let cell = vec3i(floor(p / size));
    var best = vec3f(0.0);
    var least = 1e30;
    for (var i = 0; i < 27; i++) {
        let c = cell + vec3i(i % 3, (i / 3) % 3, i / 9) - 1;
        let h = hash2(hash2(bitcast<u32>(c.x), bitcast<u32>(c.y)), bitcast<u32>(c.z) ^ groom.seed);
        let offset = (vec3f(c) + random3(h, 0u)) * size - p;
        let distance = dot(offset, offset);
        if distance < least {
            least = distance;
            best = offset;
        }
    }
    return best;
}

// Diameter at s (0 root, 1 tip), cm, interpolated between root, widest place and tip; smooth at the
// widest place.
fn diameter(hairs: GuardHairs, s: f32) -> f32 {
    if s < hairs.widest {
        let x = s / max(hairs.widest, 1e-3);
        return mix(hairs.diameter.x, hairs.diameter.y, x * x * (3.0 - 2.0 * x));
    }
    let x = (s - hairs.widest) / max(1.0 - hairs.widest, 1e-3);
    return mix(hairs.diameter.y, hairs.diameter.z, x * x);
}

// Pull of one coat's tips towards clump centres.
fn coat_pull(coat: u32, at: SkinPoint) -> vec3f {
    let clump = coat_scalar(coat, GUARD_CLUMP, at);
    if clump <= 0.0 {
        return vec3f(0.0);
    }
    let offset = to_clump(at.position - groom.origin, groom.coats[coat].hairs.clump_density);
    return clump * (offset - at.normal * dot(at.normal, offset));
}

// Pull of the tips towards clump centres, cm.
fn clump_pull(at: SkinPoint) -> vec3f {
    var pull = coat_pull(0u, at);
    for (var coat = 1u; coat < COATS; coat++) {
        let share = hair_share(coat, at);
        if share > 0.0 {
            pull = over3(pull, coat_pull(coat, at), share);
        }
    }
    return pull;
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= strand_batch.strands {
        return;
    }
    let root = roots[i];
    let seed = root.seed;
    let at = skin_point(root.prism, root_lambda(root));
    let n = at.normal;
    let sides = sides_of(n);
    let side = sides.side;
    let other = sides.other;

    let hairs = hairs_at(at);
    let length_cm = scalar(GUARD_LENGTH, at) * (1.0 - hairs.length_variation * random(seed, 0u));
    // The random lean is normally distributed along both tangential axes. [BoxMuller1958]
    let spread = hairs.spread * sqrt(-2.0 * log(1.0 - random(seed, 1u)));
    let phi = TAU * random(seed, 2u);
    let lean = combed_lean(at, n) + spread * side_at(sides, phi);
    let leg = length_cm / 3.0;
    let legs = leg_directions(n, lean, hairs.gravity);
    let polygon = control_polygon(n, legs[0] * leg, legs[1] * leg, legs[2] * leg);

    let pull = clump_pull(at);
    let curl = scalar(GUARD_CURL, at);
    let frizz = scalar(GUARD_FRIZZ, at);
    let curl_phase = TAU * random(seed, 3u);
    let frizz_phase = TAU * random2(seed, 4u);
    let thickness = scalar(GUARD_THICKNESS, at);
    let segments = groom.segments;
    for (var k = 0u; k <= segments; k++) {
        let s = f32(k) / f32(segments);
        var p = bezier(polygon, s);
        p += pull * s * s;
        let turn = curl_phase + TAU * hairs.curl_frequency * length_cm * s;
        p += curl * s * ((cos(turn) - cos(curl_phase)) * side + (sin(turn) - sin(curl_phase)) * other);
        let wave = frizz_phase + TAU * hairs.frizz_frequency * length_cm * s * vec2f(1.0, 1.37);
        p += frizz * s * (sin(wave.x) * side + sin(wave.y) * other);
        let opacity = hairs.opacity * exp(-hairs.tip_fade * s);
        let radius = 0.5 * thickness * diameter(hairs, s);
        strand_vertices[i * (segments + 1u) + k] = pack_strand_vertex(at.position + p, radius, opacity);
    }
}
