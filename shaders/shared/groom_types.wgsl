// The coats of the scene and of its parts, and the parameters that maps may vary.

struct Parameter {
    value: vec4f,     // the constant, or the factor on the texel
    source: u32,      // 0 constant, 1 vertex colour, 2 image by uv, 3 image triplanar, 4 as below
    texel_base: u32,
    size: vec2u,
    offset: f32,
    channel: u32,     // of a scalar
    padding: vec2u,
}

struct GuardHairs {
    comb_direction: vec3f,
    widest: f32,            // place of the widest diameter, 0 root, 1 tip
    diameter: vec3f,        // root, widest place, tip; cm
    spread: f32,            // tangent of the standard deviation
    color_transition: vec2f, // from root to tip colour: middle and width
    color_variation: f32,
    length_variation: f32,
    gravity: f32,
    clump_density: f32,     // 1/cm2
    curl_frequency: f32,    // 1/cm
    frizz_frequency: f32,   // 1/cm
    root_darkening: vec2f,  // strength, length of the decay relative to the strand
    opacity: f32,
    tip_fade: f32,
}

struct Coat {
    parameters: array<Parameter, 17>,
    hairs: GuardHairs,
    lane: u32,              // half of a coverage row; 0xffffffff: the part chooses no region of the mesh
    bare: u32,              // 1: bare skin, without hairs of its own
    padding: vec2u,
}

struct Groom {
    segments: u32,
    seed: u32,
    paper: u32,             // 1: local shading as in [Andersen2016]
    coverage_base: u32,     // first texel of the coverage rows: three per triangle, one per vertex
    coverage_texels: u32,   // of a row
    vertex_rows: u32,       // row of the first vertex
    count: u32,             // of coats, at least 1
    padding: u32,
    origin: vec3f,          // of clumps and of maps without uv: the mesh's translation, cm
    more_padding: u32,
    coats: array<Coat, 16>, // the scene's own, then those of its parts; later ones lie above
}
