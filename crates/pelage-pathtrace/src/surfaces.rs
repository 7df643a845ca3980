//! The surfaces that rays meet: the triangles of the skin and of the objects.
//!
//! Objects block rays as the skin does and shade both sides alike. A shadow catcher is seen by rays
//! from the camera alone: it blocks no light, neither from lights nor between hairs.

use super::bvh::{Bounds, Bvh, Part, Ray, Stack};
use super::surface::{Scattering, SurfaceShading};
use glam::{Vec3, Vec3A};
use pelage_core::{Error, Result, Skin, World};
use pelage_fur::groom::{self, PackedGroom};
use pelage_fur::material::Material;
use pelage_fur::parameters::{Maps, Parameter, triangle_point};

/// Skin and objects.
pub struct Surfaces {
    /// The skin, then the objects in the order of the scene.
    meshes: Vec<Mesh>,
    /// Positions of all meshes, cm, and the corners of all triangles in them.
    positions: Vec<Vec3>,
    corners: Vec<[u32; 3]>,
    opaque: Bvh,
    catchers: Bvh,
    groom: Box<PackedGroom>,
}

/// A mesh, whose triangles are numbered from `first` on.
struct Mesh {
    first: u32,
    surface: Skin,
    object: Option<Object>,
}

/// What an object has besides its surface.
struct Object {
    /// Its material, without the colour.
    material: Material,
    /// Translation of its mesh, cm.
    origin: [f32; 3],
    shadow_catcher: bool,
}

/// Distance that keeps rays off the triangle of the skin that they leave, relative to the size of
/// the coordinates.
const SKIN_OFFSET: f32 = 2e-6;

/// The same for objects, whose triangles may be large.
const OBJECT_OFFSET: f32 = 4e-6;

/// Where a ray meets a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurfaceHit {
    triangle: u32,
    /// Barycentric coordinates of corners 1 and 2.
    lambda: [f32; 2],
    /// Whether the ray comes from outside.
    pub front: bool,
}

/// Peak memory of [`Surfaces::new`] for the meshes of `world`, bytes.
pub(super) fn bytes_of(world: &World) -> u64 {
    let of = |surface: &Skin| {
        let triangles = surface.triangles.len() as u64 * (super::bvh::BYTES_A_PART + 2 * 12 + 24 + 4);
        triangles + surface.positions.len() as u64 * (2 * 12 + 2 * 12 + 4)
    };
    of(&world.skin) + world.objects.iter().map(|o| of(&o.surface)).sum::<u64>()
}

impl Surfaces {
    /// Builds the hierarchies over the skin and the objects of `world`.
    ///
    /// # Errors
    /// [`Error::Unsupported`] where there are 2³¹ triangles or more; as [`groom::pack`].
    pub fn new(world: &World) -> Result<Self> {
        if world.triangles() >= 1 << 31 {
            return Err(Error::Unsupported(format!(
                "found {} triangles in the skin and the objects, expected fewer than 2^31",
                world.triangles()
            )));
        }
        let mut all = Self {
            meshes: Vec::with_capacity(1 + world.objects.len()),
            positions: Vec::new(),
            corners: Vec::new(),
            opaque: Bvh::default(),
            catchers: Bvh::default(),
            groom: Box::new(groom::pack(world)?),
        };
        let (mut opaque, mut catchers) = (Vec::new(), Vec::new());
        let objects = world.objects.iter().map(|object| {
            let of = &object.material;
            let material = Material {
                color: Vec3::ZERO,
                roughness: of.roughness,
                metallic: of.metallic,
                clearcoat: of.clearcoat,
                clearcoat_roughness: of.clearcoat_roughness,
            };
            let (origin, shadow_catcher) = (object.origin, object.shadow_catcher);
            (&object.surface, Some(Object { material, origin, shadow_catcher }))
        });
        for (surface, object) in std::iter::once((&world.skin, None)).chain(objects) {
            let (first, vertex) = (all.corners.len() as u32, all.positions.len() as u32);
            all.positions.extend(&surface.positions);
            all.corners.extend(surface.triangles.iter().map(|t| t.map(|v| vertex + v)));
            let parts = (first..all.corners.len() as u32).map(|thing| Part { thing, part: 0, parts: 1 });
            let hidden = object.as_ref().is_some_and(|o| o.shadow_catcher);
            if hidden { &mut catchers } else { &mut opaque }.extend(parts);
            all.meshes.push(Mesh { first, surface: surface.clone(), object });
        }
        [all.opaque, all.catchers] = [opaque, catchers].map(|parts| Bvh::build(parts, |p| all.bounds_of(p)));
        Ok(all)
    }

    fn bounds_of(&self, part: Part) -> Bounds {
        let corners = self.corners_of(part.thing);
        // Rounding would let rays miss boxes without thickness.
        let pad = Vec3A::splat(1e-5);
        Bounds {
            low: corners[0].min(corners[1]).min(corners[2]) - pad,
            high: corners[0].max(corners[1]).max(corners[2]) + pad,
        }
    }

    fn corners_of(&self, triangle: u32) -> [Vec3A; 3] {
        self.corners[triangle as usize].map(|v| self.positions[v as usize].into())
    }

    /// Positions of all vertices, cm.
    pub fn positions(&self) -> &[Vec3] {
        &self.positions
    }

    /// Memory of the hierarchies, bytes.
    pub fn bytes(&self) -> u64 {
        self.opaque.bytes() + self.catchers.bytes()
    }

    /// Where a ray first meets the skin or an object that is no shadow catcher, and the distance,
    /// cm.
    pub fn closest(&self, ray: &Ray, stack: &mut Stack) -> Option<(SurfaceHit, f32)> {
        self.closest_in(&self.opaque, ray, f32::INFINITY, stack)
    }

    /// Where a ray first meets a shadow catcher before `limit`, and the distance, cm.
    pub fn closest_catcher(&self, ray: &Ray, limit: f32, stack: &mut Stack) -> Option<(SurfaceHit, f32)> {
        self.closest_in(&self.catchers, ray, limit, stack)
    }

    fn closest_in(&self, of: &Bvh, ray: &Ray, limit: f32, stack: &mut Stack) -> Option<(SurfaceHit, f32)> {
        let mut best = None;
        let t = of.walk(ray, limit, stack, |triangle, limit| match self.intersect(ray, triangle, limit) {
            Some((t, hit)) => {
                best = Some(hit);
                t
            }
            None => limit,
        });
        best.map(|hit| (hit, t))
    }

    /// Whether the skin or an object blocks a ray of unbounded length.
    pub fn blocked(&self, ray: &Ray, stack: &mut Stack) -> bool {
        let end = self.opaque.walk(ray, f32::INFINITY, stack, |triangle, limit| {
            self.intersect(ray, triangle, limit).map_or(limit, |_| -1.0)
        });
        end < 0.0
    }

    // [MollerTrumbore1997]
    fn intersect(&self, ray: &Ray, triangle: u32, limit: f32) -> Option<(f32, SurfaceHit)> {
        let [a, b, c] = self.corners_of(triangle);
        let (e1, e2) = (b - a, c - a);
        let p = ray.direction.cross(e2);
        let determinant = e1.dot(p);
        if determinant == 0.0 {
            return None;
        }
        let inverse = 1.0 / determinant;
        let s = ray.origin - a;
        let u = s.dot(p) * inverse;
        let q = s.cross(e1);
        let v = ray.direction.dot(q) * inverse;
        let t = e2.dot(q) * inverse;
        let met = u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < limit;
        met.then_some((t, SurfaceHit { triangle, lambda: [u, v], front: determinant > 0.0 }))
    }

    /// Shading data where `ray` meets a surface at `distance`, cm.
    pub fn shading(&self, hit: &SurfaceHit, ray: &Ray, distance: f32) -> SurfaceShading {
        let number = self.meshes.partition_point(|m| m.first <= hit.triangle) - 1;
        let mesh = &self.meshes[number];
        let triangle = (hit.triangle - mesh.first) as usize;
        let [l1, l2] = hit.lambda;
        let lambda = Vec3::new(1.0 - l1 - l2, l1, l2);
        let at = triangle_point(&mesh.surface, triangle, lambda);
        let maps = Maps { groom: &self.groom.groom, texels: &self.groom.texels };
        let corners = mesh.surface.corners(triangle);
        let [a, b, c] = corners;
        let flat = (b - a).cross(c - a).normalize_or(at.normal);
        let position = ray.origin + distance * ray.direction;
        let Some(object) = &mesh.object else {
            let color = maps.color(Parameter::BaseColor, &at).clamp(Vec3::ZERO, Vec3::ONE);
            return SurfaceShading {
                scattering: Scattering::Skin(color),
                normal: at.normal,
                geometric_normal: flat,
                position: position + (SKIN_OFFSET * (1.0 + position.abs().max_element())) * Vec3A::from(flat),
            };
        };
        let color = maps.color_of(&self.groom.objects[number - 1].color, &at, object.origin);
        let material = Material { color: color.clamp(Vec3::ZERO, Vec3::ONE), ..object.material };
        // Both sides are alike.
        let side = if hit.front { 1.0 } else { -1.0 };
        // Rays leave from the curved surface that the smoothed normals stand for: else a coarse
        // mesh would show its triangles where light grazes it. [Hanika2021]
        let x = Vec3::from(position);
        let below = |k: usize| {
            let normal = side * mesh.surface.normals[mesh.surface.triangles[triangle][k] as usize];
            lambda[k] * (x - corners[k]).dot(normal).min(0.0) * normal
        };
        let curved = x - (below(0) + below(1) + below(2));
        // The intersection with a large triangle is as inexact as its corners are far away.
        let largest = [x, a, b, c].into_iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
        SurfaceShading {
            scattering: match object.shadow_catcher {
                true => Scattering::ShadowCatcher,
                false => Scattering::Object(material),
            },
            normal: side * at.normal,
            geometric_normal: side * flat,
            position: Vec3A::from(curved + (OBJECT_OFFSET * (1.0 + largest)) * (side * flat)),
        }
    }
}
