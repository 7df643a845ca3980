//! Multiple scattering in fur: light that reaches a hair after one or more other hairs have
//! scattered it.
//!
//! Where hairs are bright, nearly all light that a camera sees was scattered more than once.
//! Following it is too slow for a renderer that marches a volume, so it is solved once for each
//! rendering and looked up:
//!
//! 1. [`coat`] describes the fur as a plane-parallel coat on the skin: hairs whose density,
//!    directions and colours depend on the height alone. The crate's module `world` takes this
//!    description from a scene.
//! 2. [`operators`] samples how these hairs attenuate and scatter light, with the fibre models that
//!    the renderer uses.
//! 3. [`slab`] solves the radiative transfer in the coat, over all orders of scattering, for a
//!    directional light from each inclination and hairs of each albedo.
//! 4. The result is tabulated ([`Table`]) and looked up ([`lookup`], twin of a shader) by the
//!    optical depth towards each light.
//!
//! At a lookup, the optical depth is that of the optical-depth lattice, which knows the true shape
//! of the skin, the clumps and the guard hairs. So a coat that is not flat is treated as flat
//! around each point.
//!
//! [`dual`] is the other method, which needs no solution: dual scattering.
//!
//! DEVIATION: Zinke et al. 2008 (dual scattering) sum the orders of scattering by the attenuation
//! of a hair's forward and backward hemispheres in azimuth. That fails for upright hairs: light
//! from above goes on downwards whichever way it turns in azimuth, and only roughness, tilt and
//! disorder bring it out again. So the transport follows the inclination.

pub mod bins;
pub mod coat;
pub mod dual;
mod grid;
pub mod lookup;
pub mod operators;
pub mod slab;
#[cfg(test)]
mod slab_test;
mod tabulate;
mod world;

pub use grid::{ALBEDOS, COSINES, DEEPEST, DEPTHS, ROWS, TILTS, albedo, depth};

/// Scattered light in a coat, by the albedo of its hairs, the light's inclination and the optical
/// depth towards it.
///
/// Indices of albedo and depth stand for the values of [`albedo`] and [`depth`]; cosines are evenly
/// spaced, from 0 to 1 for lights and from -1 to 1 for views. The last depth is that of a light
/// that is blocked, and dark.
///
/// Radiance is a mean over each of four zones of the directions that it comes from, by the cosine
/// to the skin's normal: 0, high above; 1, low above; 2, slightly below; 3, far below the horizon.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Share of the sphere's solid angle in each zone.
    pub share: [f32; 4],
    /// Integral of the cosine over each zone's solid angle, divided by 2 pi; negative below the
    /// horizon.
    pub flux: [f32; 4],
    /// Weights of light scattered forward and backward by dual scattering: its density factors d_f
    /// and d_b, 0 where a term is off.
    pub dual_density: [f32; 2],
    /// Radiance in the four zones for an irradiance of 1, by colour because the skin below has one:
    /// `[albedo][colour][depth][cosine of the light]`.
    pub field: Vec<[f32; 4]>,
    /// For an irradiance of 1: the radiance that undercoat sends to a view over its extinction; the
    /// radiance that falls on guard hairs from above and from below, each a mean weighted by how
    /// much guard hairs send to the view; 0: `[albedo][cosine of the view][colour][depth][cosine of
    /// the light]`. Hairs scatter into cones, which the four zones cannot resolve.
    pub sent: Vec<[f32; 4]>,
    /// Radiance that a guard hair sends to a view for a radiance of 1 from above the skin's
    /// horizon, and from below; 0; 0: `[albedo][azimuth of the normal][angle of the normal to the
    /// hair][sine of the view's inclination]`. The azimuth, around the hair, is measured from that
    /// of the view and goes from 0 to pi, the angle from 0 to pi/2, the sine from -1 to 1.
    pub guard: Vec<[f32; 4]>,
    /// [`dual::table`] of the undercoat's fibres and of the guard hairs'.
    pub dual: [Vec<[f32; 4]>; 2],
}

/// Which light that was scattered more than once is counted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Terms {
    /// Weight of light that comes from above or, with dual scattering, was scattered forward
    /// towards the hair.
    pub forward: f32,
    /// Weight of light that comes from below or, with dual scattering, was scattered back by the
    /// hairs behind.
    pub backward: f32,
    /// Density factors d_f and d_b of dual scattering.
    pub density: [f32; 2],
}

impl Table {
    /// Texels of `field_table`, [`COSINES`] wide, 3 [`DEPTHS`] high, with [`ALBEDOS`] layers.
    pub fn field_texels(&self) -> &[[f32; 4]] {
        &self.field
    }

    /// Texels of `sent_table`, [`COSINES`] wide, 3 [`DEPTHS`] high, with [`ALBEDOS`] times
    /// [`COSINES`] layers.
    pub fn sent_texels(&self) -> &[[f32; 4]] {
        &self.sent
    }

    /// Texels of `response_table`, [`COSINES`] wide, [`ROWS`] high, with [`ALBEDOS`] layers. Rows:
    /// one with the shares, the fluxes and the density factors in its first three texels; those of
    /// [`Table::guard`]; two for each of [`Table::dual`].
    pub fn response_texels(&self) -> Vec<[f32; 4]> {
        let [forward, backward] = self.dual_density;
        let mut head = vec![[0.0; 4]; COSINES];
        head[..3].copy_from_slice(&[self.share, self.flux, [forward, backward, 0.0, 0.0]]);
        let mut texels = Vec::new();
        for layer in 0..ALBEDOS {
            texels.extend_from_slice(&head);
            texels
                .extend_from_slice(self.guard.chunks(TILTS * TILTS * COSINES).nth(layer).unwrap_or_default());
            for dual in &self.dual {
                for which in 0..2 {
                    texels.extend(dual[2 * layer * COSINES..][..2 * COSINES].iter().skip(which).step_by(2));
                }
            }
        }
        texels
    }
}
