// A hair root.

struct Root {
    prism: u32,
    seed: u32,
    lambda: vec2f, // barycentric at corners 1 and 2
}
