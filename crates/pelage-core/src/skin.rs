//! The skin: the surface that carries the fur.

use glam::{Vec2, Vec3, Vec4};

/// Index of a missing neighbour: the edge is a boundary.
pub const NONE: u32 = u32::MAX;

/// The surface that carries the fur, in world space (cm).
///
/// Positions are welded, so that edges are shared wherever two triangles touch; uv coordinates stay
/// with the triangle corners, so that a uv seam does not cut the topology.
#[derive(Debug, Clone, Default)]
pub struct Skin {
    /// Vertex positions, cm, world space.
    pub positions: Vec<Vec3>,
    /// Smoothed unit normals, one per vertex, weighted by angle.
    pub normals: Vec<Vec3>,
    /// Vertex colours as read from the file (linear RGB), one per vertex, white where the file has
    /// none.
    pub colors: Vec<Vec3>,
    /// Corner indices of each triangle, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// uv of each triangle corner; `None` where the mesh has no uv (maps are then looked up
    /// triplanar).
    pub corner_uv: Option<Vec<[Vec2; 3]>>,
    /// Whether the mesh has vertex colours.
    pub colored: bool,
    /// Alpha of the vertices, 0..=1, one per vertex; empty where all are 1.
    pub alphas: Vec<f32>,
    /// Parts of the mesh by name and material, one at least for a skin that was loaded.
    pub sections: Vec<Section>,
    /// Index in `sections` of each triangle; empty where all are of the first.
    pub section_of: Vec<u32>,
    /// What loading repaired or noticed, to be reported to the user.
    pub notes: Vec<String>,
}

/// A part of a mesh: what one group or object of the file has of one material.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Section {
    /// Group or object (OBJ), node or mesh (glTF); empty where the file has none.
    pub group: String,
    /// Name of the material; empty where the file has none.
    pub material: String,
    /// Base colour of the material, linear RGB, a factor on the map where there is one (`Kd`,
    /// `baseColorFactor`).
    pub base_color: Option<[f32; 3]>,
    /// Image of the base colour, as a path from the working directory (`map_Kd`,
    /// `baseColorTexture`). Images within a GLB file have none; a note names them.
    pub base_map: Option<String>,
}

impl Skin {
    /// Vertex colour and alpha of vertex `v`; white and 1 where the skin has none.
    pub fn vertex_color(&self, v: usize) -> Vec4 {
        let alpha = self.alphas.get(v).copied().unwrap_or(1.0);
        self.colors.get(v).copied().unwrap_or(Vec3::ONE).extend(alpha)
    }

    /// Area of triangle `t`, cm².
    pub fn triangle_area(&self, t: usize) -> f32 {
        let [a, b, c] = self.corners(t);
        0.5 * (b - a).cross(c - a).length()
    }

    /// Corner positions of triangle `t`.
    pub fn corners(&self, t: usize) -> [Vec3; 3] {
        self.triangles[t].map(|i| self.positions[i as usize])
    }

    /// Total area, cm².
    pub fn area(&self) -> f64 {
        (0..self.triangles.len()).map(|t| f64::from(self.triangle_area(t))).sum()
    }

    /// The same surface with flat shading: each triangle has three vertices of its own, with the
    /// triangle's normal.
    pub fn faceted(mut self) -> Self {
        let corners = self.triangles.as_flattened();
        let positions: Vec<Vec3> = corners.iter().map(|v| self.positions[*v as usize]).collect();
        self.colors = corners.iter().map(|v| self.colors[*v as usize]).collect();
        if !self.alphas.is_empty() {
            self.alphas = corners.iter().map(|v| self.alphas[*v as usize]).collect();
        }
        let normal = |t: &[Vec3]| (t[1] - t[0]).cross(t[2] - t[0]).normalize_or(Vec3::Y);
        self.normals = positions.chunks_exact(3).flat_map(|t| [normal(t); 3]).collect();
        self.positions = positions;
        self.triangles = (0..self.triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        self
    }

    /// The same surface with sharp edges where the normals of neighbouring triangles are more than
    /// `crease` radians apart: there, vertices are split. A corner's normal is the sum of the
    /// normals of its own triangle and of those at the vertex within that angle of it, weighted by
    /// their angles at the vertex.
    // [ThurmerWuthrich1998]
    pub fn creased(mut self, crease: f32) -> Self {
        let mut around = vec![Vec::new(); self.positions.len()];
        for (t, corners) in self.triangles.iter().enumerate() {
            let p = self.corners(t);
            let Some(normal) = (p[1] - p[0]).cross(p[2] - p[0]).try_normalize() else { continue };
            for k in 0..3 {
                let angle = (p[(k + 1) % 3] - p[k]).angle_between(p[(k + 2) % 3] - p[k]);
                around[corners[k] as usize].push((t, k, normal, angle));
            }
        }
        let least = crease.cos();
        for (v, corners) in around.iter().enumerate() {
            // Normals at the vertex, and the vertex that has each.
            let mut known: Vec<(Vec3, u32)> = Vec::new();
            for (t, k, own, _) in corners {
                let near = corners.iter().filter(|(_, _, normal, _)| normal.dot(*own) >= least - 1e-6);
                let sum: Vec3 = near.map(|(_, _, normal, angle)| normal * angle).sum();
                let normal = sum.try_normalize().unwrap_or(*own);
                let same = known.iter().find(|(other, _)| other.abs_diff_eq(normal, 1e-5));
                let number = same.map_or_else(|| self.vertex_with(v, known.is_empty(), normal), |(_, n)| *n);
                if same.is_none() {
                    known.push((normal, number));
                }
                self.triangles[*t][*k] = number;
            }
        }
        self
    }

    /// Gives vertex `v`, or a new one like it unless `itself`, a normal; returns its number.
    fn vertex_with(&mut self, v: usize, itself: bool, normal: Vec3) -> u32 {
        if itself {
            self.normals[v] = normal;
            return v as u32;
        }
        self.positions.push(self.positions[v]);
        self.normals.push(normal);
        if let Some(color) = self.colors.get(v).copied() {
            self.colors.push(color);
        }
        if let Some(alpha) = self.alphas.get(v).copied() {
            self.alphas.push(alpha);
        }
        self.positions.len() as u32 - 1
    }

    /// Lowest and highest corner of the bounding box, cm.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.positions
            .iter()
            .fold((Vec3::splat(f32::INFINITY), Vec3::splat(f32::NEG_INFINITY)), |(lo, hi), p| {
                (lo.min(*p), hi.max(*p))
            })
    }
}
