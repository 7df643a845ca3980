// Features: what a denoiser or a compositor wants to know of the surfaces in a sample besides their
// colour: albedo, normal, direction of the hairs, and the coverage of each layer.

// Whether they are made; fixed when a kernel is compiled, so that a picture without them costs
// nothing.
override FEATURES: bool = false;

// Normal of a hair as seen along the unit vector `view` (towards the camera): that of the ribbon
// that faces the camera. `view` itself where the hair is seen end-on.
fn hair_normal(tangent: vec3f, view: vec3f) -> vec3f {
    let n = view - tangent * dot(view, tangent);
    let square = dot(n, n);
    return select(view, n * inverseSqrt(max(square, 1e-12)), square > 1e-8);
}
