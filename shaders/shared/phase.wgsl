// Length of a ray's first step in steps: against rings of equal march depth each sample starts elsewhere. Interleaved gradient
// noise spreads the phases evenly over neighbouring samples; it depends on the sample's place alone. [Jimenez2014]

fn first_phase(xy: vec2u) -> f32 {
    if (frame.flags & FLAG_MARCH_JITTER) == 0u {
        return 1.0;
    }
    let p = vec2f(frame.tile_origin + vec2i(xy) + 4096);
    return 0.05 + 0.95 * fract(52.982919 * fract(dot(p, vec2f(0.06711056, 0.00583715)) + f32(frame.seed & 1023u) * 0.618034));
}
