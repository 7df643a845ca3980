// Step 5: shell fragments, [Andersen2016] sec. 3.2: where rays enter the shell. The top faces, and the walls over the border of an
// open skin, without which its rim would be bald. The raster stage only writes which prism and how deep.

@group(0) @binding(1) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(2) var<storage, read> prisms: array<Prism>;
@group(0) @binding(3) var<storage, read> border: array<vec2u>;       // triangle and corner opposite the border edge
@group(0) @binding(4) var<storage, read> base_records: array<vec4u>;
@group(0) @binding(5) var<storage, read_write> fragment_lists: array<atomic<u32>>;

#import shared/frame
#import shared/shell_types
#import shared/oit
#import shared/oit_write

struct Varying {
    @builtin(position) clip: vec4f,
    @interpolate(flat) @location(0) prism: u32,
}

@vertex
fn top(@builtin(vertex_index) i: u32) -> Varying {
    let prism = i / 3u;
    let v = shell_vertices[prisms[prism].vertices[i % 3u]];
    return Varying(clip_from_world(v.position + v.height * v.normal), prism);
}

@vertex
fn wall(@builtin(vertex_index) i: u32) -> Varying {
    // Two triangles: skin a, skin b, top b; skin a, top b, top a. Seen from outside they turn like the skin's own edge reversed.
    let edge = border[i / 6u];
    let part = i % 6u;
    let second = part == 1u || part == 2u || part == 4u;
    let raised = part == 2u || part >= 4u;
    let corner = (edge.y + select(1u, 2u, second)) % 3u;
    let v = shell_vertices[prisms[edge.x].vertices[corner]];
    return Varying(clip_from_world(v.position + select(0.0, v.height, raised) * v.normal), edge.x);
}

@fragment
fn fragment(in: Varying) {
    let xy = vec2u(in.clip.xy);
    let i = xy.y * frame.tile_size.x + xy.x;
    let z = 1.0 / in.clip.w;
    if z < bitcast<f32>(base_records[i].x) {
        add_fragment(i, z, (KIND_ENTRY << KIND_SHIFT) | (in.prism & ID_MASK), vec4f(0.0));
    }
}
