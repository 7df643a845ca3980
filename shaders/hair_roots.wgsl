// Step 1: roots of the guard hairs with a density map, [VanGelderWilhelms1997], [Andersen2016]
// sec. 3. Number and positions of a triangle's roots are drawn from its id, so that the result
// does not depend on the order of threads.
// Triangles with many candidates are divided into parts, one invocation each, because adapters end
// long loops.
// In: `root_range`, skin triangles, density map (1/cm2). Out: `root_counts` by `count`, `roots` by
// `emit`.

struct RootRange {
    first: u32,      // first part
    count: u32,      // number of parts
    density: f32,    // largest density, 1/cm2
    seed: u32,
    parts: u32,      // of each triangle
    padding: u32,
    more_padding: vec2u,
}

// Candidates of a part. Each part draws places and thinning from a seed of its own: so the indices
// of random numbers stay below those of the roots' seeds, and the multiples of the sequence of
// places remain precise.
const PART: u32 = 16384u;

@group(0) @binding(1) var<uniform> root_range: RootRange;
@group(0) @binding(2) var<uniform> groom: Groom;
@group(0) @binding(3) var<storage, read> maps_and_tables: array<vec2u>;
@group(0) @binding(4) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(5) var<storage, read> prisms: array<Prism>;
@group(0) @binding(6) var<storage, read> corner_uv: array<vec2f>;
@group(0) @binding(7) var<storage, read_write> root_counts: array<u32>;
@group(0) @binding(8) var<storage, read> first_roots: array<u32>; // of each part, in `roots`
@group(0) @binding(9) var<storage, read_write> roots: array<Root>;

#import shared/index
#import shared/random
#import shared/shell_types
#import shared/groom
#import shared/roots

// Number of candidates of a triangle: floor(x), and one more with the probability of the remainder,
// so that the mean is x = area times density.
fn candidates(prism: u32) -> u32 {
    let v = prisms[prism].vertices;
    let p0 = shell_vertices[v.x].position;
    let area = 0.5 * length(cross(shell_vertices[v.y].position - p0, shell_vertices[v.z].position - p0));
    return u32(area * root_range.density + random(hash2(root_range.seed, prism), 0u));
}

// Seed of the part of the k-th candidate.
fn part_seed(prism: u32, k: u32) -> u32 {
    let seed = hash2(root_range.seed, prism);
    let part = k / PART;
    return select(hash2(~seed, part), seed, part == 0u);
}

// Barycentric coordinates of the k-th candidate: a quasirandom sequence with a random start spreads
// the roots evenly over the triangle. [Roberts2018]
fn candidate(prism: u32, k: u32) -> vec3f {
    let u = r2_point(random2(part_seed(prism, k), 1u), k % PART);
    let r = sqrt(u.x); // [Turk1990]
    return vec3f(1.0 - r, r * (1.0 - u.y), r * u.y);
}

// Whether a candidate survives the thinning by the density map.
fn grows(prism: u32, k: u32, lambda: vec3f) -> bool {
    let wanted = scalar(GUARD_DENSITY, skin_point(prism, lambda));
    return random(part_seed(prism, k), 3u + k % PART) * root_range.density < wanted;
}

@compute @workgroup_size(64)
fn count(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= root_range.count {
        return;
    }
    let prism = (root_range.first + i) / root_range.parts;
    let part = (root_range.first + i) % root_range.parts;
    let end = min(candidates(prism), (part + 1u) * PART);
    var grown = 0u;
    for (var k = part * PART; k < end; k++) {
        grown += u32(grows(prism, k, candidate(prism, k)));
    }
    root_counts[i] = grown;
}

@compute @workgroup_size(64)
fn emit(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= root_range.count {
        return;
    }
    let prism = (root_range.first + i) / root_range.parts;
    let part = (root_range.first + i) % root_range.parts;
    let end = min(candidates(prism), (part + 1u) * PART);
    var at = first_roots[i];
    for (var k = part * PART; k < end; k++) {
        let lambda = candidate(prism, k);
        if grows(prism, k, lambda) {
            // A root's seed differs from those of all others of its triangle.
            roots[at] = Root(prism, hash2(hash2(root_range.seed, prism), 0x10000u + k), lambda.yz);
            at++;
        }
    }
}
