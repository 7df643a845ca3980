// Directional lights.

struct Light {
    direction: vec3f,   // towards the light, unit
    undercoat: u32,     // 1: lights the undercoat
    irradiance: vec3f,
    spread: f32,        // widens the lobes of objects, radians of the half vector
}

struct Lights {
    lights: array<Light, 64>,
}
