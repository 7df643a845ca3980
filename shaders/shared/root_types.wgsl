// Roots of guard hairs.

#import shared/barycentric

struct Root {
    prism: u32,
    seed: u32,
    lambda: vec2f, // barycentric at corners 1 and 2
}

fn root_lambda(root: Root) -> vec3f {
    return barycentric(root.lambda);
}

// The strands that a dispatch processes: the first `strands` of `roots`.
struct StrandBatch {
    strands: u32,
}
