// Points of the skin, by a triangle's vertices and barycentric coordinates.
// Needs: shell_vertices (array<ShellVertex>).

#import shared/barycentric
#import shared/shell_types

// Position, world, cm.
fn skin_position(vertices: vec3u, lambda: vec3f) -> vec3f {
    return interpolate3(lambda, shell_vertices[vertices.x].position, shell_vertices[vertices.y].position,
        shell_vertices[vertices.z].position);
}

// Smoothed unit normal.
fn skin_normal(vertices: vec3u, lambda: vec3f) -> vec3f {
    return normalize(interpolate3(lambda, shell_vertices[vertices.x].normal, shell_vertices[vertices.y].normal,
        shell_vertices[vertices.z].normal));
}
