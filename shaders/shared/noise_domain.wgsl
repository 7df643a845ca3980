// Domain of the undercoat's noise: positions or uv. Needs: fur (uniform FurParameters),
// uv_of_corner; shared/shell.

#import shared/barycentric

// uv at barycentric coordinates of a skin triangle.
fn skin_uv(prism: u32, lambda: vec3f) -> vec2f {
    let corner = 3u * prism;
    return interpolate2(lambda, uv_of_corner(corner), uv_of_corner(corner + 1u), uv_of_corner(corner + 2u));
}

// The skin's point at barycentric coordinates of the place's prism, in the noise domain: its
// position relative to the mesh's translation (cm), so that the fur moves with the mesh, or its uv.
fn noise_point(place: ptr<function, Place>, lambda: vec3f) -> vec3f {
    var p = skin_at(place, lambda) - fur.undercoat.origin;
    if fur.undercoat.noise_domain == 1u {
        p = vec3f(skin_uv((*place).prism, lambda), 0.0);
    }
    return p;
}
