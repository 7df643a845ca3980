// Hair roots. Needs: shell_vertices, prisms, corner_uv; shared/random, shared/shell's types, shared/groom.

#import shared/root_types

fn skin_point(prism: u32, lambda: vec3f) -> SkinPoint {
    let p = prisms[prism].vertices;
    let a = shell_vertices[p.x];
    let b = shell_vertices[p.y];
    let c = shell_vertices[p.z];
    let uv = lambda.x * corner_uv[3u * prism] + lambda.y * corner_uv[3u * prism + 1u] + lambda.z * corner_uv[3u * prism + 2u];
    let rgb = lambda.x * unpack4x8unorm(a.color) + lambda.y * unpack4x8unorm(b.color) + lambda.z * unpack4x8unorm(c.color);
    return SkinPoint(lambda.x * a.position + lambda.y * b.position + lambda.z * c.position,
        normalize(lambda.x * a.normal + lambda.y * b.normal + lambda.z * c.normal), uv, rgb.rgb);
}
