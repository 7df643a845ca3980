//! Twin of `shaders/shared/{undercoat,clumps,volume}.wgsl`: density, tangents and scattering of the
//! undercoat.

use crate::arithmetic::{inverse_ease, smoothstep};
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
    /// Density relative to its mean over the skin, 0 to [`DENSITY_RANGE`].
    pub density: f32,
    /// Direction of the hairs, unit, world space.
    pub tangent: Vec3,
}

/// Largest relative density that can be stored.
pub const DENSITY_RANGE: f32 = 4.0;

/// Packs a medium into 32 bits: 12 bits of density, 10 bits for each coordinate of the octahedral
/// tangent.
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

/// Extinction along the unit direction `w`, 1/cm: hairs of diameter d, n per area perpendicular to
/// them, have a projected area of n d sin(tangent, w) per volume. With `isotropic` (the paper's
/// shading) the sine is replaced by π/4, its mean over all directions.
pub fn extinction(fur: &UndercoatParameters, m: Medium, w: Vec3) -> f32 {
    let shown = if fur.isotropic == 1 { std::f32::consts::FRAC_PI_4 } else { sine(m.tangent, w) };
    fur.extinction * m.density * shown
}

/// Mean colour of the undercoat for its colours at root (`a`) and tip (`b`), linear RGB: light that
/// leaves the undercoat has passed both. For the absorbing models, whose absorption is proportional
/// to the squared logarithm of the colour, it is the colour of the mean absorption.
pub fn mean_color(undercoat: &Fibre, a: Vec3, b: Vec3) -> Vec3 {
    if !matches!(undercoat, Fibre::Chiang(_) | Fibre::Medulla(_)) {
        return 0.5 * (a + b);
    }
    let log = |c: Vec3| c.max(Vec3::splat(1e-3)).map(f32::ln);
    (0.5 * (log(a) * log(a) + log(b) * log(b))).map(|square| (-square.sqrt()).exp())
}

/// Radiance towards `v` for unit irradiance from `l` (unit vectors that leave the hair) of a hair
/// with unit tangent `tangent` and colour `tint`: f cos θ_i of the far field. For Kajiya–Kay the
/// colour is left out; multiply by [`color`].
pub fn scatter(undercoat: &Fibre, tangent: Vec3, l: Vec3, v: Vec3, tint: Vec3) -> Vec3 {
    let angles = Angles::around(tangent, l, v);
    match undercoat {
        Fibre::KajiyaKay(model) => Vec3::splat(model.scatter(&angles)),
        _ => undercoat.scatter_far(&Hit { tint, glint_angle: MEAN_GLINT, h: 0.0 }, &angles),
    }
}

/// Factor on the result of [`scatter`]: the colour for Kajiya–Kay, 1 for the other models.
pub fn color(undercoat: &Fibre, tint: Vec3) -> Vec3 {
    if matches!(undercoat, Fibre::KajiyaKay(_)) { tint } else { Vec3::ONE }
}

/// Scale of the domain of the locks' noise relative to that of the clumps: locks are finer.
pub const LOCKS_SCALE: f32 = 2.6;
/// Offset of the domain of the locks' noise, which decorrelates it from the clumps'.
pub const LOCKS_SHIFT: f32 = 5.1;
/// Offset of the domain of the swells' noise.
pub const SWELLS_SHIFT: f32 = 17.3;

/// The domain of clumps and locks is scaled by 1 minus this along the lean: locks of combed fur are
/// longer than wide.
pub const LEAN_STRETCH: f32 = 0.65;

/// Relative density at height `t` (0 skin, 1 top) for the noise values `clumps` and `locks`; it may
/// be negative.
pub fn clump_factor(contrast: f32, t: f32, clumps: f32, locks: f32) -> f32 {
    1.0 + contrast * (0.35 + 0.65 * t) * (0.5 * clumps + 0.6 * locks)
}

/// Height near which the hairs of a place end, in heights of the shell, for the noise values
/// `swells` and `locks`.
pub fn hair_top(variation: f32, swells: f32, locks: f32) -> f32 {
    1.0 - variation * (0.5 + 0.3 * swells + 0.2 * locks)
}

/// Hairs end between [`hair_top`] minus the first and [`hair_top`] plus the second.
const END: [f32; 2] = [0.25, 0.02];

/// Fraction of the hairs of a place that reach height `t`; `top` is [`hair_top`].
pub fn alive(top: f32, t: f32) -> f32 {
    1.0 - smoothstep(top - END[0], top + END[1], t)
}

/// Height at which the fraction `ended` of the hairs of a place has ended: the inverse of
/// [`alive`].
pub fn end_height(top: f32, ended: f32) -> f32 {
    top - END[0] + (END[0] + END[1]) * inverse_ease(ended)
}

/// Diameter at height `t` relative to that at the root; `ratio` is that at the top.
pub fn taper(ratio: f32, t: f32) -> f32 {
    1.0 + (ratio - 1.0) * t
}

/// The undercoat within a prism shell.
#[derive(Clone, Copy)]
pub struct Undercoat<'a> {
    /// Parameters, as the shaders read them.
    pub parameters: &'a UndercoatParameters,
    /// Simplex noise for the scene's seed.
    pub noise: Field,
    /// The prism shell.
    pub shell: &'a Shell,
    /// The stored volume, a packed medium per subelement; if empty, media are evaluated on demand.
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

    /// `p` with the component along the lean scaled by 1 − [`LEAN_STRETCH`].
    fn combed(&self, p: Vec3) -> Vec3 {
        let lean = Vec3::from(self.parameters.lean);
        p - lean * (lean.dot(p) * LEAN_STRETCH / lean.dot(lean).max(1e-12))
    }

    /// Relative density at height `t` above point `p` of the noise's domain; `jittered` is the
    /// point at which clumps and locks are read.
    #[inline]
    pub fn clump_density(&self, p: Vec3, jittered: Vec3, t: f32) -> f32 {
        let fur = self.parameters;
        let lean = Vec3::from(fur.lean) * (fur.height * t);
        let combed = self.combed(jittered - lean);
        let locks = self.field(combed * LOCKS_SCALE + LOCKS_SHIFT, fur.noise_frequency);
        let clumps = self.field(combed, fur.noise_frequency);
        let swells = self.field(p - lean + SWELLS_SHIFT, fur.height_frequency);
        // Each hair ends at its own height, so clumps taper towards their tips.
        let top = hair_top(fur.height_variation, swells, locks);
        let clump = clump_factor(fur.noise_contrast, t, clumps, locks);
        clump.max(0.0) * alive(top, t) * taper(fur.diameter_ratio, t)
    }

    /// Evaluates the medium at height `t` above point `p` of the noise's domain; `normal` is the
    /// unit direction of extrusion, `id` the stable number of the subelement.
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

    /// Point of the noise's domain at barycentric coordinates `l` of the place's prism: a point of
    /// the skin relative to the mesh's translation (cm) or its uv.
    #[inline]
    pub fn domain_point(&self, place: &Place, l: Vec3) -> Vec3 {
        if self.parameters.noise_domain == 1 {
            let uv = |k: u32| Vec2::from(self.shell.corner_uv[(3 * place.prism + k) as usize]);
            (l.x * uv(0) + l.y * uv(1) + l.z * uv(2)).extend(0.0)
        } else {
            place.point(0.0, l) - Vec3::from(self.parameters.origin)
        }
    }

    /// Evaluates the medium of subelement `id` of the volume's layer `layer` in the place's prism.
    pub fn subelement(&self, place: &Place, layer: u32, id: u32) -> Medium {
        let l = subelement_centroid(id, place.subdivision);
        let t = (layer as f32 + 0.5) / self.parameters.layers as f32;
        let normal = place.direction(l);
        let id = hash2(place.prism, (layer << 16) | id);
        let medium = self.evaluate(self.domain_point(place, l), normal, t, id);
        Medium { density: medium.density * place.crowding(t, medium.tangent), ..medium }
    }

    /// The medium of the subelement that contains the place.
    pub fn at(&self, place: &Place) -> Medium {
        let layers = self.parameters.layers;
        let layer = ((place.t.clamp(0.0, 1.0) * layers as f32) as u32).min(layers - 1);
        let id = subelement(place.lambda, place.subdivision);
        if self.cells.is_empty() {
            // Quantised as if it were stored, so that the image does not depend on which of the two
            // is used.
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
