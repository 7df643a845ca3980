// What is left of a light after an optical depth. Needs: fur (uniform Fur).

// Optical depth at which a light counts as blocked.
const TAU_BLOCKED: f32 = 18.0;

// Transmittance where part of what hairs of this albedo scatter goes on as if nothing had happened: similarity. [Wyman1989]
fn light_through(depth: f32, albedo: vec3f) -> vec3f {
    return exp(-depth * (1.0 - fur.forward_scattering * albedo));
}
