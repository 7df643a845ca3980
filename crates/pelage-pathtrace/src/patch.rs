//! A part of the skin whose hairs alone are grown.

use glam::Vec3;
use pelage_fur::random::{R2_STEPS, even_barycentric};
use pelage_fur::shell::Shell;

/// A ball that selects hairs by their roots.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    /// Centre, world space, cm.
    pub centre: Vec3,
    /// Radius, cm.
    pub radius: f32,
}

impl Patch {
    /// Whether a root at `p` (cm) lies in the patch.
    pub fn holds(&self, p: Vec3) -> bool {
        p.distance_squared(self.centre) <= self.radius * self.radius
    }

    /// Whether a triangle may hold roots in the patch; false only where it surely holds none.
    pub(super) fn reaches(&self, shell: &Shell, prism: u32) -> bool {
        let corners = corners(shell, prism);
        let low = corners.into_iter().reduce(Vec3::min).unwrap_or_default();
        let high = corners.into_iter().reduce(Vec3::max).unwrap_or_default();
        // Roots are rounded.
        let margin = 1e-5 * (1.0 + low.abs().max(high.abs()).max_element());
        let nearest = self.centre.clamp(low, high);
        nearest.distance(self.centre) <= self.radius + margin
    }

    /// Share of a triangle's area that lies in the patch, from 256 evenly spread points where its
    /// border crosses the triangle.
    pub(super) fn share(&self, shell: &Shell, prism: u32) -> f64 {
        const POINTS: u32 = 256;
        if !self.reaches(shell, prism) {
            return 0.0;
        }
        let [a, b, c] = corners(shell, prism);
        if [a, b, c].into_iter().all(|p| self.holds(p)) {
            return 1.0;
        }
        let held = (0..POINTS).filter(|k| {
            let lambda = even_lambda(*k);
            self.holds(lambda.x * a + lambda.y * b + lambda.z * c)
        });
        held.count() as f64 / f64::from(POINTS)
    }
}

/// Corners of the triangle below a prism, cm.
fn corners(shell: &Shell, prism: u32) -> [Vec3; 3] {
    shell.prisms[prism as usize].vertices.map(|v| shell.vertices[v as usize].position.into())
}

/// Barycentric coordinates of the k-th point of a triangle, even over its area.
pub(super) fn even_lambda(k: u32) -> Vec3 {
    let u = R2_STEPS.map(|step| ((f64::from(k) + 0.5) * step).fract() as f32);
    even_barycentric(u.into())
}
