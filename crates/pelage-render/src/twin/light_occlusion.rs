//! Twin of `shaders/light_occlusion.wgsl`: which lights the skin blocks, testing every triangle in
//! double precision.

use crate::twin::lattice::node_place;
use glam::{DVec3, Vec3};
use pelage_fur::layout::{Column, FurParameters, Light};
use pelage_fur::shell::Shell;

/// Origin of a column's shadow rays, cm: at the top of the optical-depth lattice, at least slightly
/// above the skin.
pub fn origin(shell: &Shell, fur: &FurParameters, column: &Column) -> Vec3 {
    let (place, top) = node_place(shell, fur, column, fur.lattice.levels);
    top + place.e1.cross(place.e2).normalize() * 1e-3
}

/// Parameter at which a ray meets a triangle in front of its origin, if it does. Edges belong to
/// the triangle.
// [MollerTrumbore1997]
pub fn hit(corners: [Vec3; 3], origin: Vec3, ray: Vec3) -> Option<f64> {
    let [p0, p1, p2] = corners.map(|p| p.as_dvec3());
    let (origin, ray): (DVec3, DVec3) = (origin.as_dvec3(), ray.as_dvec3());
    let (e1, e2) = (p1 - p0, p2 - p0);
    let h = ray.cross(e2);
    let det = e1.dot(h);
    if det.abs() < 1e-12 {
        return None;
    }
    let s = (origin - p0) / det;
    let q = s.cross(e1);
    let (u, v, t) = (s.dot(h), ray.dot(q), e2.dot(q));
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0).then_some(t)
}

/// Whether any triangle of the skin blocks a ray.
pub fn blocked(shell: &Shell, origin: Vec3, ray: Vec3) -> bool {
    shell.prisms.iter().any(|prism| {
        hit(prism.vertices.map(|v| shell.vertices[v as usize].position.into()), origin, ray).is_some()
    })
}

/// One bit per light that the skin blocks at a column.
pub fn bits(shell: &Shell, fur: &FurParameters, lights: &[Light], column: &Column) -> u64 {
    let origin = origin(shell, fur, column);
    (0..fur.lights.count as usize)
        .filter(|j| blocked(shell, origin, lights[*j].direction.into()))
        .fold(0, |bits, j| bits | (1 << j))
}
