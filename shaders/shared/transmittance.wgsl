// Transmittance of light after an optical depth. Needs: fur (uniform FurParameters).

// Optical depth at which a light counts as blocked.
const TAU_BLOCKED: f32 = 18.0;

// Transmittance if the part of the light that hairs of this albedo scatter forward counts as
// unscattered, by a similarity relation. [Wyman1989]
fn light_through(depth: f32, albedo: vec3f) -> vec3f {
    return exp(-depth * (1.0 - fur.undercoat.forward_scattering * albedo));
}
