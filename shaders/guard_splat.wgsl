// Step 2: extinction at the nodes of the optical-depth lattice. `deposit` adds length times
// diameter of the guard hairs in fixed point, so that the order of additions does not matter;
// `normalise` divides by the nodes' volumes and adds the undercoat.
// In: `roots`, `strand_vertices` (cm), `columns`. Out: `deposits` in fixed point (cm2),
// `lattice_extinction` in 1/cm.

@group(0) @binding(1) var<uniform> strand_batch: StrandBatch;
@group(0) @binding(2) var<uniform> fur: FurParameters;
@group(0) @binding(3) var<uniform> groom: Groom;
@group(0) @binding(4) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(5) var<storage, read> prisms: array<Prism>;
@group(0) @binding(6) var<storage, read> roots: array<Root>;
@group(0) @binding(7) var<storage, read> strand_vertices: array<vec4f>;
@group(0) @binding(8) var<storage, read_write> deposits: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read> columns: array<Column>;
// Projected extinction (perpendicular to the hairs) of undercoat and guard hairs, 1/cm, two halves.
@group(0) @binding(10) var<storage, read_write> lattice_extinction: array<u32>;
@group(0) @binding(11) var<uniform> noise: Noise;
@group(0) @binding(12) var<storage, read> corner_uv: array<vec2f>;

#import shared/index
#import shared/random
#import shared/noise
#import shared/octahedral
#import shared/undercoat
#import shared/clumps
#import shared/shell
#import shared/uv_in_corners
#import shared/noise_domain
#import shared/lattice
#import shared/column
#import shared/column_place
#import shared/groom_types
#import shared/root_types
#import shared/strands

const FIXED_POINT: f32 = 4194304.0; // units per cm2
const LARGEST_HALF: f32 = 65504.0;  // largest finite number of 16 bits
const PARTS: u32 = 2u;              // deposits per segment

@compute @workgroup_size(64)
fn deposit(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= strand_batch.strands {
        return;
    }
    let first = i * (groom.segments + 1u);
    var place: Place;
    enter_prism(&place, roots[i].prism);
    place.t = 0.0;
    for (var k = 0u; k < groom.segments; k++) {
        let a = strand_vertices[first + k];
        let b = strand_vertices[first + k + 1u];
        let d = b.xyz - a.xyz;
        let amount = length(d) * (strand_radius(a) + strand_radius(b)) / f32(PARTS);
        for (var part = 0u; part < PARTS; part++) {
            let x = a.xyz + d * ((f32(part) + 0.5) / f32(PARTS));
            if locate(&place, x, d, 3u) != INSIDE {
                return;
            }
            let cell = lattice_cell(&place);
            for (var c = 0u; c < 3u; c++) {
                let node = node_index(cell.columns[c], cell.level);
                let share = amount * cell.weights[c] * FIXED_POINT;
                atomicAdd(&deposits[node], u32(share * (1.0 - cell.fraction) + 0.5));
                atomicAdd(&deposits[node + 1u], u32(share * cell.fraction + 0.5));
            }
        }
    }
}

@compute @workgroup_size(64)
fn normalise(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let i = linear_index(id, groups);
    if i >= node_count() {
        return;
    }
    let column = column_of_node(i);
    let level = level_of_node(i);
    var place: Place;
    enter_node(&place, column, level);
    let t = place.t;
    let flat = cross(place.e1, place.e2);
    let raised = layer_at(&place, t).n;
    let spread = clamp(length(raised) / max(length(flat), 1e-20), 0.3, 4.0);
    // The first and the last node of a column represent half a cell.
    let cells = select(1.0, 0.5, level == 0u || level == fur.lattice.levels);
    let volume = columns[column].area * spread * length(extrusion(&place)) * fur.lattice.reach / f32(fur.lattice.levels) * cells;
    let guard = f32(atomicLoad(&deposits[i])) / FIXED_POINT / max(volume, 1e-9);
    var undercoat = 0.0;
    if t <= 1.0 && fur.undercoat.extinction > 0.0 {
        let p = noise_point(&place, place.lambda);
        let tangent = mean_tangent(extrusion_direction(&place, place.lambda), t);
        undercoat = fur.undercoat.extinction * columns[column].density * clump_density(p, p, t) * crowding(&place, t, tangent);
    }
    // Where the shell has hardly any height, nodes have hardly any volume. An infinite extinction
    // times a path of no length would not be a number, and the skin there would be black.
    lattice_extinction[i] = pack2x16float(min(vec2f(undercoat, guard), vec2f(LARGEST_HALF)));
}
