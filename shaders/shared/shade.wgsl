// Shaded vertices of the guard hairs: radiance and a mark, four halves; with FEATURES, followed by
// albedo (shared/record) and tangent (a packed direction).

#import shared/features

// Number of the first vector of a vertex in `shades`.
fn shade_word(vertex: u32) -> u32 {
    return vertex * select(1u, 2u, FEATURES);
}
