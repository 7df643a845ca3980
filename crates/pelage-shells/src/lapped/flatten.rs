//! Flattens a patch by a least-squares fit to the directions on its faces.

use super::{
    grow::{Region, Seed},
    solve::{Complex, Factor},
    surface::Surface,
};
use faer::Mat;
use glam::{DVec2, Vec2};

/// Limit of a face's singular values and of its area ratio; the lower limit is the inverse.
pub(super) const LIMIT: f64 = 2.0;

/// Largest angle between u and the direction of a face, for patches that follow the field, radians.
pub(super) const TURN: f64 = std::f64::consts::FRAC_PI_4;

/// A flat patch.
pub(super) struct Flat {
    /// uv of the corners of each face, cm.
    pub corner_uv: Vec<[Vec2; 3]>,
    /// The map from each face to uv.
    pub maps: Vec<Map>,
}

impl Flat {
    /// Indices within the patch of faces that are flipped, or stretched or turned beyond the
    /// limits.
    pub fn bad(&self) -> Vec<usize> {
        (0..self.maps.len()).filter(|i| !self.maps[*i].is_within_limits()).collect()
    }
}

/// The linear map from a face, with the direction of the hair along its first axis, to uv.
#[derive(Debug, Clone, Copy)]
pub(super) struct Map {
    /// Largest and smallest singular value; the smallest is negative if the face is flipped.
    pub stretch: [f64; 2],
    /// Angle between the image of the hair's direction and u, radians.
    pub angle: f64,
}

impl Map {
    /// The map from a face's corners to their uv.
    pub fn of(from: &[DVec2; 3], to: &[DVec2; 3]) -> Self {
        let (a, b) = (from[1] - from[0], from[2] - from[0]);
        let (p, q) = (to[1] - to[0], to[2] - to[0]);
        // J [a b] = [p q].
        let inverse = 1.0 / a.perp_dot(b);
        let x = (p * b.y - q * a.y) * inverse;
        let y = (q * a.x - p * b.x) * inverse;
        let turn = DVec2::new(x.x + y.y, x.y - y.x).length() / 2.0;
        let mirror = DVec2::new(x.x - y.y, x.y + y.x).length() / 2.0;
        Self { stretch: [turn + mirror, turn - mirror], angle: x.y.atan2(x.x) }
    }

    /// Whether the face is neither flipped, nor stretched beyond [`LIMIT`], nor turned beyond
    /// [`TURN`].
    pub fn is_within_limits(&self) -> bool {
        let [most, least] = self.stretch;
        let area = most * least;
        let straight = self.angle.abs() <= TURN;
        straight && most <= LIMIT && least >= 1.0 / LIMIT && (1.0 / LIMIT..=LIMIT).contains(&area)
    }
}

/// Flattens a region so that on each face u grows along the direction of the hair and v
/// perpendicular to it, as nearly as possible at unit rate, and moves the seed's centre to the
/// origin. `None` if the system cannot be solved.
// [Praun2000] sec. 4: min sum_f |phi(S_f) - s|² + |phi(T_f) - t|²
// DEVIATION: faces are weighted by area, so that the fit does not depend on the triangulation. The
// system matrix is then the cotangent Laplacian [PinkallPolthier1993].
pub(super) fn flatten(surface: &Surface, region: &Region, seed: &Seed) -> Option<Flat> {
    let vertices = region.uv.len();
    // Corner 0 of the seed is fixed at the origin; without a fixed vertex the system is singular.
    let held = region.corners[0][0];
    let row = |v: u32| (v as usize) - usize::from(v > held);
    let mut entries = Vec::with_capacity(12 * region.faces.len());
    let mut right = Mat::<f64>::zeros(vertices - 1, 2);
    for (i, corners) in region.corners.iter().enumerate() {
        let shape = turned(surface, region, i);
        for k in 0..3 {
            let (a, b, c) = (shape[(k + 1) % 3], shape[(k + 2) % 3], shape[k]);
            let weight = 0.5 * (a - c).dot(b - c) / (a - c).perp_dot(b - c);
            let (i, j) = (corners[(k + 1) % 3], corners[(k + 2) % 3]);
            for (v, w, side) in [(i, j, a - b), (j, i, b - a)] {
                if v == held {
                    continue;
                }
                entries.push((row(v), row(v), weight));
                if w != held && row(v) > row(w) {
                    entries.push((row(v), row(w), -weight));
                }
                right[(row(v), 0)] += weight * side.x;
                right[(row(v), 1)] += weight * side.y;
            }
        }
    }
    Factor::new(vertices - 1, entries.into_iter())?.solve(&mut right);
    let at = |v: u32| {
        if v == held { DVec2::ZERO } else { DVec2::new(right[(row(v), 0)], right[(row(v), 1)]) }
    };
    let first = region.corners[0].map(at);
    let center = first[0] + (first[1] - first[0]) * seed.center.x + (first[2] - first[0]) * seed.center.y;
    let corner_uv: Vec<_> = region.corners.iter().map(|c| c.map(|v| (at(v) - center).as_vec2())).collect();
    let maps = (0..region.faces.len())
        .map(|i| Map::of(&turned(surface, region, i), &corner_uv[i].map(|p| p.as_dvec2())))
        .collect();
    Some(Flat { corner_uv, maps })
}

fn turned(surface: &Surface, region: &Region, i: usize) -> [DVec2; 3] {
    let direction: Complex = region.directions[i];
    surface.frames[region.faces[i] as usize].turned(direction)
}
