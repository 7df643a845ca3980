//! Cuts polygons into triangles.

use super::Mesh;
use glam::{DVec2, DVec3, Vec3};
use std::collections::{HashMap, HashSet};

/// Cuts the faces of a mesh one after the other, and leaves out those that were there before: with
/// the same corners in the same or the reverse order, whichever diagonals they were cut along.
pub(super) struct Cutter {
    /// For each vertex, the first one at the same position.
    first: Vec<u32>,
    cuts: Vec<[usize; 3]>,
    triangles: HashSet<[u32; 3]>,
    quads: HashSet<[u32; 4]>,
    larger: HashSet<Box<[u32]>>,
    polygons: u64,
    concave: u64,
    guessed: u64,
    twice: u64,
}

impl Cutter {
    pub(super) fn new(positions: &[Vec3]) -> Self {
        let mut known = HashMap::with_capacity(positions.len());
        // Adding zero turns -0 into 0, so that both have the same key.
        let key = |p: &Vec3| (*p + Vec3::ZERO).to_array().map(f32::to_bits);
        let first = positions.iter().enumerate().map(|(i, p)| *known.entry(key(p)).or_insert(i as u32));
        Self {
            first: first.collect(),
            cuts: Vec::new(),
            triangles: HashSet::new(),
            quads: HashSet::new(),
            larger: HashSet::new(),
            polygons: 0,
            concave: 0,
            guessed: 0,
            twice: 0,
        }
    }

    /// The triangles of the face with these corners, each as three corner numbers; none if the face
    /// was there before. Faces of three corners always come back.
    pub(super) fn cut(&mut self, positions: &[Vec3], corners: &[u32]) -> &[[usize; 3]] {
        self.cuts.clear();
        if corners.len() < 3 {
            return &self.cuts;
        }
        if corners.len() > 3 && !self.is_new(corners) {
            self.twice += 1;
            return &self.cuts;
        }
        let points: Vec<Vec3> = corners.iter().map(|i| positions[*i as usize]).collect();
        let cut = triangulate(&points, &mut self.cuts);
        if corners.len() > 3 {
            self.polygons += 1;
            let (first, triangles) = (&self.first, &mut self.triangles);
            let mut is_new = |t: &[usize; 3]| {
                let mut key = t.map(|k| first[corners[k] as usize]);
                key.sort_unstable();
                triangles.insert(key)
            };
            // Two quads may share two sides; cut between the same corners, both would contain the
            // same triangle.
            if !self.cuts.iter().all(&mut is_new) && corners.len() == 4 && cut == Cut::Fan {
                self.cuts = vec![[1, 2, 3], [1, 3, 0]];
                self.cuts.iter().for_each(|t| {
                    is_new(t);
                });
            }
        }
        self.concave += u64::from(cut == Cut::Ears);
        self.guessed += u64::from(cut == Cut::Guess);
        &self.cuts
    }

    /// Whether no face had these corners in this or the reverse order.
    fn is_new(&mut self, corners: &[u32]) -> bool {
        let ring: Vec<u32> = corners.iter().map(|i| self.first[*i as usize]).collect();
        let n = ring.len();
        let start = (0..n).min_by_key(|i| ring[*i]).unwrap_or(0);
        let forward = ring[(start + 1) % n] <= ring[(start + n - 1) % n];
        let at = |k: usize| ring[if forward { start + k } else { start + n - k } % n];
        match n {
            4 => self.quads.insert([at(0), at(1), at(2), at(3)]),
            _ => self.larger.insert((0..n).map(at).collect()),
        }
    }

    /// Adds to `mesh` what was noticed.
    pub(super) fn report(&self, mesh: &mut Mesh) {
        let mut repair = |n: u64, what: &str| (n > 0).then(|| mesh.repairs.push(format!("{n} {what}")));
        repair(self.guessed, "polygons without a clear inside cut as fans");
        repair(self.twice, "faces that were there before dropped");
        let mut note = |n: u64, what: &str| (n > 0).then(|| mesh.notes.push(format!("{n} {what}")));
        note(self.polygons, "polygons cut into triangles");
        note(self.concave, "of them concave, cut by ear clipping");
    }
}

/// Beyond this many corners a polygon is cut as a fan, because ear clipping takes quadratic time.
pub(super) const MAX_EAR_CORNERS: usize = 4096;

/// How a polygon was cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Cut {
    /// Convex: a fan around corner 0.
    Fan,
    /// Concave: ear clipping.
    Ears,
    /// Concave, but too large, or without an area of its own: a fan that may be wrong.
    Guess,
}

/// Cuts the polygon with these corners into `corners.len() - 2` triangles of corner numbers, wound
/// as the polygon.
pub(super) fn triangulate(corners: &[Vec3], out: &mut Vec<[usize; 3]>) -> Cut {
    out.clear();
    let n = corners.len();
    if n == 3 {
        out.push([0, 1, 2]);
        return Cut::Fan;
    }
    let (points, degenerate) = project(corners);
    let reflex = |i: usize| turn(points[(i + n - 1) % n], points[i], points[(i + 1) % n]) < -1e-7;
    let concave = (0..n).any(reflex);
    if !concave || degenerate || n > MAX_EAR_CORNERS {
        out.extend((1..n.saturating_sub(1)).map(|i| [0, i, i + 1]));
        return if concave || degenerate { Cut::Guess } else { Cut::Fan };
    }
    clip_ears(&points, out);
    Cut::Ears
}

/// The polygon in the plane of its Newell normal, counter-clockwise; true if it has no area there.
fn project(corners: &[Vec3]) -> (Vec<DVec2>, bool) {
    let points: Vec<DVec3> = corners.iter().map(|p| (p - corners[0]).as_dvec3()).collect();
    let normal: DVec3 = (0..points.len()).map(|i| points[i].cross(points[(i + 1) % points.len()])).sum();
    let size = points.iter().map(|p| p.length_squared()).fold(0.0, f64::max);
    let Some(axis) = normal.try_normalize().filter(|_| normal.length() > 1e-12 * size) else {
        return (points.iter().map(|p| p.truncate()).collect(), true);
    };
    let (u, v) = axis.any_orthonormal_pair();
    // any_orthonormal_pair gives u x v = axis, so that the projection keeps the winding.
    (points.iter().map(|p| DVec2::new(p.dot(u), p.dot(v))).collect(), false)
}

/// Sine of the turn at b along a, b, c: positive to the left, 0 if points coincide.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let (d, e) = (b - a, c - b);
    d.perp_dot(e) / (d.length() * e.length()).max(f64::MIN_POSITIVE)
}

fn clip_ears(points: &[DVec2], out: &mut Vec<[usize; 3]>) {
    let mut left: Vec<usize> = (0..points.len()).collect();
    let mut at = 0;
    while left.len() > 3 {
        let n = left.len();
        let corner = |i: usize| [left[(i + n - 1) % n], left[i % n], left[(i + 1) % n]];
        // If no ear is left (the polygon crosses itself), the sharpest left turn is cut
        // nevertheless.
        let ear = (at..at + n).find(|i| is_ear(points, &left, corner(*i))).unwrap_or_else(|| {
            let sharpness = |i: &usize| {
                let [a, b, c] = corner(*i);
                turn(points[a], points[b], points[c])
            };
            (at..at + n).max_by(|i, j| sharpness(i).total_cmp(&sharpness(j))).unwrap_or(at)
        });
        out.push(corner(ear));
        left.remove(ear % n);
        // Advancing by two corners spreads the cuts; always taking the next would make a fan of
        // slivers.
        at = (ear % n + 1) % (n - 1);
    }
    out.push([left[0], left[1], left[2]]);
}

fn is_ear(points: &[DVec2], left: &[usize], [a, b, c]: [usize; 3]) -> bool {
    let (pa, pb, pc) = (points[a], points[b], points[c]);
    if turn(pa, pb, pc) <= 1e-9 {
        return false;
    }
    !left.iter().map(|i| points[*i]).any(|p| {
        let outside = |q: DVec2, r: DVec2| (r - q).perp_dot(p - q) < 0.0;
        p != pa && p != pb && p != pc && !outside(pa, pb) && !outside(pb, pc) && !outside(pc, pa)
    })
}
