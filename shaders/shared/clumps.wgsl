// The undercoat's structure: clumps, uneven height, spread of the tangents, from simplex noise.
// Needs: fur (uniform Fur), noise (uniform Noise); shared/random, shared/noise, shared/undercoat.

fn field(p: vec3f, frequency: f32) -> f32 {
    if fur.noise_domain == 1u {
        return simplex2(p.xy * frequency);
    }
    return simplex3(p * frequency);
}

// Locks of combed fur are longer than wide: the noise is stretched along the lean.
fn combed(p: vec3f) -> vec3f {
    let along = dot(fur.lean, fur.lean);
    return p - fur.lean * (dot(fur.lean, p) * 0.65 / max(along, 1e-12));
}

// Density relative to the mean: hairs end at their own heights, which makes cones of the clumps, and grow thinner. `p` is where the
// skin's point lies in the noise domain, `jittered` the same for the finer noise.
fn clump_density(p: vec3f, jittered: vec3f, t: f32) -> f32 {
    let lean = fur.lean * (fur.height * t);
    // Hairs join to locks, locks to clumps: a finer octave for what is seen near, a coarser one for the heights.
    let locks = field(combed(jittered - lean) * 2.6 + 5.1, fur.noise_frequency);
    let clumps = field(combed(jittered - lean), fur.noise_frequency);
    let swells = field(p - lean + 17.3, fur.height_frequency);
    let top = 1.0 - fur.height_variation * (0.5 + 0.3 * swells + 0.2 * locks);
    let alive = 1.0 - smoothstep(top - 0.25, top + 0.02, t);
    let clump = 1.0 + fur.noise_contrast * (0.35 + 0.65 * t) * (0.5 * clumps + 0.6 * locks);
    return max(0.0, clump) * alive * mix(1.0, fur.diameter_ratio, t);
}

// Medium of a subelement. `p` is the noise domain's point below it (skin position in cm, or uv), `t` its height,
// `normal` the interpolated normal, `id` its stable number.
// The lookup's random displacement and the tangents' spread grow towards the top, clumps are cones, as
// [Andersen2016] sec. 3.2 says in words; the formulas are ours.
fn evaluate_medium(p: vec3f, normal: vec3f, t: f32, id: u32) -> Medium {
    let h = hash2(id, fur.seed);
    let growth = pow(t, fur.jitter_exponent);
    let jittered = p + fur.uv_jitter * growth * (2.0 * random3(h, 0u) - 1.0);
    let turn = fur.tangent_jitter * growth * random_direction(h, 3u);
    return Medium(clump_density(p, jittered, t), normalize(normal + fur.lean * t + turn));
}
