// The groom of the guard hairs, and the parameters that maps may vary.

struct Parameter {
    value: vec4f,     // the constant, or the factor on the texel
    source: u32,      // 0 constant, 1 vertex colour, 2 image by uv, 3 image triplanar
    texel_base: u32,
    size: vec2u,
    offset: f32,
    channel: u32,     // of a scalar
    padding: vec2u,
}

struct Groom {
    parameters: array<Parameter, 16>,
    comb_direction: vec3f,
    segments: u32,
    diameter: vec3f,        // root, widest place, tip; cm
    widest: f32,            // place of the widest diameter, 0 root, 1 tip
    color_transition: vec2f, // from root to tip colour: middle and width
    color_variation: f32,
    length_variation: f32,
    gravity: f32,
    spread: f32,            // tangent of the standard deviation
    clump_density: f32,     // 1/cm2
    curl_frequency: f32,    // 1/cm
    frizz_frequency: f32,   // 1/cm
    opacity: f32,
    tip_fade: f32,
    seed: u32,
    root_darkening: vec2f,  // strength, length of the decay relative to the strand
    paper: u32,             // 1: local shading as in [Andersen2016]
    padding: u32,
    origin: vec3f,          // of clumps and of maps without uv: the mesh's translation, cm
    more_padding: u32,
}
