//! Twin of `shaders/undercoat_source.wgsl`: the light that the march and the skin look up.

use crate::twin::film::halves;
use crate::twin::lattice::{node_index, unpack_albedo};
use glam::Vec3;
use pelage_core::scene::MultipleModel;
use pelage_fur::Layer;
use pelage_fur::fibre::Fibre;
use pelage_fur::groom::tau_pairs;
use pelage_fur::layout::{Column, Frame, FurParameters, Light};
use pelage_fur::shell::{Place, Shell};
use pelage_fur::undercoat::{color, mean_color, scatter};
use pelage_transport::Table;
use pelage_transport::lookup::Field;
use std::f32::consts::FRAC_1_PI;

/// Light at a node of the lattice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Source {
    /// log2 of the scattered radiance per extinction, of all lights except the key lights and of
    /// multiple scattering; for Kajiya-Kay per colour. At least log2 of 1e-7.
    pub log_ambient: Vec3,
    /// Density of the undercoat relative to that in `fur.undercoat.extinction`.
    pub density: f32,
    /// Optical depths towards the key lights.
    pub key_tau: [f32; 2],
    /// Single-scattering albedo.
    pub albedo: Vec3,
}

/// Unpacks an entry of the buffer `node_light`.
pub fn unpack(words: [u32; 4]) -> Source {
    let [r, g] = halves(words[0]);
    let [b, density] = halves(words[1]);
    Source {
        log_ambient: Vec3::new(r, g, b),
        density,
        key_tau: halves(words[2]),
        albedo: unpack_albedo(words[3]),
    }
}

/// Inputs of the pass.
#[derive(Clone, Copy)]
pub struct Lattice<'a> {
    /// Parameters of undercoat, lattice and lights.
    pub fur: &'a FurParameters,
    /// The shell.
    pub shell: &'a Shell,
    /// All lights.
    pub lights: &'a [Light],
    /// The columns.
    pub columns: &'a [Column],
    /// The buffer `tau`: optical depths, pairs of halves.
    pub tau: &'a [u32],
    /// The frame globals.
    pub frame: &'a Frame,
    /// Fibre model of the undercoat.
    pub undercoat_fibre: &'a Fibre,
    /// Model of multiple scattering.
    pub multiple: MultipleModel,
    /// Its table, if it has one.
    pub table: Option<&'a Table>,
}

impl Lattice<'_> {
    /// Optical depth from a node towards a light, or towards the camera (the number after the last
    /// light).
    pub fn tau(&self, node: u32, light: u32) -> f32 {
        halves(self.tau[(node * self.fur.lattice.tau_stride + light / 2) as usize])[light as usize & 1]
    }

    /// Mean scattered radiance at a node, from above and from below.
    pub fn scattered(&self, node: u32) -> [Vec3; 2] {
        let first = (node * self.fur.lattice.tau_stride + tau_pairs(self.fur.lights.count)) as usize;
        let [[a, b], [c, d], [e, f]] = [0, 1, 2].map(|k| halves(self.tau[first + k]));
        [Vec3::new(a, b, c), Vec3::new(d, e, f)]
    }

    /// Scattered radiance at a node from all lights that light the undercoat, for fur of this
    /// albedo; zero except with transport.
    pub fn field(&self, node: u32, normal: Vec3, albedo: Vec3) -> Field {
        let mut field = Field::default();
        if let (MultipleModel::Transport, Some(table)) = (self.multiple, self.table) {
            for (j, light) in (0..self.fur.lights.count).zip(self.lights).filter(|(_, l)| l.undercoat == 1) {
                let mu = normal.dot(Vec3::from(light.direction));
                let of_light = table.scattered_field(albedo, self.tau(node, j), mu);
                (0..3).for_each(|c| field[c] += light.irradiance[c] * of_light[c]);
            }
        }
        field
    }

    /// Sum of [`Table::sent_radiance`] over all lights that light the undercoat, at level `level`
    /// of a column; zero except with transport.
    pub fn sent(&self, column: u32, level: u32, place: &Place) -> [Vec3; 3] {
        let mut sent = [Vec3::ZERO; 3];
        if let (MultipleModel::Transport, Some(table)) = (self.multiple, self.table) {
            let height = level as f32 / self.fur.lattice.levels as f32 * self.fur.lattice.reach;
            let view = (Vec3::from(self.frame.eye) - place.point(height, place.lambda)).normalize();
            let normal = self.normal(place);
            let albedo = mean_albedo(self.undercoat_fibre, &self.columns[column as usize]);
            let node = node_index(self.fur, column, level);
            for (j, light) in (0..self.fur.lights.count).zip(self.lights).filter(|(_, l)| l.undercoat == 1) {
                let mu = normal.dot(Vec3::from(light.direction));
                let of_light = table.sent_radiance(albedo, self.tau(node, j), mu, normal.dot(view));
                (0..3).for_each(|k| sent[k] += Vec3::from(light.irradiance) * of_light[k]);
            }
        }
        sent
    }

    /// Interpolated unit normal of the skin.
    fn normal(&self, place: &Place) -> Vec3 {
        let n = place.vertices.map(|v| Vec3::from(self.shell.vertices[v as usize].normal));
        (place.lambda.x * n[0] + place.lambda.y * n[1] + place.lambda.z * n[2]).normalize()
    }

    /// Light at level `level` of a column at `place`.
    // [Wyman1989] for the forward scattering
    pub fn source(&self, column: u32, level: u32, place: &Place) -> Source {
        let fur = self.fur;
        let of_column = &self.columns[column as usize];
        let height = level as f32 / fur.lattice.levels as f32 * fur.lattice.reach;
        let t = height.min(1.0);
        let x = place.point(height, place.lambda);
        let tangent = (self.normal(place) + Vec3::from(fur.undercoat.lean) * t).normalize();
        let view = (Vec3::from(self.frame.eye) - x).normalize();
        let albedo = unpack_albedo(of_column.color_root).lerp(unpack_albedo(of_column.color_tip), t);
        let attenuation = 1.0 - fur.undercoat.forward_scattering * albedo;
        let node = node_index(fur, column, level);
        let keys = &fur.lights.key_lights[..fur.lights.keys as usize];
        let mut ambient = Vec3::ZERO;
        for (j, light) in (0..fur.lights.count).zip(self.lights) {
            if light.undercoat == 1 && !keys.contains(&j) {
                let through = (-self.tau(node, j) * attenuation).exp();
                let l = Vec3::from(light.direction);
                ambient += Vec3::from(light.irradiance)
                    * through
                    * scatter(self.undercoat_fibre, tangent, l, view, albedo);
            }
        }
        let mut scattered = Vec3::ZERO;
        match (self.multiple, self.table) {
            (MultipleModel::Transport, Some(_)) => scattered = self.sent(column, level, place)[0],
            (MultipleModel::Dual, Some(table)) => {
                for (j, light) in (0..fur.lights.count).zip(self.lights).filter(|(_, l)| l.undercoat == 1) {
                    let l = Vec3::from(light.direction);
                    let of_light =
                        table.dual_scatter(Layer::Undercoat, albedo, tangent, l, view, self.tau(node, j));
                    scattered += Vec3::from(light.irradiance) * of_light;
                }
            }
            _ => {}
        }
        ambient += scattered / color(self.undercoat_fibre, albedo).max(Vec3::splat(1e-3));
        let mut key_tau = [0.0; 2];
        key_tau.iter_mut().zip(keys).for_each(|(tau, j)| *tau = self.tau(node, *j));
        Source {
            log_ambient: Vec3::from(ambient.max(Vec3::splat(1e-7)).to_array().map(f32::log2)),
            density: of_column.density,
            key_tau,
            albedo,
        }
    }

    /// Radiance of the Lambertian skin below a column.
    pub fn base_light(&self, column: u32, place: &Place) -> Vec3 {
        let of_column = &self.columns[column as usize];
        let normal = self.normal(place);
        let attenuation = 1.0 - self.fur.undercoat.forward_scattering * unpack_albedo(of_column.color_root);
        let node = node_index(self.fur, column, 0);
        let mut sum = Vec3::ZERO;
        for (j, light) in (0..self.fur.lights.count).zip(self.lights) {
            let facing = normal.dot(Vec3::from(light.direction)).max(0.0);
            sum += Vec3::from(light.irradiance) * facing * (-self.tau(node, j) * attenuation).exp();
        }
        if let Some(table) = self.table {
            let field = self.field(node, normal, mean_albedo(self.undercoat_fibre, of_column));
            sum += table.field_irradiance(&field);
        }
        sum * unpack_albedo(of_column.color_base) * FRAC_1_PI
    }
}

/// Mean albedo of the undercoat's hairs between root and tip.
fn mean_albedo(fibre: &Fibre, column: &Column) -> Vec3 {
    let [a, b] = [column.color_root, column.color_tip].map(unpack_albedo);
    mean_color(fibre, a, b)
}
