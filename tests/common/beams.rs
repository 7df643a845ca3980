//! Parallel rays through strands, with a count of the segments that each meets.

use glam::{Vec2, Vec3};
use pelage_pathtrace::strands::Strands;

/// A direction and the plane across it.
#[derive(Debug, Clone, Copy)]
pub struct Beam {
    /// Unit.
    pub along: Vec3,
    u: Vec3,
    v: Vec3,
}

impl Beam {
    /// Rays along `along`.
    pub fn new(along: Vec3) -> Self {
        let along = along.normalize();
        let (u, v) = along.any_orthonormal_pair();
        Self { along, u, v }
    }

    /// Where the ray through `p` meets the plane, cm.
    pub fn across(&self, p: Vec3) -> Vec2 {
        Vec2::new(self.u.dot(p), self.v.dot(p))
    }
}

/// The segments that are present: their ends, with radii.
pub fn segments(strands: &Strands) -> impl Iterator<Item = [glam::Vec4; 2]> + '_ {
    let hairs = strands.hairs.iter().zip(strands.points.chunks(strands.segments + 1));
    hairs.flat_map(|(hair, points)| {
        let there = points.windows(2).enumerate().filter(|(k, _)| hair.present >> k & 1 == 1);
        there.map(|(_, ends)| [ends[0], ends[1]])
    })
}

/// How many segments each infinite ray meets: cones without caps. Rays are points of the beam's
/// plane.
pub fn hits(beam: &Beam, rays: &[Vec2], segments: impl Iterator<Item = [glam::Vec4; 2]>) -> Vec<u32> {
    let low = rays.iter().copied().reduce(Vec2::min).expect("rays");
    let high = rays.iter().copied().reduce(Vec2::max).expect("rays") + 1e-5;
    let side =
        ((high - low).element_product() / rays.len() as f32).sqrt().max((high - low).max_element() / 2000.0);
    let [columns, rows] = [high.x - low.x, high.y - low.y].map(|size| (size / side) as usize + 1);
    let mut cells = vec![Vec::new(); columns * rows];
    for (i, ray) in rays.iter().enumerate() {
        let at = (*ray - low) / side;
        cells[at.y as usize * columns + at.x as usize].push(i);
    }
    let mut hits = vec![0; rays.len()];
    for [a, b] in segments {
        let radii = [a.w, b.w];
        let [a, b] = [beam.across(a.truncate()), beam.across(b.truncate())];
        let (d, reach) = (b - a, radii[0].max(radii[1]));
        let length2 = d.length_squared();
        // Row by row over the cells that the segment crosses.
        let (bottom, top) = (a.y.min(b.y) - reach, a.y.max(b.y) + reach);
        if length2 == 0.0 || top < low.y || bottom > high.y {
            continue;
        }
        let row = |y: f32| ((y - low.y) / side).clamp(0.0, rows as f32 - 1.0) as usize;
        for j in row(bottom)..=row(top) {
            let y = [j as f32 * side + low.y - reach, (j + 1) as f32 * side + low.y + reach];
            let s = if d.y.abs() < 1e-9 { [0.0, 1.0] } else { y.map(|y| ((y - a.y) / d.y).clamp(0.0, 1.0)) };
            let x = s.map(|s| a.x + s * d.x);
            let (left, right) = (x[0].min(x[1]) - reach, x[0].max(x[1]) + reach);
            if right < low.x || left > high.x {
                continue;
            }
            let column = |x: f32| ((x - low.x) / side).clamp(0.0, columns as f32 - 1.0) as usize;
            for i in column(left)..=column(right) {
                for ray in &cells[j * columns + i] {
                    let p = rays[*ray] - a;
                    let s = p.dot(d) / length2;
                    if (0.0..1.0).contains(&s) {
                        let radius = radii[0] + s * (radii[1] - radii[0]);
                        hits[*ray] += u32::from(p.perp_dot(d).powi(2) < radius * radius * length2);
                    }
                }
            }
        }
    }
    hits
}

/// Part of the rays that meet nothing.
pub fn transmittance(hits: &[u32]) -> f64 {
    hits.iter().filter(|n| **n == 0).count() as f64 / hits.len() as f64
}

/// Mean number of segments met: the optical depth of thin, independent hairs.
pub fn optical_depth(hits: &[u32]) -> f64 {
    hits.iter().map(|n| f64::from(*n)).sum::<f64>() / hits.len() as f64
}
