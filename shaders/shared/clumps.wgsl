// The undercoat's structure from simplex noise: clumps, uneven heights, spread of the tangents.
// [Andersen2016] sec. 3.2
// Needs: fur (uniform FurParameters), noise (uniform Noise); shared/random, shared/noise,
// shared/undercoat.

// Noise at a point of the domain, -1..1.
fn field(p: vec3f, frequency: f32) -> f32 {
    if fur.undercoat.noise_domain == 1u {
        return simplex2(p.xy * frequency);
    }
    return simplex3(p * frequency);
}

// Point of the noise domain stretched along the lean: locks of combed fur are longer than wide.
fn combed(p: vec3f) -> vec3f {
    let along = dot(fur.undercoat.lean, fur.undercoat.lean);
    return p - fur.undercoat.lean * (dot(fur.undercoat.lean, p) * 0.65 / max(along, 1e-12));
}

// Density at height t, relative to the mean. Hairs taper and end at different heights, which turns
// clumps into cones. `p`: the skin's point in the noise domain; `jittered`: that point displaced,
// for the finer noise.
fn clump_density(p: vec3f, jittered: vec3f, t: f32) -> f32 {
    let lean = fur.undercoat.lean * (fur.undercoat.height * t);
    // Hairs form locks, locks form clumps: a finer octave for close views, a coarser one for the
    // heights.
    let locks = field(combed(jittered - lean) * 2.6 + 5.1, fur.undercoat.noise_frequency);
    let clumps = field(combed(jittered - lean), fur.undercoat.noise_frequency);
    let swells = field(p - lean + 17.3, fur.undercoat.height_frequency);
    let top = 1.0 - fur.undercoat.height_variation * (0.5 + 0.3 * swells + 0.2 * locks);
    let alive = 1.0 - smoothstep(top - 0.25, top + 0.02, t);
    let clump = 1.0 + fur.undercoat.noise_contrast * (0.35 + 0.65 * t) * (0.5 * clumps + 0.6 * locks);
    return max(0.0, clump) * alive * mix(1.0, fur.undercoat.diameter_ratio, t);
}

// Medium of a subelement. `p`: point of the noise domain below it (skin position in cm, or uv);
// `t`: its height; `normal`: interpolated; `id`: its stable number. The random displacement of the
// lookup and the spread of the tangents grow towards the top and clumps are cones, as
// [Andersen2016] sec. 3.2 describes in words; the formulas are ours.
fn evaluate_medium(p: vec3f, normal: vec3f, t: f32, id: u32) -> Medium {
    let h = hash2(id, fur.undercoat.seed);
    let growth = pow(t, fur.undercoat.jitter_exponent);
    let jittered = p + fur.undercoat.uv_jitter * growth * (2.0 * random3(h, 0u) - 1.0);
    let turn = fur.undercoat.tangent_jitter * growth * random_direction(h, 3u);
    return Medium(clump_density(p, jittered, t), normalize(normal + fur.undercoat.lean * t + turn));
}
