//! Twin of `shaders/shared/{undercoat,clumps,volume}.wgsl`: the undercoat's medium.

use crate::fibre::table::MEAN_GLINT;
use crate::fibre::{Angles, Fibre, Hit};
use crate::layout::UndercoatParameters;
use crate::octahedral;
use crate::random::{hash2, random, random_direction};
use crate::shell::{Place, Shell, subelement, subelement_centroid};
use crate::simplex::Field;
use glam::{Vec2, Vec3};

/// Density and tangent of a subelement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Medium {
    /// Relative to the skin's mean, 0..4.
    pub density: f32,
    /// Unit.
    pub tangent: Vec3,
}

/// Largest density that is stored.
pub const DENSITY_RANGE: f32 = 4.0;

/// 12 bits of density, 10 bits a coordinate of the octahedral tangent.
pub fn pack_medium(m: Medium) -> u32 {
    let oct = (octahedral::encode(m.tangent) * 0.5 + 0.5) * 1023.0;
    let density = ((m.density / DENSITY_RANGE).clamp(0.0, 1.0) * 4095.0).round_ties_even() as u32;
    density | ((oct.x.round_ties_even() as u32) << 12) | ((oct.y.round_ties_even() as u32) << 22)
}

/// The inverse of [`pack_medium`].
pub fn unpack_medium(word: u32) -> Medium {
    let oct = Vec2::new(((word >> 12) & 1023) as f32, (word >> 22) as f32) / 1023.0;
    Medium {
        density: (word & 4095) as f32 / 4095.0 * DENSITY_RANGE,
        tangent: octahedral::decode(oct * 2.0 - 1.0),
    }
}

/// Sine of the angle between two unit vectors.
pub fn sine(a: Vec3, b: Vec3) -> f32 {
    let c = a.dot(b);
    (1.0 - c * c).max(0.0).sqrt()
}

/// Extinction in 1/cm towards unit direction `w`: fibres of n_perp per area show n_perp d sin(T, w).
pub fn extinction(fur: &UndercoatParameters, m: Medium, w: Vec3) -> f32 {
    let shown = if fur.isotropic == 1 { std::f32::consts::FRAC_PI_4 } else { sine(m.tangent, w) };
    fur.extinction * m.density * shown
}

/// Mean of a coat's colours at root and tip: light that comes out has been deep in it and high in it. Models of fibres that absorb
/// have the root of the mean of the squared logarithms, which is the mean absorption.
pub fn mean_color(coat: &Fibre, a: Vec3, b: Vec3) -> Vec3 {
    if !matches!(coat, Fibre::Chiang(_) | Fibre::Medulla(_)) {
        return 0.5 * (a + b);
    }
    let log = |c: Vec3| c.max(Vec3::splat(1e-3)).map(f32::ln);
    (0.5 * (log(a) * log(a) + log(b) * log(b))).map(|square| (-square.sqrt()).exp())
}

/// Scattering of light from `l` to `v` (both leave the point) by a hair of colour `tint`; times the irradiance. Kajiya-Kay's is
/// without the colour, see [`color`].
pub fn scatter(coat: &Fibre, tangent: Vec3, l: Vec3, v: Vec3, tint: Vec3) -> Vec3 {
    let angles = Angles::around(tangent, l, v);
    match coat {
        Fibre::KajiyaKay(model) => Vec3::splat(model.scatter(&angles)),
        _ => coat.scatter_far(&Hit { tint, glint_angle: MEAN_GLINT, h: 0.0 }, &angles),
    }
}

/// Factor on what [`scatter`] gives.
pub fn color(coat: &Fibre, tint: Vec3) -> Vec3 {
    if matches!(coat, Fibre::KajiyaKay(_)) { tint } else { Vec3::ONE }
}

/// Hermite interpolation between two edges, as in WGSL.
fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Scale and shift of the noise of locks, which is finer than that of clumps, and shift of the noise of swells.
pub const LOCKS_SCALE: f32 = 2.6;
/// See [`LOCKS_SCALE`].
pub const LOCKS_SHIFT: f32 = 5.1;
/// See [`LOCKS_SCALE`].
pub const SWELLS_SHIFT: f32 = 17.3;

/// By how much less the noise of clumps and locks changes along the lean: locks of combed fur are longer than wide.
pub const LEAN_STRETCH: f32 = 0.65;

/// Density of clumps at height `t`, by the noises of clumps and locks; it may be negative.
pub fn clump_factor(contrast: f32, t: f32, clumps: f32, locks: f32) -> f32 {
    1.0 + contrast * (0.35 + 0.65 * t) * (0.5 * clumps + 0.6 * locks)
}

/// Height at which the hairs of a place have all but ended, by the noises of swells and locks.
pub fn hair_top(variation: f32, swells: f32, locks: f32) -> f32 {
    1.0 - variation * (0.5 + 0.3 * swells + 0.2 * locks)
}

/// Heights below and above [`hair_top`] between which hairs end.
const END: [f32; 2] = [0.25, 0.02];

/// Share of the hairs of a place that reach height `t`.
pub fn alive(top: f32, t: f32) -> f32 {
    1.0 - smoothstep(top - END[0], top + END[1], t)
}

/// Height at which the share `ended` of the hairs of a place have ended: the inverse of [`alive`].
pub fn end_height(top: f32, ended: f32) -> f32 {
    top - END[0] + (END[0] + END[1]) * inverse_smoothstep(ended)
}

/// The inverse of x² (3 - 2x) on 0..1.
fn inverse_smoothstep(y: f32) -> f32 {
    0.5 - ((1.0 - 2.0 * y.clamp(0.0, 1.0)).asin() / 3.0).sin()
}

/// Diameter at height `t` by that at the root, for the ratio of the two ends.
pub fn taper(ratio: f32, t: f32) -> f32 {
    1.0 + (ratio - 1.0) * t
}

/// The undercoat of a shell.
#[derive(Clone, Copy)]
pub struct Undercoat<'a> {
    /// Parameters.
    pub parameters: &'a UndercoatParameters,
    /// The noise.
    pub noise: Field,
    /// The shell.
    pub shell: &'a Shell,
    /// The stored volume; where it is empty, media are evaluated.
    pub cells: &'a [u32],
}

impl Undercoat<'_> {
    fn field(&self, p: Vec3, frequency: f32) -> f32 {
        if self.parameters.noise_domain == 1 {
            self.noise.simplex2(Vec2::new(p.x, p.y) * frequency)
        } else {
            self.noise.simplex3(p * frequency)
        }
    }

    /// Locks of combed fur are longer than wide: the noise is stretched along the lean.
    fn combed(&self, p: Vec3) -> Vec3 {
        let lean = Vec3::from(self.parameters.lean);
        p - lean * (lean.dot(p) * LEAN_STRETCH / lean.dot(lean).max(1e-12))
    }

    /// Density relative to the mean at height `t` above point `p` of the noise's domain; `jittered` is the point for the finer noise.
    #[inline]
    pub fn clump_density(&self, p: Vec3, jittered: Vec3, t: f32) -> f32 {
        let fur = self.parameters;
        let lean = Vec3::from(fur.lean) * (fur.height * t);
        let combed = self.combed(jittered - lean);
        let locks = self.field(combed * LOCKS_SCALE + LOCKS_SHIFT, fur.noise_frequency);
        let clumps = self.field(combed, fur.noise_frequency);
        let swells = self.field(p - lean + SWELLS_SHIFT, fur.height_frequency);
        // Hairs end at their own heights, which makes cones of the clumps.
        let top = hair_top(fur.height_variation, swells, locks);
        let clump = clump_factor(fur.noise_contrast, t, clumps, locks);
        clump.max(0.0) * alive(top, t) * taper(fur.diameter_ratio, t)
    }

    /// Medium above point `p` of the noise's domain at height `t`; `id` is the subelement's stable number.
    pub fn evaluate(&self, p: Vec3, normal: Vec3, t: f32, id: u32) -> Medium {
        let fur = self.parameters;
        let h = hash2(id, fur.seed);
        let growth = t.powf(fur.jitter_exponent);
        let offset = 2.0 * Vec3::new(random(h, 0), random(h, 1), random(h, 2)) - 1.0;
        let jittered = p + fur.uv_jitter * growth * offset;
        let turn = fur.tangent_jitter * growth * random_direction(h, 3);
        Medium {
            density: self.clump_density(p, jittered, t),
            tangent: (normal + Vec3::from(fur.lean) * t + turn).normalize(),
        }
    }

    /// Point of the noise's domain below barycentric coordinates of the place's prism: on the skin, cm, or uv.
    #[inline]
    pub fn domain_point(&self, place: &Place, l: Vec3) -> Vec3 {
        if self.parameters.noise_domain == 1 {
            let uv = |k: u32| Vec2::from(self.shell.corner_uv[(3 * place.prism + k) as usize]);
            (l.x * uv(0) + l.y * uv(1) + l.z * uv(2)).extend(0.0)
        } else {
            place.point(0.0, l)
        }
    }

    /// Medium of the subelement `id` of `layer` in the place's prism, evaluated.
    pub fn subelement(&self, place: &Place, layer: u32, id: u32) -> Medium {
        let l = subelement_centroid(id, place.subdivision);
        let t = (layer as f32 + 0.5) / self.parameters.layers as f32;
        let normal = place.extrusion(l).normalize();
        let id = hash2(place.prism, (layer << 16) | id);
        let medium = self.evaluate(self.domain_point(place, l), normal, t, id);
        Medium { density: medium.density * place.crowding(t, medium.tangent), ..medium }
    }

    /// Medium at a place: of its subelement.
    pub fn at(&self, place: &Place) -> Medium {
        let layers = self.parameters.layers;
        let layer = ((place.t.clamp(0.0, 1.0) * layers as f32) as u32).min(layers - 1);
        let id = subelement(place.lambda, place.subdivision);
        if self.cells.is_empty() {
            // As it would be stored, so that the image does not depend on it.
            unpack_medium(pack_medium(self.subelement(place, layer, id)))
        } else {
            unpack_medium(self.cells[place.volume_index(layer, id) as usize])
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_height_at_which_hairs_end_inverts_the_share_that_lives() {
        for i in 1..20 {
            let ended = i as f32 / 20.0;
            let top = 0.8;
            assert!((1.0 - alive(top, end_height(top, ended)) - ended).abs() < 1e-3, "{ended}");
        }
    }
}
