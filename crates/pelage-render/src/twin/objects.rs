//! Twin of `shaders/objects.wgsl`: the light on objects, with shadow rays that test every triangle
//! in double precision.

use crate::prepare::FurCells;
use crate::twin::base_raster::{Base, plane_depth};
use crate::twin::film::halves;
use crate::twin::light_occlusion::hit;
use glam::{Mat3, Vec3};
use pelage_core::World;
use pelage_core::film::tonemap::luminance;
use pelage_fur::groom::PackedGroom;
use pelage_fur::layout::Frame;
use pelage_fur::material::{Material, within_light};
use pelage_fur::parameters::{Maps, triangle_point};
use pelage_fur::random::{hash2, random};
use pelage_fur::view::sample_ray;

/// Distance that keeps shadow rays off their triangle, relative to the size of the coordinates.
const OFFSET: f32 = 4e-6;

/// What lights and darkens objects.
pub struct Surroundings<'a> {
    /// The objects.
    pub world: &'a World,
    /// Their materials, maps, and the lights.
    pub packed: &'a PackedGroom,
    /// The fur.
    pub fur: &'a FurCells,
    /// Corners of the triangles that block light, cm.
    pub blockers: Vec<[Vec3; 3]>,
}

/// An object at a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shaded {
    /// Depth, radiance, normal and transparency.
    pub base: Base,
    /// Base colour, black on a shadow catcher.
    pub albedo: Vec3,
}

impl<'a> Surroundings<'a> {
    /// The surroundings of objects in a world with this fur.
    pub fn new(world: &'a World, packed: &'a PackedGroom, fur: &'a FurCells) -> Self {
        let objects = world.objects.iter().filter(|o| !o.shadow_catcher).map(|o| &o.surface);
        let blockers = std::iter::once(&world.skin)
            .chain(objects)
            .flat_map(|surface| (0..surface.triangles.len()).map(|t| surface.corners(t)))
            .collect();
        Self { world, packed, fur, blockers }
    }

    /// Object and triangle of it by the number of a triangle behind those of the skin.
    pub fn place_of(&self, number: usize) -> Option<(usize, usize)> {
        let mut rest = number;
        for (object, of) in self.world.objects.iter().enumerate() {
            match rest.checked_sub(of.surface.triangles.len()) {
                None => return Some((object, rest)),
                Some(behind) => rest = behind,
            }
        }
        None
    }

    /// Share of the light along `ray` that reaches `origin` past skin and objects: 0 or 1.
    pub fn open(&self, origin: Vec3, ray: Vec3) -> bool {
        !self.blockers.iter().any(|corners| hit(*corners, origin, ray).is_some())
    }

    /// Shades sample `xy` of a tile, at which a triangle of an object is nearest.
    pub fn shade(&self, frame: &Frame, (object, triangle): (usize, usize), xy: [u32; 2]) -> Shaded {
        let of = &self.world.objects[object];
        let packed = &self.packed.objects[object];
        let surface = &of.surface;
        let corners = surface.corners(triangle);
        let ray = sample_ray(frame, xy);
        let z = plane_depth(frame, corners, ray);
        let x = Vec3::from(frame.eye) + z * ray;
        let [a, b, c] = corners;
        let n = (b - a).cross(c - a);
        let part = |p: Vec3, q: Vec3| (p - x).cross(q - x).dot(n) / n.length_squared();
        let lambda = Vec3::new(part(b, c), part(c, a), part(a, b));
        let at = triangle_point(surface, triangle, lambda);
        let maps = Maps { groom: &self.packed.groom, texels: &self.packed.texels };
        let color = maps.color_of(&packed.color, &at, of.origin).clamp(Vec3::ZERO, Vec3::ONE);
        let spec = &of.material;
        let material = Material {
            color,
            roughness: spec.roughness,
            metallic: spec.metallic,
            clearcoat: spec.clearcoat,
            clearcoat_roughness: spec.clearcoat_roughness,
        };
        let view = -ray.normalize();
        let outside = if n.dot(view) > 0.0 { 1.0 } else { -1.0 };
        let normal = outside * at.normal;
        // [Hanika2021]
        let normals = surface.triangles[triangle].map(|v| outside * surface.normals[v as usize]);
        let raised: Vec3 =
            (0..3).map(|k| lambda[k] * (-(x - corners[k]).dot(normals[k])).max(0.0) * normals[k]).sum();
        let up = outside * n.normalize();
        let origin = x + raised + up * (OFFSET * (1.0 + x.abs().max_element()));
        let [column, row] = [0, 1].map(|k| (frame.tile_origin[k] + xy[k] as i32) as u32);
        let seed = hash2(frame.seed, hash2(column, row));
        let jitter = Vec3::from([0, 1, 2].map(|k| random(seed, k) - 0.5)) * self.fur.grid.cell;
        let (mut radiance, mut arriving, mut unshadowed) = (Vec3::ZERO, Vec3::ZERO, Vec3::ZERO);
        let lights = &self.packed.lights[..self.packed.light_parameters.count as usize];
        for (light, j) in lights.iter().zip(0u32..) {
            let l = Vec3::from(light.direction);
            let irradiance = Vec3::from(light.irradiance) * normal.dot(l).max(0.0);
            unshadowed += irradiance;
            let way = within_light(l, light.spread, [3, 4].map(|k| random(seed, k + 2 * j)), up);
            if irradiance == Vec3::ZERO || !self.open(origin, way) {
                continue;
            }
            let lit = irradiance * (-fur_depth(self.fur, x + jitter, way)).exp();
            arriving += lit;
            radiance += lit * material.evaluate(normal, view, l, light.spread);
        }
        let (mut transparency, mut albedo) = (0.0, color);
        if of.shadow_catcher {
            let whole = luminance(unshadowed);
            transparency = if whole > 0.0 { luminance(arriving) / whole } else { 1.0 };
            (radiance, albedo) = (Vec3::ZERO, Vec3::ZERO);
        }
        Shaded { base: Base { z, radiance, normal, transparency }, albedo }
    }
}

/// Optical depth of the fur along a ray to infinity: the walls that it crosses, in order, cut it
/// into pieces of one cell each.
pub fn fur_depth(fur: &FurCells, origin: Vec3, ray: Vec3) -> f32 {
    let grid = &fur.grid;
    if grid.size[0] == 0 {
        return 0.0;
    }
    let start = (origin - Vec3::from(grid.low)).as_dvec3() / f64::from(grid.cell);
    let ray64 = ray.as_dvec3();
    let mut crossings = vec![0.0];
    for axis in 0..3 {
        let walls = (0..=grid.size[axis]).map(|w| (f64::from(w) - start[axis]) / ray64[axis]);
        crossings.extend(walls.filter(|t| t.is_finite() && *t > 0.0));
    }
    crossings.sort_by(f64::total_cmp);
    let piece = |w: &[f64]| {
        let cell = (start + 0.5 * (w[0] + w[1]) * ray64).floor();
        let inside = (0..3).all(|k| cell[k] >= 0.0 && cell[k] < f64::from(grid.size[k]));
        let [x, y, z] = cell.to_array().map(|c| c as usize);
        let index = (z * grid.size[1] as usize + y) * grid.size[0] as usize + x;
        if inside { (w[1] - w[0]) * f64::from(extinction(fur.cells[index], ray)) } else { 0.0 }
    };
    (crossings.windows(2).map(piece).sum::<f64>() * f64::from(grid.cell)) as f32
}

/// Extinction of a cell along a unit direction, 1/cm: projected area of its hairs per volume, times
/// the root of the mean square of the sine between them and the direction.
fn extinction([area, squares, more, mixed]: [u32; 4], ray: Vec3) -> f32 {
    let ([xx, yy], [zz, xy], [xz, yz]) = (halves(squares), halves(more), halves(mixed));
    let mean = Mat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz]);
    f32::from_bits(area) * (1.0 - ray.dot(mean * ray)).max(0.0).sqrt()
}
