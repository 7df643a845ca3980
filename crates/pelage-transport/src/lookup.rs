//! Twin of `shaders/shared/transport.wgsl`: lookups in the table of multiple scattering.

use crate::{ALBEDOS, COSINES, DEEPEST, DEPTHS, TILTS, Table, dual};
use glam::{Vec3, Vec4};
use pelage_fur::Layer;
use std::f32::consts::{FRAC_PI_2, PI};

/// Radiance in the four zones, for each colour.
pub type Field = [Vec4; 3];

/// The entry below and the weight of the next.
fn place(x: f32, count: usize) -> (usize, f32) {
    let scaled = x.clamp(0.0, 1.0) * (count - 1) as f32;
    let index = (scaled as usize).min(count - 2);
    (index, scaled - index as f32)
}

fn tint_place(tint: f32) -> (usize, f32) {
    place(1.0 - (1.0 - tint).max(0.0).sqrt(), ALBEDOS)
}

fn entry(table: &[[f32; 4]], tint: f32, (at, part): (usize, f32)) -> Vec4 {
    let (t, t_part) = tint_place(tint);
    let of = |t: usize, i: usize| Vec4::from(table[t * COSINES + i]);
    let along = |t: usize| of(t, at).lerp(of(t, at + 1), part);
    along(t).lerp(along(t + 1), t_part)
}

impl Table {
    /// Scattered radiance at an optical depth `tau` towards a light of cosine `mu` to the normal, for an irradiance of 1.
    pub fn scattered_field(&self, tint: Vec3, tau: f32, mu: f32) -> Field {
        let (d, d_part) = place((tau / DEEPEST).sqrt(), DEPTHS);
        let light = place(mu, COSINES);
        [0, 1, 2].map(|c| {
            let of = |d: usize| {
                let rows: Vec<[f32; 4]> = (0..ALBEDOS)
                    .flat_map(|t| {
                        self.field[((3 * t + c) * DEPTHS + d) * COSINES..][..COSINES].iter().copied()
                    })
                    .collect();
                entry(&rows, tint[c], light)
            };
            of(d).lerp(of(d + 1), d_part)
        })
    }

    /// At an optical depth `tau` towards a light of cosine `light` to the normal, for a view of cosine `view`: radiance that undercoat
    /// sends to it, by its extinction, of light scattered before, for an irradiance of 1; radiance that falls on guard hairs
    /// from above and from below.
    pub fn sent_radiance(&self, tint: Vec3, tau: f32, light: f32, view: f32) -> [Vec3; 3] {
        let (d, d_part) = place((tau / DEEPEST).sqrt(), DEPTHS);
        let (l, l_part) = place(light, COSINES);
        let (v, v_part) = place(0.5 * view + 0.5, COSINES);
        let mix = |a: Vec4, b: Vec4, x: f32| a.lerp(b, x);
        let of_color = [0, 1, 2].map(|c| {
            let (t, t_part) = tint_place(tint[c]);
            let at = |t: usize, v: usize, d: usize| {
                let row = &self.sent[((3 * (t * COSINES + v) + c) * DEPTHS + d) * COSINES..];
                mix(row[l].into(), row[l + 1].into(), l_part)
            };
            let of_view = |t: usize, v: usize| mix(at(t, v, d), at(t, v, d + 1), d_part);
            let of_tint = |t: usize| mix(of_view(t, v), of_view(t, v + 1), v_part);
            mix(of_tint(t), of_tint(t + 1), t_part)
        });
        [0, 1, 2].map(|which| Vec3::from_array(of_color.map(|entry| entry[which])))
    }

    /// What falls on the skin.
    pub fn field_irradiance(&self, field: &Field) -> Vec3 {
        let [high, low, ..] = self.flux;
        Vec3::from_array(field.map(|f| std::f32::consts::TAU * (high * f.x + low * f.y)))
    }

    /// Light scattered more than once from `l` to `v` by a hair with the optical depth `tau` towards `l`, for an irradiance of 1.
    pub fn dual_scatter(&self, layer: Layer, tint: Vec3, tangent: Vec3, l: Vec3, v: Vec3, tau: f32) -> Vec3 {
        let [theta_i, theta_o] = [l, v].map(|w| tangent.dot(w).clamp(-1.0, 1.0).asin());
        let at = place(0.5 * (0.5 * (theta_o - theta_i)).sin() + 0.5, COSINES);
        let table = &self.dual[usize::from(layer == Layer::Guard)];
        let rows = [0, 1].map(|k| table.iter().skip(k).step_by(2).copied().collect::<Vec<_>>());
        Vec3::from_array([0, 1, 2].map(|c| {
            let entries = [0, 1].map(|k| entry(&rows[k], tint[c], at).to_array());
            dual::scatter(entries, [theta_i, theta_o], tau, self.dual_density)
        }))
    }

    /// Radiance that a guard hair sends to `view` where this radiance comes from above the horizon of `normal` and from below.
    pub fn guard_response(
        &self,
        tint: Vec3,
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
        let at = place(0.5 * sin_o + 0.5, COSINES);
        Vec3::from_array([0, 1, 2].map(|c| {
            let (t, t_part) = tint_place(tint[c]);
            let of = |t: usize, azimuth: usize, tilt: usize| {
                let row = &self.guard[((t * TILTS + azimuth) * TILTS + tilt) * COSINES..];
                Vec4::from(row[at.0]).lerp(row[at.0 + 1].into(), at.1)
            };
            let of_azimuth = |t, a| of(t, a, tilt.0).lerp(of(t, a, tilt.0 + 1), tilt.1);
            let of_tint = |t| of_azimuth(t, azimuth.0).lerp(of_azimuth(t, azimuth.0 + 1), azimuth.1);
            let entry = of_tint(t).lerp(of_tint(t + 1), t_part);
            entry.x * light[0][c] + entry.y * light[1][c]
        }))
    }
}
