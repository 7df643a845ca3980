// Parameters of the undercoat, of the optical-depth lattice and of the lights that shaders read as
// one uniform.

struct UndercoatParameters {
    layers: u32,
    noise_domain: u32,         // 0 object, 1 uv
    seed: u32,
    extinction: f32,           // largest density times root diameter, 1/cm
    diameter_ratio: f32,       // tip / root
    noise_frequency: f32,      // 1/cm
    noise_contrast: f32,
    height_variation: f32,
    height_frequency: f32,     // 1/cm
    uv_jitter: f32,            // cm
    tangent_jitter: f32,
    jitter_exponent: f32,
    step: f32,                 // of the march, cm
    light_step: f32,           // of the light march, cm
    height: f32,               // largest shell height, cm
    isotropic: u32,            // 1: extinction ignores the angle to the hairs, as in [Andersen2016]
    lean: vec3f,               // comb direction times tangent of the lean
    forward_scattering: f32,
    opacity_cut: f32,          // transmittance below which a ray ends
    virtual_fragments: u32,
    density: f32,              // largest density, 1/cm2
    attenuation: f32,          // a of [Andersen2016] eq. 4, 1/cm
    origin: vec3f,             // of the noise's domain: the mesh's translation, cm
    padding: u32,
}

// The optical-depth lattice.
struct LatticeParameters {
    cells: u32,                // along a triangle's edge
    levels: u32,               // cells from skin to top; levels + 1 nodes
    reach: f32,                // top of the lattice in shell heights
    columns: u32,
    vertices: u32,             // of the skin
    edges: u32,                // of the skin
    tau_stride: u32,           // words per node of the buffer `tau`
    padding: u32,
}

struct LightParameters {
    count: u32,                // of all lights
    keys: u32,                 // number of key lights, shaded one by one in the march
    key_lights: vec2u,         // their numbers among the lights
    key_direction: array<vec4f, 2>,
    key_irradiance: array<vec4f, 2>,
}

struct FurParameters {
    undercoat: UndercoatParameters,
    lattice: LatticeParameters,
    lights: LightParameters,
}
