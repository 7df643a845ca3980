// The undercoat's medium: density and tangent of a subelement.
// Needs: fur (uniform Fur); shared/octahedral.

#import shared/angles
#import shared/constants
#import shared/undercoat_types

struct Medium {
    density: f32,   // relative to the skin's mean, 0..4
    tangent: vec3f, // unit
}

const DENSITY_RANGE: f32 = 4.0;

fn pack_medium(m: Medium) -> u32 {
    let oct = vec2u(round((octahedral_encode(m.tangent) * 0.5 + 0.5) * 1023.0));
    let density = u32(round(clamp(m.density / DENSITY_RANGE, 0.0, 1.0) * 4095.0));
    return density | (oct.x << 12u) | (oct.y << 22u);
}

fn unpack_medium(word: u32) -> Medium {
    let oct = vec2f(f32((word >> 12u) & 1023u), f32(word >> 22u)) / 1023.0;
    return Medium(f32(word & 4095u) / 4095.0 * DENSITY_RANGE, octahedral_decode(oct * 2.0 - 1.0));
}

// Mean direction of the hairs at height t (in shell heights) over a skin with this normal: they lean more towards the top.
fn mean_tangent(normal: vec3f, t: f32) -> vec3f {
    return normalize(normal + fur.lean * t);
}

// Part of its area that a hair shows towards unit direction `w`. Without regard to the angle, the mean over all directions.
fn shown_part(tangent: vec3f, w: vec3f) -> f32 {
    return select(sine_between(tangent, w), FRAC_PI_4, fur.isotropic == 1u);
}

// Extinction in 1/cm towards unit direction `w`: fibres of n_perp per area show n_perp d sin(T, w).
fn extinction(m: Medium, w: vec3f) -> f32 {
    return fur.extinction * m.density * shown_part(m.tangent, w);
}
