// Attributes of the skin at a point of a triangle.
// Needs: shell_vertices, prisms, corner_uv; shared/groom.

#import shared/root_types
#import shared/skin

fn skin_point(prism: u32, lambda: vec3f) -> SkinPoint {
    let v = prisms[prism].vertices;
    let corner = 3u * prism;
    let uv = interpolate2(lambda, corner_uv[corner], corner_uv[corner + 1u], corner_uv[corner + 2u]);
    let rgb = interpolate3(lambda, unpack4x8unorm(shell_vertices[v.x].color).rgb,
        unpack4x8unorm(shell_vertices[v.y].color).rgb, unpack4x8unorm(shell_vertices[v.z].color).rgb);
    return SkinPoint(skin_position(v, lambda), skin_normal(v, lambda), uv, rgb,
        vec3u(corner, corner + 1u, corner + 2u), lambda);
}
