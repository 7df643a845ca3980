// What the prism shell is made of.

#import shared/constants

struct ShellVertex {
    position: vec3f,  // on the skin, world, cm
    height: f32,      // of the undercoat's shell, cm
    normal: vec3f,    // smoothed, unit
    color: u32,       // vertex colour, 8 bits a channel
}

struct Prism {
    vertices: vec3u,
    cell_base: u32,    // index of the first subelement
    neighbours: vec3u, // over the edge opposite each corner, or NONE
    subdivision: u32,  // level d of this prism
    edges: vec3u,      // numbers of the edges opposite each corner, the same for both triangles at an edge
    padding: u32,
}
