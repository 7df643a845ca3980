// Directional lights.

struct Light {
    direction: vec3f,   // towards the light, unit
    undercoat: u32,     // 1: lights the undercoat
    irradiance: vec3f,
    padding: u32,
}

struct Lights {
    lights: array<Light, 64>,
}
