//! Twin of `shaders/shellfin_rows.wgsl`: where the hair of a skin vertex passes a row above the
//! skin, and its light there.

use crate::shellfin::{bent, brush_weight, hair_curve, hair_lighting};
use glam::{Vec2, Vec3};
use pelage_core::scene::LightingTable;
use pelage_fur::fibre::table::MEAN_GLINT;
use pelage_fur::fibre::{Angles, Fibre, Hit};
use pelage_fur::layout::{Brush, Frame, FurParameters, Light, ShellRow, ShellVertex, Shellfin};
use pelage_fur::parameters::{Maps, MeshPlace, Parameter, SkinPoint, unpack_color};
use pelage_fur::strand_curve::{bezier, side_at, sides};
use pelage_fur::undercoat::scatter;
use pelage_render::twin::film::halves;
use std::f32::consts::{FRAC_PI_2, FRAC_PI_4};

/// Inputs of the pass.
pub struct Hair<'a> {
    /// Parameters of shells and fins.
    pub shellfin: &'a Shellfin,
    /// Parameters of undercoat, lattice and lights.
    pub fur: &'a FurParameters,
    /// Groom and maps.
    pub maps: Maps<'a>,
    /// All lights.
    pub lights: &'a [Light],
    /// Scattering model of the guard hairs.
    pub fibre: &'a Fibre,
    /// Scattering model of the undercoat.
    pub undercoat: &'a Fibre,
    /// Settings of the lighting table.
    pub table: &'a LightingTable,
    /// The skin's vertices.
    pub vertices: &'a [ShellVertex],
    /// uv of the skin's vertices.
    pub uv: &'a [[f32; 2]],
    /// Optical depths of the lattice, pairs of halves.
    pub tau: &'a [u32],
    /// Brush strokes.
    pub brushes: &'a [Brush],
    /// The view.
    pub frame: &'a Frame,
}

/// A vertex of a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowVertex {
    /// World space, cm.
    pub position: Vec3,
    /// Tangent of the guard hairs, unit.
    pub tangent: Vec3,
    /// Tangent of all other hair, unit.
    pub lean: Vec3,
    /// Radiance per unit colour of everything but guard hair.
    pub undercoat: Vec3,
    /// Radiance per unit colour of the guard hairs.
    pub guard: Vec3,
}

impl Hair<'_> {
    fn point(&self, v: usize) -> SkinPoint {
        let vertex = &self.vertices[v];
        SkinPoint {
            position: vertex.position.into(),
            normal: vertex.normal.into(),
            uv: Vec2::from(self.uv[v]),
            color: unpack_color(vertex.color),
            place: MeshPlace::Vertex(v as u32),
        }
    }

    /// Factor of the brush strokes on the light of vertex `v`.
    fn tint(&self, v: usize) -> Vec3 {
        let at = self.point(v).position;
        let strokes = self.brushes[..self.shellfin.brushes as usize].iter();
        strokes.fold(Vec3::ONE, |tint, brush| {
            tint * Vec3::ONE.lerp(brush.tint.into(), brush_weight(at, brush.center, brush.radius))
        })
    }

    /// Tangential lean of the hair of vertex `v`; its length is the tangent of the angle from the
    /// normal.
    pub fn lean(&self, v: usize) -> Vec3 {
        let at = self.point(v);
        let mut lean = Vec3::from(self.shellfin.comb);
        if self.shellfin.curved == 1 {
            lean += self.maps.combed_lean(&at, Vec3::ZERO);
        }
        for brush in &self.brushes[..self.shellfin.brushes as usize] {
            lean += brush_weight(at.position, brush.center, brush.radius) * Vec3::from(brush.direction);
        }
        lean.reject_from_normalized(at.normal)
    }

    /// Position of the hair at row height `s` relative to its root, in units of the fur's height.
    fn hair(&self, v: usize, s: f32) -> Vec3 {
        let n = Vec3::from(self.vertices[v].normal);
        let gravity = (self.shellfin.curved == 1).then(|| self.maps.hairs_at(&self.point(v)).gravity);
        let p = bezier(hair_curve(n, self.lean(v), gravity), s);
        bent(p, Vec3::from(self.shellfin.bend) * s.powi(3), n, s)
    }

    fn tau(&self, v: usize, height: f32, light: u32) -> f32 {
        let fur = self.fur;
        let x = (height / fur.lattice.reach).clamp(0.0, 1.0) * fur.lattice.levels as f32;
        let level = (x as u32).min(fur.lattice.levels - 1);
        let at = |level: u32| {
            let node = v as u32 * (fur.lattice.levels + 1) + level;
            halves(self.tau[(node * fur.lattice.tau_stride + light / 2) as usize])[light as usize & 1]
        };
        let f = x - level as f32;
        at(level) * (1.0 - f) + at(level + 1) * f
    }

    /// The hair of vertex `v` at a row: position, tangents and light.
    pub fn vertex(&self, v: usize, row: &ShellRow) -> RowVertex {
        let at = self.point(v);
        let n = at.normal;
        let mut length = self.shellfin.height * self.maps.scalar(Parameter::ShellLength, &at).max(0.0);
        if self.shellfin.curved == 1 {
            let whole = self.maps.scalar(Parameter::UndercoatHeight, &at).max(1e-4);
            length *= (self.vertices[v].height / whole).clamp(0.0, 1.0);
        }
        let offset = self.hair(v, row.height) * length;
        let position = at.position + offset;
        let along = self.hair(v, row.height + 0.02) - self.hair(v, (row.height - 0.02).max(0.0));
        let tangent = along.normalize();
        let view = (Vec3::from(self.frame.eye) - position).normalize();
        let lights = self.lights.iter().take(self.fur.lights.count as usize);
        let (mut undercoat, mut guard) = (Vec3::ZERO, Vec3::ZERO);
        let height = offset.dot(n) / self.vertices[v].height.max(1e-4);
        let lean = match self.shellfin.curved {
            1 => (n + Vec3::from(self.fur.undercoat.lean) * height.min(1.0)).normalize(),
            _ => tangent,
        };
        if self.shellfin.lighting == 1 {
            for light in lights {
                let l = Vec3::from(light.direction);
                let h = (l + view).normalize();
                undercoat += Vec3::from(light.irradiance)
                    * hair_lighting(self.table, tangent.dot(l), tangent.dot(h))
                    * row.shade;
            }
            undercoat *= self.tint(v);
            return RowVertex { position, tangent, lean, undercoat, guard: undercoat };
        }
        let sides = sides(tangent);
        for (j, light) in lights.enumerate() {
            let l = Vec3::from(light.direction);
            let depth = self.tau(v, height, j as u32);
            let through = |color: [f32; 3]| {
                let attenuation = 1.0 - self.fur.undercoat.forward_scattering * Vec3::from(color);
                Vec3::from(light.irradiance) * (-depth * attenuation).exp()
            };
            if light.undercoat == 1 {
                undercoat +=
                    through(row.undercoat) * scatter(self.undercoat, lean, l, view, row.undercoat.into());
            }
            if self.shellfin.guard == 1 {
                for k in 0..4 {
                    let turn = FRAC_PI_4 + FRAC_PI_2 * k as f32;
                    let t = (tangent - 1.25 * self.shellfin.spread * side_at(sides, turn)).normalize();
                    let scattered = self.fibre.scatter_far(
                        &Hit { tint: row.guard.into(), glint_angle: MEAN_GLINT, h: 0.0 },
                        &Angles::around(t, l, view),
                    );
                    guard += 0.25 * through(row.guard) * scattered;
                }
            }
        }
        let guard = guard / Vec3::from(row.guard).max(Vec3::splat(1e-3));
        if !matches!(self.undercoat, Fibre::KajiyaKay(_)) {
            undercoat /= Vec3::from(row.undercoat).max(Vec3::splat(1e-3));
        }
        let tint = self.tint(v);
        RowVertex { position, tangent, lean, undercoat: undercoat * tint, guard: guard * tint }
    }
}

/// Unpacks a vertex from its buffers.
pub fn unpack(position: [f32; 4], light: [u32; 4]) -> RowVertex {
    let [x, y, z, tangent] = position;
    let [r, g] = halves(light[0]);
    let [b, guard_r] = halves(light[1]);
    let [guard_g, guard_b] = halves(light[2]);
    RowVertex {
        position: Vec3::new(x, y, z),
        tangent: unit(tangent.to_bits()),
        lean: unit(light[3]),
        undercoat: Vec3::new(r, g, b),
        guard: Vec3::new(guard_r, guard_g, guard_b),
    }
}

/// Unpacks a unit vector from two signed normalised 16-bit integers.
// [Meyer2010]
fn unit(word: u32) -> Vec3 {
    let halves = [word as u16, (word >> 16) as u16].map(|half| (f32::from(half as i16) / 32767.0).max(-1.0));
    pelage_fur::octahedral::decode(Vec2::from(halves))
}
