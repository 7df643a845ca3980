// The undercoat's medium: density and tangent of a subelement, and its extinction.
// Needs: fur (uniform FurParameters); shared/octahedral.

#import shared/angles
#import shared/constants
#import shared/undercoat_types

struct Medium {
    density: f32,   // relative to the mean on the skin, 0..4
    tangent: vec3f, // unit
}

const DENSITY_RANGE: f32 = 4.0;

// 12 bits of density, 10 bits for each coordinate of the octahedral tangent.
fn pack_medium(m: Medium) -> u32 {
    let oct = vec2u(round((octahedral_encode(m.tangent) * 0.5 + 0.5) * 1023.0));
    let density = u32(round(clamp(m.density / DENSITY_RANGE, 0.0, 1.0) * 4095.0));
    return density | (oct.x << 12u) | (oct.y << 22u);
}

fn unpack_medium(word: u32) -> Medium {
    let oct = vec2f(f32((word >> 12u) & 1023u), f32(word >> 22u)) / 1023.0;
    return Medium(f32(word & 4095u) / 4095.0 * DENSITY_RANGE, octahedral_decode(oct * 2.0 - 1.0));
}

// Mean direction of the hairs at height t (in shell heights); the lean grows towards the top.
fn mean_tangent(normal: vec3f, t: f32) -> vec3f {
    return normalize(normal + fur.undercoat.lean * t);
}

// Projected area of a hair towards unit direction `w`, relative to that perpendicular to the hair;
// the mean over all directions if extinction is isotropic.
fn relative_projection(tangent: vec3f, w: vec3f) -> f32 {
    return select(sine_between(tangent, w), FRAC_PI_4, fur.undercoat.isotropic == 1u);
}

// Extinction in 1/cm towards unit direction `w`: n d sin(T, w) for hairs of diameter d and
// direction T, n of them per area perpendicular to T.
fn extinction(m: Medium, w: vec3f) -> f32 {
    return fur.undercoat.extinction * m.density * relative_projection(m.tangent, w);
}
