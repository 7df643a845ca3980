//! Twin of `shaders/shared/shell.wgsl`: places in the prism shell, subelement indices, hops to
//! neighbours.

use crate::layout::{Prism, ShellVertex};
use glam::{IVec3, Vec3};
use pelage_core::skin::NONE;

/// Number of hops after which a point counts as lost.
pub const HOP_LIMIT: u32 = 16;

/// The prism shell, as the passes read it.
#[derive(Debug, Clone, Default)]
pub struct Shell {
    /// Skin vertices with directions and heights of extrusion.
    pub vertices: Vec<ShellVertex>,
    /// Prisms, one for each triangle of the skin, in the same order.
    pub prisms: Vec<Prism>,
    /// uv of the three corners of each triangle, `[3 · triangle + corner]`.
    pub corner_uv: Vec<[f32; 2]>,
    /// Top of the optical-depth lattice in shell heights; 1 if there is no lattice.
    pub light_reach: f32,
}

/// The coordinates of a point in the shell, and the geometry of the prism that contains it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Index of the prism, which is that of its triangle.
    pub prism: u32,
    /// Height in the shell: 0 at the skin, 1 at the top.
    pub t: f32,
    /// Barycentric coordinates in the triangle at height t.
    pub lambda: Vec3,
    /// Derivative of t along the ray of the last [`Shell::solve`], per unit of the ray.
    pub dt_dz: f32,
    /// Corner 0 of the skin triangle, cm.
    pub p0: Vec3,
    /// Edge from corner 0 to corner 1, cm.
    pub e1: Vec3,
    /// Edge from corner 0 to corner 2, cm.
    pub e2: Vec3,
    /// Extrusion at corner 0, cm.
    pub v0: Vec3,
    /// Extrusion at corner 1 minus that at corner 0, cm.
    pub w1: Vec3,
    /// Extrusion at corner 2 minus that at corner 0, cm.
    pub w2: Vec3,
    /// Indices of the triangle's vertices.
    pub vertices: [u32; 3],
    /// Prisms across the edges opposite the corners, or `NONE`.
    pub neighbours: [u32; 3],
    /// Indices of the edges opposite the corners, the same from both sides.
    pub edges: [u32; 3],
    /// Index of the prism's first subelement in the volume.
    pub cell_base: u32,
    /// Level d of subdivision: the triangle has 4^d cells.
    pub subdivision: u32,
}

/// Result of [`Shell::locate`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Located {
    /// The place is in the prism that contains the point.
    Inside,
    /// The point lies beyond a boundary edge of the skin.
    LeftBorder,
    /// Not found within [`HOP_LIMIT`] hops.
    Lost,
}

impl Shell {
    /// The place at corner 0 of a prism, on the skin.
    #[inline]
    pub fn enter(&self, index: u32) -> Place {
        let prism = self.prisms[index as usize];
        let [a, b, c] = prism.vertices.map(|v| self.vertices[v as usize]);
        let p0 = Vec3::from(a.position);
        let v0 = Vec3::from(a.normal) * a.height;
        Place {
            prism: index,
            t: 0.0,
            lambda: Vec3::X,
            dt_dz: 0.0,
            p0,
            e1: Vec3::from(b.position) - p0,
            e2: Vec3::from(c.position) - p0,
            v0,
            w1: Vec3::from(b.normal) * b.height - v0,
            w2: Vec3::from(c.normal) * c.height - v0,
            vertices: prism.vertices,
            neighbours: prism.neighbours,
            edges: prism.edges,
            cell_base: prism.cell_base,
            subdivision: prism.subdivision,
        }
    }

    /// Moves `place` into another prism, keeping t, lambda and dt_dz.
    pub fn hop(&self, place: &mut Place, index: u32) {
        *place = Place { t: place.t, lambda: place.lambda, dt_dz: place.dt_dz, ..self.enter(index) };
    }

    /// Solves for t and lambda of point `x` (cm) in the place's prism by Newton's method, starting
    /// from the place's t; `ray` is the direction for `dt_dz`.
    #[inline]
    pub fn solve(&self, place: &mut Place, x: Vec3, ray: Vec3, iterations: u32) {
        let highest = 1.5 * self.light_reach;
        let not_zero = |s: f32| if s.abs() < 1e-12 { -1e-12 } else { s };
        let mut t = place.t;
        for _ in 0..iterations {
            let (a, b, c) = place.frame_at(x, t);
            let n = b.cross(c);
            let slope = a.dot(place.w1.cross(c) + b.cross(place.w2)) - place.v0.dot(n);
            t = (t - a.dot(n) / not_zero(slope)).clamp(-0.5, highest);
        }
        let (a, b, c) = place.frame_at(x, t);
        let n = b.cross(c);
        let slope = a.dot(place.w1.cross(c) + b.cross(place.w2)) - place.v0.dot(n);
        let inverse = 1.0 / n.dot(n).max(1e-30);
        let l1 = a.cross(c).dot(n) * inverse;
        let l2 = b.cross(a).dot(n) * inverse;
        place.t = t;
        place.lambda = Vec3::new(1.0 - l1 - l2, l1, l2);
        place.dt_dz = -ray.dot(n) / not_zero(slope);
    }

    /// Locates point `x` (cm): solves in the place's prism and hops across the edge with the most
    /// negative barycentric coordinate until `x` is inside.
    // DEVIATION: [Andersen2016] sec. 3.2 hops across the closest edge.
    #[inline]
    pub fn locate(&self, place: &mut Place, x: Vec3, ray: Vec3, iterations: u32) -> Located {
        self.locate_by(place, x, ray, iterations, |place, _| most_negative(place.lambda))
    }

    /// [`Shell::locate`] with another rule for choosing the corner opposite the edge to cross.
    pub fn locate_by(
        &self,
        place: &mut Place,
        x: Vec3,
        ray: Vec3,
        iterations: u32,
        edge: impl Fn(&Place, Vec3) -> usize,
    ) -> Located {
        for _ in 0..HOP_LIMIT {
            self.solve(place, x, ray, iterations);
            let least = place.lambda.min_element();
            if least >= -1e-5 {
                return Located::Inside;
            }
            let next = place.neighbours[edge(place, x)];
            if next == NONE {
                // By rounding, a point on the border wall may lie slightly outside.
                return if least >= -2e-3 { Located::Inside } else { Located::LeftBorder };
            }
            self.hop(place, next);
        }
        Located::Lost
    }
}

/// The corner with the smallest barycentric coordinate, the lowest index among equals: it is
/// opposite the edge to cross.
pub fn most_negative(lambda: Vec3) -> usize {
    let least = lambda.min_element();
    if lambda.x == least {
        0
    } else if lambda.y == least {
        1
    } else {
        2
    }
}

impl Place {
    /// The forward map x(t, λ) = Σ λ_k (p_k + t v_k), cm.
    #[inline]
    pub fn point(&self, t: f32, lambda: Vec3) -> Vec3 {
        let skin = self.p0 + lambda.y * self.e1 + lambda.z * self.e2;
        skin + t * self.extrusion(lambda)
    }

    /// Vector from the skin to the shell's top at barycentric coordinates `lambda`, cm.
    #[inline]
    pub fn extrusion(&self, lambda: Vec3) -> Vec3 {
        self.v0 + lambda.y * self.w1 + lambda.z * self.w2
    }

    /// Direction of that vector, unit; the triangle's normal where the shell has no height.
    #[inline]
    pub fn direction(&self, lambda: Vec3) -> Vec3 {
        let v = self.extrusion(lambda);
        if v.length_squared() > 0.0 { v.normalize() } else { self.e1.cross(self.e2).normalize_or(Vec3::Y) }
    }

    /// Density at height `t` of hairs with unit direction `tangent`, relative to that at the skin:
    /// the area of the layer differs from the skin's, and hairs that lean pass through a smaller
    /// projected area.
    #[inline]
    pub fn crowding(&self, t: f32, tangent: Vec3) -> f32 {
        let skin = self.e1.cross(self.e2).length();
        let layer = (self.e1 + t * self.w1).cross(self.e2 + t * self.w2);
        skin / layer.dot(tangent).max(0.3 * layer.length().max(0.1 * skin))
    }

    /// The point relative to corner 0, and the two edges from there, of the triangle at height t.
    fn frame_at(&self, x: Vec3, t: f32) -> (Vec3, Vec3, Vec3) {
        (x - self.p0 - t * self.v0, self.e1 + t * self.w1, self.e2 + t * self.w2)
    }

    /// Index of subelement `id` of `layer` in the volume.
    pub fn volume_index(&self, layer: u32, id: u32) -> u32 {
        self.cell_base + (layer << (2 * self.subdivision)) + id // [Andersen2016] eq. 3
    }
}

/// Index of the cell that contains `lambda` in a triangle subdivided `d` times, 0..4^d.
pub fn subelement(lambda: Vec3, d: u32) -> u32 {
    let n = 1i32 << d;
    let i = ((Vec3::ONE - lambda) * n as f32).floor().as_ivec3(); // [Andersen2016] eq. 1
    let i = i.clamp(IVec3::ZERO, IVec3::splat(n - 1));
    let offset = (i.y - i.z).clamp(-i.x, i.x);
    (i.x * (1 + i.x) + offset) as u32 // [Andersen2016] eq. 2
}

/// Barycentric coordinates of a subelement's centroid; [`subelement`] maps them back to `id`.
pub fn subelement_centroid(id: u32, d: u32) -> Vec3 {
    let n = 1i32 << d;
    let row = id.isqrt() as i32;
    let offset = id as i32 - row * (row + 1);
    let upright = (offset - row) % 2 == 0;
    let sum = if upright { 2 * n - 2 } else { 2 * n - 1 };
    let i = IVec3::new(row, (sum - row + offset) / 2, (sum - row - offset) / 2);
    let inner = if upright { 2.0 / 3.0 } else { 1.0 / 3.0 };
    Vec3::ONE - (i.as_vec3() + inner) / n as f32
}
