// Attributes of the skin at a point of a triangle.
// Needs: shell_vertices, prisms, corner_uv; shared/groom.

#import shared/root_types
#import shared/skin

fn skin_point(prism: u32, lambda: vec3f) -> SkinPoint {
    let v = prisms[prism].vertices;
    let corner = 3u * prism;
    let uv = interpolate2(lambda, corner_uv[corner], corner_uv[corner + 1u], corner_uv[corner + 2u]);
    let color = interpolate4(lambda, unpack4x8unorm(shell_vertices[v.x].color),
        unpack4x8unorm(shell_vertices[v.y].color), unpack4x8unorm(shell_vertices[v.z].color));
    return SkinPoint(skin_position(v, lambda), skin_normal(v, lambda), uv, color,
        vec3u(corner, corner + 1u, corner + 2u), lambda);
}
