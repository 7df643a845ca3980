// Length of a ray's first step, in steps. It differs between samples, which avoids rings of equal
// march depth: interleaved gradient noise spreads the phases evenly over neighbouring samples. It
// depends only on the sample's position in the film, the pass and the seed. [Jimenez2014]
// Needs: shared/frame.

fn first_phase(xy: vec2u) -> f32 {
    if (frame.flags & FLAG_MARCH_JITTER) == 0u {
        return 1.0;
    }
    let p = vec2f(frame.tile_origin + vec2i(xy) + 4096);
    let gradient = dot(p, vec2f(0.06711056, 0.00583715)) + f32(frame.seed & 1023u) * 0.618034;
    return 0.05 + 0.95 * fract(52.982919 * fract(gradient));
}
