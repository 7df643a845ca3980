// The undercoat's structure: clumps, uneven height, spread of the tangents, from simplex noise.
// Needs: fur (uniform Fur), noise (uniform Noise); shared/random, shared/noise, shared/undercoat.

fn field(p: vec3f, frequency: f32) -> f32 {
    if fur.noise_domain == 1u {
        return simplex2(p.xy * frequency);
    }
    return simplex3(p * frequency);
}

// Medium of a subelement. `p` is the noise domain's point below it (skin position in cm, or uv), `t` its height,
// `normal` the interpolated normal, `id` its stable number.
// The lookup's random displacement and the tangents' spread grow towards the top, clumps are cones, as
// [Andersen2016] sec. 3.2 says in words; the formulas are ours.
fn evaluate_medium(p: vec3f, normal: vec3f, t: f32, id: u32) -> Medium {
    let h = hash2(id, fur.seed);
    let growth = pow(t, fur.jitter_exponent);
    let jittered = p + fur.uv_jitter * growth * (2.0 * vec3f(random(h, 0u), random(h, 1u), random(h, 2u)) - 1.0)
        - fur.lean * (fur.height * t);
    // Hairs end at their own heights: the clumps' cones.
    let top = 1.0 - fur.height_variation * (0.5 + 0.5 * field(p - fur.lean * (fur.height * t) + 17.3, fur.height_frequency));
    let alive = 1.0 - smoothstep(top - 0.18, top + 0.02, t);
    let clump = 1.0 + fur.noise_contrast * (0.35 + 0.65 * t) * field(jittered, fur.noise_frequency);
    let turn = fur.tangent_jitter * growth * random_direction(h, 3u);
    let density = max(0.0, clump) * alive * mix(1.0, fur.diameter_ratio, t);
    return Medium(density, normalize(normal + fur.lean * t + turn));
}
