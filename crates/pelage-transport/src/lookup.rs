//! Lookups in the table of multiple scattering: CPU twin of `shaders/shared/transport.wgsl`.
//!
//! A table is interpolated linearly along each of its axes. `albedo` is the colour of the hairs, a
//! table's albedo for each channel; irradiance is perpendicular to the light.

use crate::grid::{ALBEDOS, COSINES, DEPTHS, TILTS, albedo_fraction, depth_fraction, place, signed_fraction};
use crate::{Table, dual};
use glam::{Vec3, Vec4};
use pelage_fur::Layer;
use std::f32::consts::{FRAC_PI_2, PI};

/// Radiance in the four zones of a [`Table`], for each colour.
pub type Field = [Vec4; 3];

/// Place of an albedo in a table: the index below and the weight of the next.
fn albedo_place(albedo: f32) -> (usize, f32) {
    place(albedo_fraction(albedo), ALBEDOS)
}

/// Entry of a table `[albedo][sine or cosine]`, interpolated between index `at` and the next, whose
/// weight is `part`.
fn entry(table: &[[f32; 4]], albedo: f32, (at, part): (usize, f32)) -> Vec4 {
    let (darker, a_part) = albedo_place(albedo);
    let of = |a: usize, i: usize| Vec4::from(table[a * COSINES + i]);
    let along = |a: usize| of(a, at).lerp(of(a, at + 1), part);
    along(darker).lerp(along(darker + 1), a_part)
}

impl Table {
    /// Scattered radiance at an optical depth `tau` towards a light of cosine `mu` to the normal,
    /// for an irradiance of 1.
    pub fn scattered_field(&self, albedo: Vec3, tau: f32, mu: f32) -> Field {
        let (d, d_part) = place(depth_fraction(tau), DEPTHS);
        let light = place(mu, COSINES);
        [0, 1, 2].map(|c| {
            let of = |d: usize| {
                let rows: Vec<[f32; 4]> = (0..ALBEDOS)
                    .flat_map(|a| {
                        self.field[((3 * a + c) * DEPTHS + d) * COSINES..][..COSINES].iter().copied()
                    })
                    .collect();
                entry(&rows, albedo[c], light)
            };
            of(d).lerp(of(d + 1), d_part)
        })
    }

    /// Light for a view of cosine `view` to the normal, at an optical depth `tau` towards a light
    /// of cosine `light`, for an irradiance of 1: the radiance that undercoat sends to the view
    /// over its extinction, from light that was scattered before; the radiance that falls on guard
    /// hairs from above, and from below.
    pub fn sent_radiance(&self, albedo: Vec3, tau: f32, light: f32, view: f32) -> [Vec3; 3] {
        let (d, d_part) = place(depth_fraction(tau), DEPTHS);
        let (l, l_part) = place(light, COSINES);
        let (v, v_part) = place(signed_fraction(view), COSINES);
        let mix = |a: Vec4, b: Vec4, x: f32| a.lerp(b, x);
        let of_color = [0, 1, 2].map(|c| {
            let (darker, a_part) = albedo_place(albedo[c]);
            let at = |a: usize, v: usize, d: usize| {
                let row = &self.sent[((3 * (a * COSINES + v) + c) * DEPTHS + d) * COSINES..];
                mix(row[l].into(), row[l + 1].into(), l_part)
            };
            let of_view = |a: usize, v: usize| mix(at(a, v, d), at(a, v, d + 1), d_part);
            let of_albedo = |a: usize| mix(of_view(a, v), of_view(a, v + 1), v_part);
            mix(of_albedo(darker), of_albedo(darker + 1), a_part)
        });
        [0, 1, 2].map(|which| Vec3::from_array(of_color.map(|entry| entry[which])))
    }

    /// Irradiance of the skin from above.
    pub fn field_irradiance(&self, field: &Field) -> Vec3 {
        let [high, low, ..] = self.flux;
        Vec3::from_array(field.map(|f| std::f32::consts::TAU * (high * f.x + low * f.y)))
    }

    /// Radiance sent to the view `v` by dual scattering, from a light `l` at an optical depth
    /// `tau`, for an irradiance of 1: light that was scattered more than once. Directions are unit
    /// and leave the hair.
    pub fn dual_scatter(
        &self,
        layer: Layer,
        albedo: Vec3,
        tangent: Vec3,
        l: Vec3,
        v: Vec3,
        tau: f32,
    ) -> Vec3 {
        let [theta_i, theta_o] = [l, v].map(|w| tangent.dot(w).clamp(-1.0, 1.0).asin());
        let at = place(signed_fraction((0.5 * (theta_o - theta_i)).sin()), COSINES);
        let table = &self.dual[usize::from(layer == Layer::Guard)];
        let rows = [0, 1].map(|k| table.iter().skip(k).step_by(2).copied().collect::<Vec<_>>());
        Vec3::from_array([0, 1, 2].map(|c| {
            let entries = [0, 1].map(|k| entry(&rows[k], albedo[c], at).to_array());
            dual::scatter(entries, [theta_i, theta_o], tau, self.dual_density)
        }))
    }

    /// Radiance that a guard hair sends to `view` for the radiances that come from above the
    /// horizon of the skin's `normal` and from below it. Directions are unit.
    pub fn guard_response(
        &self,
        albedo: Vec3,
        tangent: Vec3,
        view: Vec3,
        normal: Vec3,
        [above, below]: [Vec3; 2],
    ) -> Vec3 {
        let sin_o = tangent.dot(view);
        let along = tangent.dot(normal);
        let (side, light) = if along >= 0.0 { (1.0, [above, below]) } else { (-1.0, [below, above]) };
        let across = view - sin_o * tangent;
        let up = side * (normal - along * tangent);
        let lengths = (across.length_squared() * up.length_squared()).max(1e-12).sqrt();
        let tilt = place(along.abs().min(1.0).acos() / FRAC_PI_2, TILTS);
        let azimuth = place((across.dot(up) / lengths).clamp(-1.0, 1.0).acos() / PI, TILTS);
        let at = place(signed_fraction(sin_o), COSINES);
        Vec3::from_array([0, 1, 2].map(|c| {
            let (darker, a_part) = albedo_place(albedo[c]);
            let of = |a: usize, azimuth: usize, tilt: usize| {
                let row = &self.guard[((a * TILTS + azimuth) * TILTS + tilt) * COSINES..];
                Vec4::from(row[at.0]).lerp(row[at.0 + 1].into(), at.1)
            };
            let of_azimuth = |a, phi| of(a, phi, tilt.0).lerp(of(a, phi, tilt.0 + 1), tilt.1);
            let of_albedo = |a| of_azimuth(a, azimuth.0).lerp(of_azimuth(a, azimuth.0 + 1), azimuth.1);
            let entry = of_albedo(darker).lerp(of_albedo(darker + 1), a_part);
            entry.x * light[0][c] + entry.y * light[1][c]
        }))
    }
}
