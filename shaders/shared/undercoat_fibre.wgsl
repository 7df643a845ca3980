// Scattering by the undercoat's hairs. Needs: undercoat_fibre (uniform Fibre); shared/fibre.

// The model, fixed when the kernel is compiled.
override UNDERCOAT_MODEL: u32 = MODEL_KAJIYA_KAY;

// Radiance from `l` towards `v` (unit, both point away from the hair) per irradiance, for a hair of
// colour `tint`; for Kajiya-Kay without the colour, see `undercoat_factor`.
fn scatter_undercoat(tangent: vec3f, l: vec3f, v: vec3f, tint: vec3f) -> vec3f {
    if UNDERCOAT_MODEL == MODEL_KAJIYA_KAY {
        return vec3f(kajiya_kay(undercoat_fibre.diffuse, undercoat_fibre.specular, undercoat_fibre.specular_exponent, tangent, l, v));
    }
    return scatter_fibre(UNDERCOAT_MODEL, undercoat_fibre, tangent, l, v, tint, MEAN_GLINT);
}

// Factor on `scatter_undercoat`. For Kajiya-Kay it is the colour, which is then that at the shaded
// point instead of those at the nodes around it.
fn undercoat_factor(tint: vec3f) -> vec3f {
    return select(vec3f(1.0), tint, UNDERCOAT_MODEL == MODEL_KAJIYA_KAY);
}

// Mean colour of a hair of which each half has one of these colours. For models with absorption
// inside the hair, the colour with the mean absorption, which is proportional to the square of the
// colour's logarithm.
fn mean_color(a: vec3f, b: vec3f) -> vec3f {
    if UNDERCOAT_MODEL < MODEL_CHIANG {
        return 0.5 * (a + b);
    }
    let low = vec3f(1e-3);
    let log_a = log(max(a, low));
    let log_b = log(max(b, low));
    return exp(-sqrt(0.5 * (log_a * log_a + log_b * log_b)));
}
