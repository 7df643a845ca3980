// Scattering of the undercoat's hairs.
// Needs: undercoat_fibre (uniform Fibre); shared/fibre.

// The model, fixed when the kernel is compiled.
override UNDERCOAT_MODEL: u32 = 0u;

// Light from `l` to `v` by a hair of colour `tint`, times the irradiance; of Kajiya-Kay without the colour, see `coat_color`.
fn scatter_undercoat(tangent: vec3f, l: vec3f, v: vec3f, tint: vec3f) -> vec3f {
    if UNDERCOAT_MODEL == MODEL_KAJIYA_KAY {
        return vec3f(kajiya_kay(undercoat_fibre.diffuse, undercoat_fibre.specular, undercoat_fibre.specular_exponent, tangent, l, v));
    }
    return scatter_fibre(UNDERCOAT_MODEL, undercoat_fibre, tangent, l, v, tint, MEAN_GLINT);
}

// Factor on what `scatter_undercoat` gives: Kajiya-Kay's colour is that of the place of the look, not of the nodes around it.
fn coat_color(tint: vec3f) -> vec3f {
    return select(vec3f(1.0), tint, UNDERCOAT_MODEL == MODEL_KAJIYA_KAY);
}

// Colour of a hair that takes as much light as the halves of one with these colours do. Where the colour stands for absorption within
// the hair, that is the square of its logarithm.
fn mean_color(a: vec3f, b: vec3f) -> vec3f {
    if UNDERCOAT_MODEL < MODEL_CHIANG {
        return 0.5 * (a + b);
    }
    let low = vec3f(1e-3);
    let log_a = log(max(a, low));
    let log_b = log(max(b, low));
    return exp(-sqrt(0.5 * (log_a * log_a + log_b * log_b)));
}
