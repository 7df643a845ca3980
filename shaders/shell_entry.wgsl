// Step 5: where view rays enter the prism shell, [Andersen2016] sec. 3.2: through the top faces,
// and through walls over the border of an open skin, without which its rim would be bald. The
// raster stage writes only which prism and how deep.
// In: `shell_vertices`, `prisms`, `border`, `base_records`. Out: entries in `fragment_lists` (depth
// in cm).

@group(0) @binding(1) var<storage, read> shell_vertices: array<ShellVertex>;
@group(0) @binding(2) var<storage, read> prisms: array<Prism>;
@group(0) @binding(3) var<storage, read> border: array<vec2u>; // triangle, corner opposite the edge
@group(0) @binding(4) var<storage, read> base_records: array<vec4u>;
@group(0) @binding(5) var<storage, read_write> fragment_lists: array<atomic<u32>>;

#import shared/frame
#import shared/shell_types
#import shared/oit
#import shared/oit_write
#import shared/arithmetic
#import shared/base

struct Varying {
    @builtin(position) clip: vec4f,
    @interpolate(flat) @location(0) prism: u32,
    // Normal of the face, and its dot product with the vector from the camera to a corner.
    @interpolate(flat) @location(1) plane: vec4f,
}

// The plane of a face as in `Varying`.
fn plane_of(a: vec3f, b: vec3f, c: vec3f) -> vec4f {
    let n = cross(b - a, c - a);
    return vec4f(n, dot(n, a - frame.eye));
}

// Point of the shell's top above a vertex.
fn raised(vertex: u32) -> vec3f {
    return shell_vertices[vertex].position + shell_vertices[vertex].height * shell_vertices[vertex].normal;
}

@vertex
fn top(@builtin(vertex_index) i: u32) -> Varying {
    let prism = i / 3u;
    let v = prisms[prism].vertices;
    return Varying(clip_from_world(raised(v[i % 3u])), prism, plane_of(raised(v.x), raised(v.y), raised(v.z)));
}

// The wall over a border edge: two triangles facing outwards.
@vertex
fn wall(@builtin(vertex_index) i: u32) -> Varying {
    let edge = border[i / 6u];
    let v = prisms[edge.x].vertices;
    let a = v[(edge.y + 1u) % 3u];
    let b = v[(edge.y + 2u) % 3u];
    var p = array<vec3f, 3>(shell_vertices[a].position, shell_vertices[b].position, raised(b));
    if i % 6u >= 3u {
        p = array<vec3f, 3>(shell_vertices[a].position, raised(b), raised(a));
    }
    return Varying(clip_from_world(p[i % 3u]), edge.x, plane_of(p[0], p[1], p[2]));
}

@fragment
fn fragment(in: Varying) {
    let xy = vec2u(in.clip.xy);
    let i = tile_index(xy);
    // Depth from the plane itself: the rasteriser's interpolation depends on the tile.
    let along = dot(sample_ray(xy), in.plane.xyz);
    let z = in.plane.w / away_from_zero(along, -1e-20);
    if z > frame.near && z < base_depth(base_records[i]) {
        add_fragment(i, z, fragment_source(KIND_ENTRY, in.prism), vec4f(0.0));
    }
}
