//! Means of groom parameters over the skin: one texture serves all of it.

use crate::shellfin::uv_area;
use bytemuck::Zeroable;
use glam::{DVec3, Vec2, Vec3, Vec4};
use pelage_core::World;
use pelage_fur::groom::pack_parameters;
use pelage_fur::layout::{self, Groom, GuardHairs};
use pelage_fur::parameters::{Blend, Maps, Parameter, SkinPoint, triangle_point};
use pelage_fur::random::{even_barycentric, hash2, r2, random};

/// Approximate number of points of the skin at which maps are read.
const SAMPLES: usize = 20_000;

/// Points distributed over the skin by area.
pub(super) struct SkinSamples<'a> {
    world: &'a World,
    groom: Groom,
    texels: Vec<[u32; 2]>,
    /// Points, each with the area that it represents, cm².
    places: Vec<(SkinPoint, f64)>,
}

impl<'a> SkinSamples<'a> {
    /// At least one point on each triangle, more on larger ones.
    // [Roberts2018], [Turk1990]
    pub fn new(world: &'a World) -> Self {
        let skin = &world.skin;
        let total = skin.area().max(1e-30);
        let mut places = Vec::new();
        for t in 0..skin.triangles.len() {
            let area = f64::from(skin.triangle_area(t));
            let n = ((area / total * SAMPLES as f64).round() as u32).max(1);
            let seed = hash2(0x6d65_616e, t as u32);
            let start = Vec2::new(random(seed, 0), random(seed, 1));
            for k in 0..n {
                let lambda = even_barycentric(r2(start, k));
                let at = triangle_point(skin, t, lambda);
                places.push((at, area / f64::from(n)));
            }
        }
        let (groom, texels, _) = pack_parameters(world, None);
        Self { world, groom, texels, places }
    }

    fn mean(&self, of: impl Fn(&Maps<'_>, &SkinPoint) -> Vec3) -> Vec3 {
        let maps = Maps { groom: &self.groom, texels: &self.texels };
        let (mut sum, mut area) = (DVec3::ZERO, 0.0);
        for (at, weight) in &self.places {
            sum += *weight * of(&maps, at).as_dvec3();
            area += weight;
        }
        if area > 0.0 { (sum / area).as_vec3() } else { Vec3::ONE }
    }

    /// A parameter that is the same everywhere.
    fn constant(&self, parameter: Parameter) -> Option<&layout::Parameter> {
        let own = &self.groom.coats[0].parameters[parameter as usize];
        (self.groom.count == 1 && own.source == 0).then_some(own)
    }

    /// Mean of a scalar parameter, at least 0.
    pub fn scalar(&self, parameter: Parameter) -> f32 {
        let value = match self.constant(parameter) {
            Some(constant) => constant.value[0] + constant.offset,
            None => self.mean(|maps, at| Vec3::splat(maps.scalar(parameter, at))).x,
        };
        value.max(0.0)
    }

    /// Mean of a colour parameter.
    pub fn color(&self, parameter: Parameter) -> Vec3 {
        match self.constant(parameter) {
            Some(constant) => Vec4::from(constant.value).truncate(),
            None => self.mean(|maps, at| maps.color(parameter, at)),
        }
    }

    /// The groom with the parameters of the guard hairs constant at their means.
    pub fn mean_groom(&self) -> Groom {
        let mut groom = Groom { count: 1, ..self.groom };
        let mean = &mut groom.coats[0];
        if self.groom.count > 1 {
            mean.hairs = self.mean_hairs();
        }
        let mut set = |parameter: Parameter, value: Vec3| {
            mean.parameters[parameter as usize] = layout::Parameter {
                value: value.extend(1.0).to_array(),
                size: [1; 2],
                ..layout::Parameter::zeroed()
            };
        };
        for parameter in [
            Parameter::GuardDensity,
            Parameter::GuardLength,
            Parameter::GuardThickness,
            Parameter::GuardComb,
            Parameter::GuardClump,
            Parameter::GuardCurl,
            Parameter::GuardFrizz,
        ] {
            set(parameter, Vec3::splat(self.scalar(parameter)));
        }
        for parameter in [Parameter::GuardColorRoot, Parameter::GuardColorTip] {
            set(parameter, self.color(parameter));
        }
        if self.groom.count > 1 {
            // The mean lean of parts that are combed differently, not the mean of its factors.
            let lean = self.mean(|maps, at| maps.combed_lean(at, Vec3::ZERO));
            set(Parameter::GuardComb, Vec3::splat(lean.length()));
            mean.hairs.comb_direction = lean.normalize_or_zero().to_array();
        }
        groom
    }

    /// Mean over the skin of what describes guard hairs without maps.
    fn mean_hairs(&self) -> GuardHairs {
        let maps = Maps { groom: &self.groom, texels: &self.texels };
        let (mut mean, mut area) = (self.groom.coats[0].hairs, 0.0);
        for (at, weight) in &self.places {
            area += weight;
            mean = mean.over(maps.hairs_at(at), (weight / area.max(1e-30)) as f32);
        }
        mean
    }

    /// Mean of a function of the face normal over the skin's area.
    pub fn over_normals(&self, f: impl Fn(Vec3) -> f32) -> f32 {
        let skin = &self.world.skin;
        let (mut sum, mut area) = (0.0, 0.0);
        for t in 0..skin.triangles.len() {
            let [a, b, c] = skin.corners(t);
            if let Some(normal) = (b - a).cross(c - a).try_normalize() {
                sum += f64::from(skin.triangle_area(t)) * f64::from(f(normal));
                area += f64::from(skin.triangle_area(t));
            }
        }
        (sum / area.max(1e-30)) as f32
    }

    /// Length of one unit of uv on the skin, cm; `None` without uv.
    pub fn uv_unit(&self) -> Option<f32> {
        let skin = &self.world.skin;
        let flat = uv_area(skin)?;
        (flat > 0.0).then(|| (skin.area() / flat).sqrt() as f32)
    }
}
