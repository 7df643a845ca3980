//! Twin of `shaders/shared/transport.wgsl`: lookups in the table of multiple scattering.

use crate::pathtrace::strands::Layer;
use crate::transport::{COSINES, DEEPEST, DEPTHS, TINTS, Table, dual};
use glam::{Vec3, Vec4};

/// Radiance in the four zones, for each colour.
pub type Field = [Vec4; 3];

/// The entry below and the weight of the next.
fn place(x: f32, count: usize) -> (usize, f32) {
    let scaled = x.clamp(0.0, 1.0) * (count - 1) as f32;
    let index = (scaled as usize).min(count - 2);
    (index, scaled - index as f32)
}

fn tint_place(tint: f32) -> (usize, f32) {
    place(1.0 - (1.0 - tint).max(0.0).sqrt(), TINTS)
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
        tint.to_array().map(|tint| {
            let of = |d: usize| {
                let rows: Vec<[f32; 4]> = (0..TINTS)
                    .flat_map(|t| self.field[(t * DEPTHS + d) * COSINES..][..COSINES].iter().copied())
                    .collect();
                entry(&rows, tint, light)
            };
            of(d).lerp(of(d + 1), d_part)
        })
    }

    /// Radiance that undercoat at an optical depth `tau` towards a light of cosine `light` to the normal sends to a view of cosine
    /// `view`, by its extinction, of light scattered before, for an irradiance of 1.
    pub fn sent_radiance(&self, tint: Vec3, tau: f32, light: f32, view: f32) -> Vec3 {
        let (d, d_part) = place((tau / DEEPEST).sqrt(), DEPTHS);
        let (l, l_part) = place(light, COSINES);
        let (v, v_part) = place(0.5 * view + 0.5, COSINES);
        let mix = |a: f32, b: f32, x: f32| a + (b - a) * x;
        tint.map(|tint| {
            let (t, t_part) = tint_place(tint);
            let at = |t: usize, v: usize, d: usize| {
                let row = &self.sent[((t * COSINES + v) * DEPTHS + d) * COSINES..];
                mix(row[l], row[l + 1], l_part)
            };
            let of_view = |t: usize, v: usize| mix(at(t, v, d), at(t, v, d + 1), d_part);
            let of_tint = |t: usize| mix(of_view(t, v), of_view(t, v + 1), v_part);
            mix(of_tint(t), of_tint(t + 1), t_part)
        })
    }

    /// Mean radiance of a field.
    pub fn field_mean(&self, field: &Field) -> Vec3 {
        Vec3::from_array(field.map(|f| f.dot(Vec4::from(self.share))))
    }

    /// Slope of a field's radiance over the cosine to the normal.
    pub fn field_slope(&self, field: &Field) -> Vec3 {
        Vec3::from_array(field.map(|f| 1.5 * f.dot(Vec4::from(self.flux))))
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

    /// Radiance that a guard hair sends to `view` where the field has this mean, and this slope along `normal`.
    pub fn guard_response(
        &self,
        tint: Vec3,
        tangent: Vec3,
        view: Vec3,
        normal: Vec3,
        [mean, slope]: [Vec3; 2],
    ) -> Vec3 {
        let sin_o = tangent.dot(view);
        let across = (view - sin_o * tangent + 1e-6 * normal).normalize();
        let at = place(0.5 * sin_o + 0.5, COSINES);
        let axis = Vec4::new(0.0, tangent.dot(normal), across.dot(normal), 0.0);
        Vec3::from_array([0, 1, 2].map(|c| {
            let entry = entry(&self.guard, tint[c], at);
            (entry.x * mean[c] + entry.dot(axis) * slope[c]).max(0.0)
        }))
    }
}
