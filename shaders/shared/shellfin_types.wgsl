// Shells and fins: parameters, and the rows of vertices above the skin.

#import shared/constants

struct Shellfin {
    comb: vec3f,             // over the whole skin, tangent of the lean, world
    shells: u32,             // rows that are textured shells; the fins' rows follow
    bend: vec3f,             // displacement of the tips by forces, by height, world
    fin_rows: u32,           // rows of a fin, skin and tip included
    shadow_direction: vec3f, // towards the light of the shadow between hairs, world, unit
    lighting: u32,           // 0: scene, 1: table
    torus: vec2f,            // edges of the layers' torus, cm
    fin_length: f32,         // one repeat of the fin, cm
    height: f32,             // of the row at height 1, cm above the skin
    fade: u32,               // 0: cosine, 1: threshold, 2: both
    fin_threshold: f32,
    slanted: u32,            // 1: coverage grows with the path length through a layer
    shadow_offset: f32,      // part of the torus
    shadow_strength: f32,
    vertices: u32,           // of the skin
    brushes: u32,
    curved: u32,             // 1: along the groom's mean strand, 0: straight
    spread: f32,             // tangent of the guard hairs' random lean
    guard: u32,              // 1: guard hairs have separate layers
    edge_fade: f32,          // 1: textured shells fade where they are seen edge-on
    first_corner: u32,       // of the textured shells
}

struct ShellRow {
    height: f32,     // 0 at the skin, 1 at the top of the textures
    fine: u32,       // layer of the texture
    coarse: u32,     // of the next level of detail, or NONE
    blend: f32,      // 0 fine, 1 coarse
    undercoat: vec3f, // mean colour of the layer
    shade: f32,      // darkening towards the skin, for the table
    guard: vec3f,    // mean colour of its guard hairs
    jitter: f32,     // variance of the other hairs' directions about their mean, per axis
    coverage: f32,   // mean of the layer
    share: f32,      // part of it that is guard hair
    padding: vec2u,
}
