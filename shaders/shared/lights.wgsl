// Directional lights and the transmittances in the light lattice.

struct Light {
    direction: vec3f,   // towards the light, unit
    undercoat: u32,     // 1: lights the undercoat
    irradiance: vec3f,
    padding: u32,
}

struct Lights {
    lights: array<Light, 64>,
}

// Optical depth at which a light counts as blocked.
const TAU_BLOCKED: f32 = 18.0;

// Optical depths are kept as pairs of halves; the slot behind the last light belongs to the eye. A node has `fur.tau_stride` words: with
// multiple scattering by transport, mean scattered radiance from above and from below follows, six halves.
fn tau_pairs() -> u32 {
    return (fur.lights + 2u) / 2u;
}
