//! The skin, as patches and fields use it: a local frame on each face, and the transport of
//! directions between faces.

use super::solve::Complex;
use glam::{DVec2, DVec3, Vec3};
use pelage_core::mesh::topology;
use pelage_core::skin::NONE;
use pelage_core::{Error, Result, Skin};
use pelage_fur::random::{hash2, unit_float};

/// Ratio of height to longest side below which a face is a needle: too thin for single precision to
/// resolve its shape.
pub(super) const NEEDLE: f64 = 1e-5;

/// The local frame of a face.
pub(super) struct Frame {
    /// Unit vector along the longest side.
    pub x: DVec3,
    /// normal × x.
    pub y: DVec3,
    /// Corners in the plane of the face, with corner 0 at the origin, cm. A needle is widened to
    /// [`NEEDLE`].
    pub corners: [DVec2; 3],
    /// True area, cm².
    pub area: f64,
    /// Whether the face is a needle.
    pub needle: bool,
}

impl Frame {
    fn of(corners: [DVec3; 3], normals: DVec3) -> Self {
        let sides = [0, 1, 2].map(|k: usize| corners[(k + 2) % 3] - corners[(k + 1) % 3]);
        let longest = (0..3).fold(0, |l, k| if sides[k].length() > sides[l].length() { k } else { l });
        let length = sides[longest].length();
        let x = sides[longest].normalize_or(DVec3::X);
        let doubled = sides[0].cross(sides[1]);
        let upright = |v: DVec3| (v - x * v.dot(x)).try_normalize();
        let normal = doubled.try_normalize().and_then(upright).or_else(|| upright(normals));
        let normal = normal.unwrap_or_else(|| x.any_orthonormal_vector());
        let y = normal.cross(x);
        let mut flat = corners.map(|p| DVec2::new((p - corners[0]).dot(x), (p - corners[0]).dot(y)));
        let height = doubled.length() / length.max(f64::MIN_POSITIVE);
        let needle = height < NEEDLE * length || length == 0.0;
        if needle {
            flat.iter_mut().for_each(|p| p.y = 0.0);
            flat[longest].y = NEEDLE * length;
        }
        Self { x, y, corners: flat, area: 0.5 * doubled.length(), needle }
    }

    /// Converts a direction to world space.
    pub fn world(&self, z: Complex) -> Vec3 {
        (self.x * z.re + self.y * z.im).normalize_or(self.x).as_vec3()
    }

    /// The tangential part of a world direction.
    pub fn tangential(&self, d: DVec3) -> Complex {
        Complex::new(d.dot(self.x), d.dot(self.y))
    }

    /// Corners, rotated so that `s` (unit) is the first axis.
    pub fn turned(&self, s: Complex) -> [DVec2; 3] {
        self.corners.map(|p| DVec2::new(p.x * s.re + p.y * s.im, p.y * s.re - p.x * s.im))
    }
}

/// A skin with frames and adjacency.
pub(super) struct Surface<'a> {
    pub skin: &'a Skin,
    pub frames: Vec<Frame>,
    /// The face across the side opposite each corner, or [`NONE`].
    pub neighbours: Vec<[u32; 3]>,
    /// Index of the undirected edge opposite each corner.
    pub edges: Vec<[u32; 3]>,
    /// Number of edges.
    pub edge_count: usize,
    /// Index of the connected part to which each face belongs.
    pub part: Vec<u32>,
    /// Number of faces and area (cm²) of each part.
    pub parts: Vec<(usize, f64)>,
    /// Total area, cm².
    pub area: f64,
}

impl<'a> Surface<'a> {
    /// # Errors
    /// [`Error::Scene`] if a position is not finite.
    pub fn new(skin: &'a Skin) -> Result<Self> {
        if let Some(p) = skin.positions.iter().find(|p| !p.is_finite()) {
            return Err(Error::fault("lapped", format!("found a vertex at {p}, expected finite numbers")));
        }
        let normal = |v: u32| skin.normals.get(v as usize).map_or(DVec3::ZERO, |n| n.as_dvec3());
        let frame = |t: usize| {
            let normals = skin.triangles[t].iter().map(|v| normal(*v)).sum();
            Frame::of(skin.corners(t).map(|p| p.as_dvec3()), normals)
        };
        let frames: Vec<Frame> = (0..skin.triangles.len()).map(frame).collect();
        let neighbours = topology::neighbours(&skin.triangles).neighbours;
        let (edges, edge_count) = edge_numbers(&skin.triangles);
        let part = parts(&neighbours);
        let mut sizes = vec![(0, 0.0); part.iter().max().map_or(0, |p| *p as usize + 1)];
        for (p, frame) in part.iter().zip(&frames) {
            sizes[*p as usize].0 += 1;
            sizes[*p as usize].1 += frame.area;
        }
        let area = frames.iter().map(|f| f.area).sum();
        Ok(Self { skin, frames, neighbours, edges, edge_count, part, parts: sizes, area })
    }

    /// The faces across the sides of `f`, as (side, face).
    pub fn around(&self, f: u32) -> impl Iterator<Item = (usize, u32)> + '_ {
        (0..3).map(move |k| (k, self.neighbours[f as usize][k])).filter(|(_, n)| *n != NONE)
    }

    /// The side of `g` that coincides with side `k` of `f`.
    pub fn side_of(&self, g: u32, f: u32, k: usize) -> usize {
        let edge = self.edges[f as usize][k];
        (0..3).find(|j| self.edges[g as usize][*j] == edge).unwrap_or(0)
    }

    /// The side `k` of `f` in the frame of `f`, from corner k+1 to k+2, cm.
    pub fn side(&self, f: u32, k: usize) -> DVec2 {
        let c = &self.frames[f as usize].corners;
        c[(k + 2) % 3] - c[(k + 1) % 3]
    }

    /// Factor that transports a direction of `f` over the side `k` into the frame of `g`, with the
    /// two faces unfolded into a plane.
    pub fn transport(&self, f: u32, k: usize, g: u32) -> Complex {
        let here = self.side(f, k);
        let there = -self.side(g, self.side_of(g, f, k));
        let r = Complex::new(there.dot(here), here.perp_dot(there));
        unit(r).unwrap_or(Complex::new(1.0, 0.0))
    }

    /// The faces in a random order, weighted by area: the first uncovered face in it is distributed
    /// about like the face of a random uncovered point.
    // [Efraimidis2006]
    pub fn random_order(&self, seed: u32) -> Vec<u32> {
        let key = |f: u32| {
            let u = (f64::from(unit_float(hash2(seed, f))) + 1e-9).min(1.0);
            let key = -u.ln() / (self.frames[f as usize].area / self.area);
            if key.is_nan() { f64::INFINITY } else { key }
        };
        let mut order: Vec<(f64, u32)> = (0..self.frames.len() as u32).map(|f| (key(f), f)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        order.into_iter().map(|(_, f)| f).collect()
    }
}

/// z / |z|; `None` for zero.
pub(super) fn unit(z: Complex) -> Option<Complex> {
    let length = z.re.hypot(z.im);
    let unit = Complex::new(z.re / length, z.im / length);
    (length > 0.0 && unit.re.is_finite() && unit.im.is_finite()).then_some(unit)
}

/// Indices of the undirected edges opposite each corner, and their number.
fn edge_numbers(triangles: &[[u32; 3]]) -> (Vec<[u32; 3]>, usize) {
    let mut sides = Vec::with_capacity(3 * triangles.len());
    for (t, v) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (v[(k + 1) % 3], v[(k + 2) % 3]);
            sides.push((topology::edge_key(a.min(b), a.max(b)), t as u32, k as u8));
        }
    }
    sides.sort_unstable();
    let mut numbers = vec![[0; 3]; triangles.len()];
    let mut count = 0;
    for edge in sides.chunk_by(|a, b| a.0 == b.0) {
        edge.iter().for_each(|(_, t, k)| numbers[*t as usize][*k as usize] = count);
        count += 1;
    }
    (numbers, count as usize)
}

/// Index of the connected part of each face, numbered by first face.
fn parts(neighbours: &[[u32; 3]]) -> Vec<u32> {
    let mut part = vec![NONE; neighbours.len()];
    let mut count = 0;
    for first in 0..neighbours.len() {
        if part[first] != NONE {
            continue;
        }
        let mut open = vec![first as u32];
        part[first] = count;
        while let Some(f) = open.pop() {
            for n in neighbours[f as usize].iter().filter(|n| **n != NONE) {
                if part[*n as usize] == NONE {
                    part[*n as usize] = count;
                    open.push(*n);
                }
            }
        }
        count += 1;
    }
    part
}
