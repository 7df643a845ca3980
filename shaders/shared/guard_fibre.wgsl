// Scattering by guard hairs. Needs: guard_fibre (uniform Fibre); shared/fibre.

// The model, fixed when the kernel is compiled.
override GUARD_MODEL: u32 = MODEL_SADEGHI;

// Radiance from `l` towards `v` (unit, both point away from the hair) per irradiance, for a hair of
// colour `tint`.
fn scatter_guard(tangent: vec3f, l: vec3f, v: vec3f, tint: vec3f, glint_angle: f32) -> vec3f {
    return scatter_fibre(GUARD_MODEL, guard_fibre, tangent, l, v, tint, glint_angle);
}
