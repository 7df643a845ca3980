//! Exact coverage by overlapping patches: each face is divided into cells, and a cell is covered
//! once it lies entirely within the outline of a single patch.

use super::{
    outline::{Outline, Relation},
    surface::Surface,
};
use glam::{DVec2, Vec2};

/// Largest number of cells of a skin.
const MOST: usize = 20_000_000;

/// The cells of all faces.
pub(super) struct Cells {
    /// Index of the first cell of each face, followed by the total number.
    start: Vec<u32>,
    /// Corners of each cell, as barycentric coordinates of the face's corners 1 and 2.
    corners: Vec<[Vec2; 3]>,
    covered: Vec<bool>,
    /// Number of uncovered cells of each face.
    left: Vec<u32>,
    /// Number of cells of each face that were given up.
    lost: Vec<u32>,
    areas: Vec<f64>,
}

impl Cells {
    /// Divides faces into cells with sides of at most `side` cm, by bisecting longest sides. `None`
    /// if there would be too many cells.
    pub fn new(surface: &Surface, side: f64) -> Option<Self> {
        let mut corners = Vec::new();
        let mut start = vec![0];
        for frame in &surface.frames {
            let shape = frame.corners;
            let at = |b: Vec2| {
                let b = b.as_dvec2();
                shape[0] + (shape[1] - shape[0]) * b.x + (shape[2] - shape[0]) * b.y
            };
            let mut open = vec![[Vec2::ZERO, Vec2::X, Vec2::Y]];
            while let Some(cell) = open.pop() {
                let length = |k: usize| at(cell[(k + 1) % 3]).distance(at(cell[(k + 2) % 3]));
                let k = (0..3).fold(0, |l, k| if length(k) > length(l) { k } else { l });
                if length(k) <= side {
                    corners.push(cell);
                    continue;
                }
                let (a, b, c) = (cell[k], cell[(k + 1) % 3], cell[(k + 2) % 3]);
                let middle = (b + c) / 2.0;
                if middle == b || middle == c || corners.len() + open.len() >= MOST {
                    return None;
                }
                open.extend([[a, b, middle], [a, middle, c]]);
            }
            start.push(corners.len() as u32);
        }
        let left: Vec<u32> = start.windows(2).map(|w| w[1] - w[0]).collect();
        let lost = vec![0; left.len()];
        let covered = vec![false; corners.len()];
        let areas = surface.frames.iter().map(|f| f.area).collect();
        Some(Self { start, corners, covered, left, lost, areas })
    }

    fn of(&self, face: u32) -> std::ops::Range<usize> {
        self.start[face as usize] as usize..self.start[face as usize + 1] as usize
    }

    /// An uncovered cell of a face, chosen by the random number `draw`, and its centre (barycentric
    /// coordinates of corners 1 and 2).
    pub fn uncovered(&self, face: u32, draw: u32) -> Option<(usize, DVec2)> {
        let left = self.left[face as usize];
        let skip = draw.checked_rem(left)? as usize;
        let cell = self.of(face).filter(|c| !self.covered[*c]).nth(skip)?;
        let [a, b, c] = self.corners[cell];
        Some((cell, (a + b + c).as_dvec2() / 3.0))
    }

    /// Marks the cells of `face` that lie within an outline; `uv` are those of the face's corners.
    pub fn cover(&mut self, face: u32, uv: &[DVec2; 3], outline: &Outline) {
        if self.left[face as usize] == 0 {
            return;
        }
        for c in self.of(face) {
            let at = |b: Vec2| uv[0] + (uv[1] - uv[0]) * f64::from(b.x) + (uv[2] - uv[0]) * f64::from(b.y);
            if !self.covered[c] && outline.relation(&self.corners[c].map(at)) == Relation::Inside {
                self.covered[c] = true;
                self.left[face as usize] -= 1;
            }
        }
    }

    /// Gives up a cell of `face` if it is still uncovered, so that it is not tried again.
    pub fn give_up(&mut self, face: u32, cell: usize) {
        if !self.covered[cell] {
            self.covered[cell] = true;
            self.left[face as usize] -= 1;
            self.lost[face as usize] += 1;
        }
    }

    /// Fraction of the area that is covered.
    pub fn coverage(&self) -> f64 {
        let cells = |f: usize| (self.start[f + 1] - self.start[f]) as f64;
        let part = |f: usize| self.areas[f] * (1.0 - f64::from(self.left[f] + self.lost[f]) / cells(f));
        (0..self.left.len()).map(part).sum::<f64>() / self.areas.iter().sum::<f64>()
    }
}
