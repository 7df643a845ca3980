//! Twin of `shaders/shared/material.wgsl`: the material of objects, metallic-roughness with a clear
//! coat.
//!
//! Directions are unit vectors that leave the surface: `n` its normal, `v` towards the viewer, `l`
//! towards the light. The index of refraction is 1.5.
// [GLTF2] appendix B, KHR_materials_clearcoat

use crate::strand_curve::{side_at, sides};
use glam::{Vec2, Vec3};
use pelage_core::World;
use pelage_core::film::tonemap::luminance;
use std::f32::consts::{PI, TAU};

/// A material at a point of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Base colour, linear RGB in 0..1.
    pub color: Vec3,
    /// Roughness, 0..1.
    pub roughness: f32,
    /// 0: dielectric, 1: metal.
    pub metallic: f32,
    /// Strength of the clear coat, 0..1.
    pub clearcoat: f32,
    /// Roughness of the clear coat, 0..1.
    pub clearcoat_roughness: f32,
}

/// Reflectance of a dielectric at normal incidence.
const DIELECTRIC: f32 = 0.04;

/// Mean over the hemisphere of 1 minus the reflectance of a dielectric, weighted by the cosine.
const ENTERING: f32 = 1.0 - (DIELECTRIC + (1.0 - DIELECTRIC) / 21.0);

/// Least width of a lobe, about that of the sun's disc: directional lights are points.
const LEAST_ALPHA: f32 = 0.01;

/// Least cosine towards the viewer.
const LEAST_COSINE: f32 = 1e-3;

/// Width of a GGX lobe for light that comes from within `spread` radians (as seen by the half
/// vector) of its direction.
fn width(roughness: f32, spread: f32) -> f32 {
    let alpha = (roughness * roughness).max(LEAST_ALPHA);
    (alpha * alpha + spread * spread).sqrt().min(1.0)
}

/// For each light of a world, half the angular radius of the part of the sky that it stands for,
/// radians; 0 for lights that are not of the environment. Lobes are widened by it, and shadow rays
/// spread over twice as much, so that objects show a blurred sky rather than points, and have soft
/// shadows. The radius is half the angle to the nearest other light, at most that of an equal part.
pub fn spreads(world: &World) -> Vec<f32> {
    let of_sky: Vec<Vec3> = world.lights.iter().filter(|l| l.environment).map(|l| l.direction).collect();
    let equal = (1.0 - 2.0 / of_sky.len().max(1) as f32).acos();
    let radius = |direction: Vec3| {
        let angles = of_sky.iter().filter(|d| **d != direction).map(|d| d.angle_between(direction));
        angles.fold(2.0 * equal, f32::min) / 2.0
    };
    world.lights.iter().map(|l| if l.environment { 0.5 * radius(l.direction) } else { 0.0 }).collect()
}

/// A direction from the part of the sky that a light stands for, mirrored to above the surface.
pub fn within_light(l: Vec3, spread: f32, [u, v]: [f32; 2], up: Vec3) -> Vec3 {
    if spread == 0.0 {
        return l;
    }
    let cosine = 1.0 - u * (1.0 - (2.0 * spread).cos());
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let d = cosine * l + sine * side_at(sides(l), TAU * v);
    d - 2.0 * d.dot(up).min(0.0) * up
}

/// Reflectance by Schlick's approximation.
fn schlick(f0: Vec3, cos: f32) -> Vec3 {
    f0 + (Vec3::ONE - f0) * (1.0 - cos).clamp(0.0, 1.0).powi(5)
}

fn dielectric(cos: f32) -> f32 {
    DIELECTRIC + (1.0 - DIELECTRIC) * (1.0 - cos).clamp(0.0, 1.0).powi(5)
}

/// Density of half vectors.
fn ggx(nh: f32, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let d = nh * nh * (a2 - 1.0) + 1.0;
    a2 / (PI * d * d).max(1e-20)
}

/// Height-correlated masking and shadowing over 4 nl nv.
fn visibility(nl: f32, nv: f32, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let l = nv * (nl * nl * (1.0 - a2) + a2).sqrt();
    let v = nl * (nv * nv * (1.0 - a2) + a2).sqrt();
    0.5 / (l + v).max(1e-10)
}

impl Material {
    /// Scattering from `l` to `v`, 1/sr, without the cosine of incidence; 0 for light from below.
    /// `spread` as from [`spreads`], 0 for a light that is a point.
    pub fn evaluate(&self, n: Vec3, v: Vec3, l: Vec3, spread: f32) -> Vec3 {
        let nl = n.dot(l);
        let nv = n.dot(v).max(LEAST_COSINE);
        if nl <= 0.0 {
            return Vec3::ZERO;
        }
        let h = (v + l).normalize_or(n);
        let nh = n.dot(h).clamp(0.0, 1.0);
        let vh = v.dot(h).clamp(0.0, 1.0);
        let f0 = Vec3::splat(DIELECTRIC).lerp(self.color, self.metallic);
        let alpha = width(self.roughness, spread);
        let specular = schlick(f0, vh) * (ggx(nh, alpha) * visibility(nl, nv, alpha));
        // Light that enters and leaves: coupled to the reflection, so that no energy is made.
        let inside = (1.0 - dielectric(nl)) * (1.0 - dielectric(nv)) / (ENTERING * PI);
        let diffuse = self.color * ((1.0 - self.metallic) * inside);
        let coat_alpha = width(self.clearcoat_roughness, spread);
        let coat = ggx(nh, coat_alpha) * visibility(nl, nv, coat_alpha);
        (diffuse + specular).lerp(Vec3::splat(coat), self.clearcoat * dielectric(nv))
    }

    /// Chances of the diffuse, the specular and the coat's lobe.
    fn chances(&self, nv: f32) -> [f32; 3] {
        let coat = self.clearcoat * dielectric(nv);
        let f0 = Vec3::splat(DIELECTRIC).lerp(self.color, self.metallic);
        let specular = (1.0 - coat) * luminance(schlick(f0, nv)).max(0.01);
        let diffuse = (1.0 - coat) * (1.0 - self.metallic) * luminance(self.color);
        let sum = diffuse + specular + coat;
        [diffuse / sum, specular / sum, coat / sum]
    }

    /// Density with which [`Material::sample`] draws `l`, 1/sr.
    pub fn pdf(&self, n: Vec3, v: Vec3, l: Vec3) -> f32 {
        let (nl, nv) = (n.dot(l), n.dot(v).max(LEAST_COSINE));
        if nl <= 0.0 {
            return 0.0;
        }
        let nh = n.dot((v + l).normalize_or(n)).clamp(0.0, 1.0);
        let visible = |roughness: f32| {
            let alpha = width(roughness, 0.0);
            let a2 = alpha * alpha;
            0.5 * ggx(nh, alpha) / (nv + (a2 + (1.0 - a2) * nv * nv).sqrt())
        };
        let [diffuse, specular, coat] = self.chances(nv);
        diffuse * nl / PI + specular * visible(self.roughness) + coat * visible(self.clearcoat_roughness)
    }

    /// Draws a direction towards the light: the direction, its density (1/sr), and the weight of
    /// radiance from there. `None` if it lies below the surface.
    pub fn sample(&self, n: Vec3, v: Vec3, [pick, u1, u2]: [f32; 3]) -> Option<(Vec3, f32, Vec3)> {
        let (side, other) = n.any_orthonormal_pair();
        let nv = n.dot(v).max(LEAST_COSINE);
        let [diffuse, specular, _] = self.chances(nv);
        let world = |d: Vec3| (d.x * side + d.y * other + d.z * n).normalize();
        let l = if pick < diffuse {
            let (sin, cos) = (TAU * u2).sin_cos();
            let r = u1.sqrt();
            world(Vec3::new(r * cos, r * sin, (1.0 - u1).max(0.0).sqrt()))
        } else {
            let roughness = if pick < diffuse + specular { self.roughness } else { self.clearcoat_roughness };
            let local = Vec3::new(v.dot(side), v.dot(other), nv).normalize();
            let h = world(visible_half_vector(local, width(roughness, 0.0), Vec2::new(u1, u2)));
            2.0 * v.dot(h) * h - v
        };
        let pdf = self.pdf(n, v, l);
        (pdf > 0.0).then(|| (l, pdf, self.evaluate(n, v, l, 0.0) * (n.dot(l) / pdf)))
    }
}

/// A half vector drawn from those that `v` sees; the normal is z.
// [DupuyBenyoub2023]
fn visible_half_vector(v: Vec3, alpha: f32, u: Vec2) -> Vec3 {
    let stretched = Vec3::new(alpha * v.x, alpha * v.y, v.z).normalize();
    let (sin, cos) = (TAU * u.x).sin_cos();
    let z = (1.0 - u.y) * (1.0 + stretched.z) - stretched.z;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let h = Vec3::new(r * cos, r * sin, z) + stretched;
    Vec3::new(alpha * h.x, alpha * h.y, h.z.max(1e-6)).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::random;

    fn materials() -> Vec<Material> {
        let mut all = Vec::new();
        for roughness in [0.0, 0.2, 0.5, 1.0] {
            for (metallic, clearcoat) in [(0.0, 0.0), (1.0, 0.0), (0.5, 0.5), (0.0, 1.0), (1.0, 1.0)] {
                let color = Vec3::ONE;
                all.push(Material { color, roughness, metallic, clearcoat, clearcoat_roughness: 0.1 });
            }
        }
        all
    }

    fn view(cos: f32) -> Vec3 {
        Vec3::new((1.0f32 - cos * cos).sqrt(), 0.0, cos)
    }

    /// A white furnace: no material reflects more than it receives, and a white dielectric little
    /// less.
    #[test]
    fn the_albedo_is_at_most_one() {
        let n = 20_000;
        for material in materials() {
            for cos in [0.05, 0.2, 0.5, 0.8, 1.0] {
                let sum: f32 = (0..n)
                    .filter_map(|i| {
                        let u = [random(1, i), random(2, i), random(3, i)];
                        material.sample(Vec3::Z, view(cos), u).map(|(_, _, w)| w.y)
                    })
                    .sum();
                let albedo = sum / n as f32;
                assert!(albedo < 1.012, "{material:?} at {cos}: {albedo}");
                if material.roughness <= 0.2 && cos >= 0.5 {
                    assert!(albedo > 0.93, "{material:?} at {cos}: {albedo}");
                }
            }
        }
    }

    /// The weights of samples agree with an integral over directions drawn evenly, and the density
    /// integrates to the share of samples that leave.
    #[test]
    fn samples_agree_with_the_integral() {
        let n = 100_000;
        for material in materials().into_iter().filter(|m| m.roughness >= 0.5 && m.clearcoat == 0.0) {
            for cos in [0.3, 0.9] {
                let v = view(cos);
                let (mut integral, mut density, mut sampled, mut kept) = (0.0, 0.0, 0.0, 0.0);
                for i in 0..n {
                    let z = random(4, i);
                    let (sin, x) = (TAU * random(5, i)).sin_cos();
                    let r = (1.0 - z * z).sqrt();
                    let l = Vec3::new(r * x, r * sin, z);
                    integral += material.evaluate(Vec3::Z, v, l, 0.0).y * z * TAU / n as f32;
                    density += material.pdf(Vec3::Z, v, l) * TAU / n as f32;
                    if let Some((_, _, w)) =
                        material.sample(Vec3::Z, v, [random(6, i), random(7, i), random(8, i)])
                    {
                        sampled += w.y / n as f32;
                        kept += 1.0 / n as f32;
                    }
                }
                assert!((integral - sampled).abs() < 0.015, "{material:?} {cos}: {integral} {sampled}");
                assert!((density - kept).abs() < 0.015, "{material:?} {cos}: {density} {kept}");
            }
        }
    }
}
