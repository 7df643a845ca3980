//! Patches grow face by face and stay discs.

use super::{
    Patch,
    flatten::{self, Flat},
    solve::Complex,
    surface::Surface,
};
use glam::{DVec2, Vec2};
use std::{cmp::Ordering, collections::BinaryHeap};

/// Where a patch starts.
pub(super) struct Seed {
    pub face: u32,
    /// The centre: barycentric coordinates of corners 1 and 2.
    pub center: DVec2,
    /// Angle between the patch and the field at the centre, the rest laid flat around it; `None`:
    /// the patch follows the field everywhere.
    pub turn: Option<f64>,
}

/// A grown piece of the skin, not yet flat. Vertices have numbers of their own.
#[derive(Default)]
pub(super) struct Region {
    pub faces: Vec<u32>,
    /// Direction of u on each face, in its frame.
    pub directions: Vec<Complex>,
    /// Vertices of each face.
    pub corners: Vec<[u32; 3]>,
    /// Where each vertex is expected.
    pub uv: Vec<DVec2>,
}

/// Cosine of the angle between the directions of two faces below which a patch does not go from one
/// to the other.
const PARTING: f64 = 0.5;

/// Stretch of a face where it is expected past which it is not tried. Much more than
/// [`flatten::LIMIT`]: flattening spreads it over the patch, and a face that is left out is a tear.
const HOPELESS: f64 = 8.0;

/// Faces cut off from a patch this often are the last: then it is halved instead.
const CUTS: usize = 6;

/// Grows patches. It keeps marks of the size of the skin, so that a patch takes time by its own
/// size.
pub(super) struct Grower<'a> {
    pub surface: &'a Surface<'a>,
    field: &'a [Complex],
    face_mark: Vec<u32>,
    banned_mark: Vec<u32>,
    vertex_mark: Vec<u32>,
    vertex_number: Vec<u32>,
    edge_mark: Vec<u32>,
    round: u32,
}

impl<'a> Grower<'a> {
    pub fn new(surface: &'a Surface<'a>, field: &'a [Complex]) -> Self {
        let (faces, vertices) = (surface.frames.len(), surface.skin.positions.len());
        Self {
            surface,
            field,
            face_mark: vec![0; faces],
            banned_mark: vec![0; faces],
            vertex_mark: vec![0; vertices],
            vertex_number: vec![0; vertices],
            edge_mark: vec![0; surface.edge_count],
            round: 0,
        }
    }

    /// The flat patch around `seed` of faces that `accept` takes by their expected uv. It holds at
    /// least the face of the seed, and no face that is flipped or stretched past
    /// [`flatten::LIMIT`].
    pub fn patch(&mut self, seed: &Seed, accept: &dyn Fn(&[DVec2; 3]) -> bool) -> Patch {
        self.round += 1;
        let ban = self.round;
        let mut region = self.grow(seed, accept, usize::MAX, ban);
        for cut in 0.. {
            if region.faces.len() == 1 {
                break;
            }
            let flat = flatten::flatten(self.surface, &region, seed);
            let bad = flat.as_ref().map(Flat::bad);
            match (flat, bad) {
                (Some(flat), Some(bad)) if bad.is_empty() => {
                    return Patch { faces: region.faces, corner_uv: flat.corner_uv, outline: Vec::new() };
                }
                (Some(_), Some(bad)) if cut < CUTS && bad[0] != 0 => {
                    bad.iter().for_each(|i| self.banned_mark[region.faces[*i] as usize] = ban);
                    region = self.grow(seed, accept, usize::MAX, ban);
                }
                _ => region = self.grow(seed, accept, region.faces.len() / 2, ban),
            }
        }
        Patch { corner_uv: vec![self.alone(&region, seed)], faces: region.faces, outline: Vec::new() }
    }

    /// The only face of a region, exactly as it is.
    fn alone(&self, region: &Region, seed: &Seed) -> [Vec2; 3] {
        let c = self.surface.frames[seed.face as usize].turned(region.directions[0]);
        let center = c[0] + (c[1] - c[0]) * seed.center.x + (c[2] - c[0]) * seed.center.y;
        c.map(|p| (p - center).as_vec2())
    }

    /// The disc of at most `most` faces, those whose expected centre is nearest first.
    fn grow(&mut self, seed: &Seed, accept: &dyn Fn(&[DVec2; 3]) -> bool, most: usize, ban: u32) -> Region {
        self.round += 1;
        let round = self.round;
        let mut region = Region::default();
        let mut heap = BinaryHeap::new();
        let turn = seed.turn.map_or(Complex::new(1.0, 0.0), |t| Complex::new(t.cos(), t.sin()));
        let first = self.field[seed.face as usize] * turn;
        self.add(&mut region, seed.face, first, &self.first_corners(seed, first), &mut heap, seed);
        while let Some(next) = heap.pop() {
            if region.faces.len() >= most {
                break;
            }
            let f = next.face as usize;
            if self.face_mark[f] == round || self.banned_mark[f] == ban || !self.stays_a_disc(next.face) {
                continue;
            }
            let uv = self.expected(&region, next.face, next.direction);
            // What does not fit at all where it is expected will not fit once the patch is flat.
            let shape = self.surface.frames[f].turned(next.direction);
            let [most, least] = flatten::Map::of(&shape, &uv).stretch;
            if most <= HOPELESS && least >= 1.0 / HOPELESS && accept(&uv) {
                self.add(&mut region, next.face, next.direction, &uv, &mut heap, seed);
            }
        }
        region
    }

    fn first_corners(&self, seed: &Seed, direction: Complex) -> [DVec2; 3] {
        let c = self.surface.frames[seed.face as usize].turned(direction);
        let center = c[0] + (c[1] - c[0]) * seed.center.x + (c[2] - c[0]) * seed.center.y;
        c.map(|p| p - center)
    }

    /// Whether the region with `f` is a disc if it was one before: `f` touches it along one side
    /// and not with the corner opposite, or along two sides.
    fn stays_a_disc(&self, f: u32) -> bool {
        let within = |g: u32| self.face_mark[g as usize] == self.round;
        let joined = self.surface.around(f).filter(|(_, g)| within(*g)).map(|(k, _)| k);
        let joined: Vec<usize> = joined.collect();
        // A side that the region has, but not as a neighbour, is one of more than two faces.
        let sides = self.surface.edges[f as usize];
        let held = sides.iter().filter(|e| self.edge_mark[**e as usize] == self.round).count();
        match joined[..] {
            [k] => {
                let opposite = self.surface.skin.triangles[f as usize][k];
                held == 1 && self.vertex_mark[opposite as usize] != self.round
            }
            [_, _] => held == 2,
            _ => false,
        }
    }

    /// Where the corners of `f` come to lie: where they are already, or beside these by the shape
    /// of `f`.
    fn expected(&self, region: &Region, f: u32, direction: Complex) -> [DVec2; 3] {
        let shape = self.surface.frames[f as usize].turned(direction);
        let known = self.surface.skin.triangles[f as usize].map(|v| self.place(region, v));
        let mut shift = DVec2::ZERO;
        let mut count = 0.0;
        for (at, shape) in known.iter().zip(&shape) {
            if let Some(at) = at {
                shift += *at - *shape;
                count += 1.0;
            }
        }
        [0, 1, 2].map(|k: usize| known[k].unwrap_or(shape[k] + shift / f64::max(count, 1.0)))
    }

    fn place(&self, region: &Region, vertex: u32) -> Option<DVec2> {
        let v = vertex as usize;
        (self.vertex_mark[v] == self.round).then(|| region.uv[self.vertex_number[v] as usize])
    }

    fn add(
        &mut self,
        region: &mut Region,
        f: u32,
        direction: Complex,
        uv: &[DVec2; 3],
        heap: &mut BinaryHeap<Next>,
        seed: &Seed,
    ) {
        self.face_mark[f as usize] = self.round;
        let vertices = self.surface.skin.triangles[f as usize];
        for (v, uv) in vertices.iter().zip(uv) {
            if self.vertex_mark[*v as usize] != self.round {
                self.vertex_mark[*v as usize] = self.round;
                self.vertex_number[*v as usize] = region.uv.len() as u32;
                region.uv.push(*uv);
            }
        }
        self.surface.edges[f as usize].iter().for_each(|e| self.edge_mark[*e as usize] = self.round);
        region.faces.push(f);
        region.directions.push(direction);
        region.corners.push(vertices.map(|v| self.vertex_number[v as usize]));
        for (k, g) in self.surface.around(f) {
            if self.face_mark[g as usize] == self.round {
                continue;
            }
            let laid_flat = direction * self.surface.transport(f, k, g);
            let direction = if seed.turn.is_some() { laid_flat } else { self.field[g as usize] };
            // Across a parting of the field no fit can be good.
            if (laid_flat * direction.conj()).re < PARTING {
                continue;
            }
            let uv = self.expected(region, g, direction);
            let distance = ((uv[0] + uv[1] + uv[2]) / 3.0).length();
            heap.push(Next { distance, face: g, direction });
        }
    }
}

/// A face that may join.
struct Next {
    distance: f64,
    face: u32,
    direction: Complex,
}

impl Ord for Next {
    /// The nearest is the greatest: a heap gives that first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.distance.total_cmp(&self.distance).then(other.face.cmp(&self.face))
    }
}

impl PartialOrd for Next {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Next {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Next {}
