//! Grows patches face by face, keeping them topological discs.

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
    /// The centre: barycentric coordinates of corners 1 and 2 of `face`.
    pub center: DVec2,
    /// Angle between the patch and the field at the centre, from which the direction is transported
    /// over the patch; `None` if the patch follows the field everywhere.
    pub turn: Option<f64>,
}

/// A grown piece of the skin, not yet flat. Its vertices have local indices.
#[derive(Default)]
pub(super) struct Region {
    pub faces: Vec<u32>,
    /// Direction of u on each face, in its frame.
    pub directions: Vec<Complex>,
    /// Local vertex indices of each face.
    pub corners: Vec<[u32; 3]>,
    /// Expected uv of each vertex, cm.
    pub uv: Vec<DVec2>,
}

/// Patches do not grow across edges where the cosine of the angle between the directions of both
/// faces is below this.
const PARTING: f64 = 0.5;

/// Faces with an expected stretch beyond this are not tried. The limit is much larger than
/// [`flatten::LIMIT`], because flattening spreads stretch over the patch, whereas a face that is
/// left out is a tear.
const HOPELESS: f64 = 8.0;

/// Number of times that bad faces are cut off a patch; after that the patch is halved instead.
const CUTS: usize = 6;

/// Grows patches. It keeps marks for the whole skin, so that the time per patch depends on the
/// patch's size only.
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

    /// Grows and flattens the patch around `seed`, of faces that `accept` takes by their expected
    /// uv. It contains at least the seed's face, and no face that is flipped or stretched beyond
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

    /// uv of the only face of a region, without distortion.
    fn alone(&self, region: &Region, seed: &Seed) -> [Vec2; 3] {
        let c = self.surface.frames[seed.face as usize].turned(region.directions[0]);
        let center = c[0] + (c[1] - c[0]) * seed.center.x + (c[2] - c[0]) * seed.center.y;
        c.map(|p| (p - center).as_vec2())
    }

    /// Grows a disc of at most `most` faces, those with the nearest expected centres first; faces
    /// marked `ban` are left out.
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
            // A face that does not fit at all where it is expected will not fit once the patch is
            // flat.
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

    /// Whether the region remains a disc if `f` is added: `f` touches it along one side and not
    /// with the opposite corner, or along two sides.
    fn stays_a_disc(&self, f: u32) -> bool {
        let within = |g: u32| self.face_mark[g as usize] == self.round;
        let joined = self.surface.around(f).filter(|(_, g)| within(*g)).map(|(k, _)| k);
        let joined: Vec<usize> = joined.collect();
        // A side that the region contains, but not through a neighbour, belongs to more than two
        // faces.
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

    /// Expected uv of the corners of `f`: known for vertices of the region, otherwise placed next
    /// to them by the shape of `f`.
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
            // No fit across a parting of the field can be good.
            if (laid_flat * direction.conj()).re < PARTING {
                continue;
            }
            let uv = self.expected(region, g, direction);
            let distance = ((uv[0] + uv[1] + uv[2]) / 3.0).length();
            heap.push(Next { distance, face: g, direction });
        }
    }
}

/// A candidate face.
struct Next {
    distance: f64,
    face: u32,
    direction: Complex,
}

impl Ord for Next {
    /// Reversed, so that the heap returns the nearest first.
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
