//! Oracle for `shaders/undercoat_light.wgsl`: optical depths by a separate march from each place
//! through the undercoat's medium itself; only guard hairs are read from the lattice.

use crate::twin::lattice;
use glam::Vec3;
use pelage_fur::layout::FurParameters;
use pelage_fur::shell::{Located, Place};
use pelage_fur::undercoat::{Undercoat, extinction};
use std::f32::consts::FRAC_PI_4;

/// Optical depth at which a light counts as blocked; exp(-18) is below 2e-8.
pub const TAU_BLOCKED: f32 = 18.0;

/// The medium that attenuates light.
#[derive(Clone, Copy)]
pub struct Attenuator<'a> {
    /// Parameters of undercoat and lattice.
    pub fur: &'a FurParameters,
    /// The undercoat.
    pub undercoat: Undercoat<'a>,
    /// Density of the undercoat at each column, relative to `fur.undercoat.density`.
    pub densities: &'a [f32],
    /// Projected extinction by guard hairs at the nodes of the lattice, 1/cm.
    pub guard: &'a [f32],
}

impl Attenuator<'_> {
    /// Extinction by undercoat and guard hairs at a place towards `w`, 1/cm.
    pub fn extinction(&self, place: &Place, w: Vec3) -> f32 {
        let fur = self.fur;
        let cell = lattice::cell(fur, place);
        let (mut guard, mut density) = (0.0, 0.0);
        for k in 0..3 {
            let node = lattice::node_index(fur, cell.columns[k], cell.level) as usize;
            let along = self.guard[node] * (1.0 - cell.fraction) + self.guard[node + 1] * cell.fraction;
            guard += cell.weights[k] * along;
            density += cell.weights[k] * self.densities[cell.columns[k] as usize];
        }
        let mut sigma = FRAC_PI_4 * guard; // the mean sine
        if place.t <= 1.0 && fur.undercoat.extinction > 0.0 {
            sigma += density * extinction(&fur.undercoat, self.undercoat.at(place), w);
        }
        sigma
    }

    /// Optical depth from `x`, which lies at `start`, towards `w`, in steps of `step` cm until the
    /// ray leaves the lattice; [`TAU_BLOCKED`] if it meets the skin.
    pub fn optical_depth(&self, start: &Place, x: Vec3, w: Vec3, step: f32) -> f32 {
        let fur = self.fur;
        let mut place = *start;
        let mut sum = 0.0;
        for i in 0..20_000 {
            let at = x + (i as f32 + 0.5) * step * w;
            let found = self.undercoat.shell.locate(&mut place, at, w, 3);
            if found != Located::Inside || place.t > fur.lattice.reach {
                break;
            }
            if place.t < -0.02 {
                return TAU_BLOCKED;
            }
            sum += self.extinction(&place, w) * step;
            if sum >= TAU_BLOCKED {
                return TAU_BLOCKED;
            }
        }
        sum
    }
}
