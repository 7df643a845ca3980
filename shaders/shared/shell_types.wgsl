// Vertices and prisms of the prism shell.

#import shared/constants

struct ShellVertex {
    position: vec3f,  // on the skin, world, cm
    height: f32,      // of the prism shell above the vertex, cm
    normal: vec3f,    // smoothed, unit
    color: u32,       // vertex colour, 8 bits per channel
}

// A triangle of an object stands behind the prisms, as one whose other fields hold the uv of its
// corners: neighbours.xyz, subdivision, edges.xy.
struct Prism {
    vertices: vec3u,
    cell_base: u32,    // index of the first subelement
    neighbours: vec3u, // over the edge opposite each corner, or NONE
    subdivision: u32,  // level d of this prism
    edges: vec3u,      // numbers of the edges opposite each corner, shared by neighbours
    object: u32,       // 0 for a prism of the shell, else 1 + number of the object's material
}
