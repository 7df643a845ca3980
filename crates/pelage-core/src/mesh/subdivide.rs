//! Division of every triangle into four, at the middles of its edges.

use crate::Skin;
use glam::Vec3;
use std::collections::HashMap;

/// Largest number of triangles that division may make.
const MOST: u64 = 20_000_000;

/// Checks the number of triangles after `levels` divisions.
pub(super) fn check(skin: &Skin, levels: u32) -> Result<(), String> {
    let triangles = (skin.triangles.len() as u64).saturating_mul(4u64.saturating_pow(levels));
    if levels > 0 && triangles > MOST {
        return Err(format!(
            "found mesh.subdivide = {levels}, which makes {triangles} triangles, expected at most {MOST}: \
             set a lower level"
        ));
    }
    Ok(())
}

/// The same surface with four triangles in the place of each. Triangles that share an edge share
/// the vertex in its middle; uv, colours, alphas and normals there are means of those at its ends.
pub(super) fn divided(skin: &Skin) -> Skin {
    let mut fine = Skin {
        triangles: Vec::with_capacity(4 * skin.triangles.len()),
        corner_uv: skin.corner_uv.as_ref().map(|uv| Vec::with_capacity(4 * uv.len())),
        section_of: skin.section_of.iter().flat_map(|section| [*section; 4]).collect(),
        ..skin.clone()
    };
    let mut middles = HashMap::with_capacity(2 * skin.triangles.len());
    for (t, v) in skin.triangles.iter().enumerate() {
        // The middle of the edge opposite each corner.
        let [a, b, c] = [0, 1, 2].map(|k| {
            let (from, to) = (v[(k + 1) % 3], v[(k + 2) % 3]);
            *middles.entry((from.min(to), from.max(to))).or_insert_with(|| fine.add_middle(from, to))
        });
        fine.triangles.extend([[v[0], c, b], [c, v[1], a], [b, a, v[2]], [a, b, c]]);
        if let (Some(coarse), Some(fine)) = (&skin.corner_uv, &mut fine.corner_uv) {
            let uv = coarse[t];
            let [a, b, c] = [0, 1, 2].map(|k| 0.5 * (uv[(k + 1) % 3] + uv[(k + 2) % 3]));
            fine.extend([[uv[0], c, b], [c, uv[1], a], [b, a, uv[2]], [a, b, c]]);
        }
    }
    fine
}

impl Skin {
    /// Adds a vertex in the middle of an edge; returns its number.
    fn add_middle(&mut self, from: u32, to: u32) -> u32 {
        let (from, to) = (from as usize, to as usize);
        let mean = |of: &[Vec3]| 0.5 * (of[from] + of[to]);
        let number = self.positions.len() as u32;
        self.positions.push(mean(&self.positions));
        self.normals.push(mean(&self.normals).try_normalize().unwrap_or(self.normals[from]));
        if !self.colors.is_empty() {
            self.colors.push(mean(&self.colors));
        }
        if !self.alphas.is_empty() {
            self.alphas.push(0.5 * (self.alphas[from] + self.alphas[to]));
        }
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{shapes, skin_of, topology};
    use crate::scene::Shape;

    #[test]
    fn division_keeps_surface_uv_and_edges() {
        for shape in [Shape::Plane, Shape::Torus, Shape::CylinderPelt] {
            let skin = skin_of(shapes::shape(shape));
            let fine = divided(&skin);
            assert_eq!(fine.triangles.len(), 4 * skin.triangles.len());
            assert!((fine.area() / skin.area() - 1.0).abs() < 1e-5, "{shape:?}");
            let edges = |skin: &Skin| {
                let neighbours = topology::neighbours(&skin.triangles).neighbours;
                neighbours.as_flattened().iter().filter(|n| **n == crate::skin::NONE).count()
            };
            assert_eq!(edges(&fine), 2 * edges(&skin), "{shape:?}: an open edge has two halves");
            for (t, uv) in fine.corner_uv.iter().flatten().enumerate() {
                // Same winding, a quarter of the uv area: u and v still belong to the positions.
                let coarse = skin.corner_uv.as_ref().expect("uv")[t / 4];
                let area = |[a, b, c]: [glam::Vec2; 3]| (b - a).perp_dot(c - a);
                assert!((4.0 * area(*uv) - area(coarse)).abs() < 1e-5, "{shape:?} {t}");
                let normal = |skin: &Skin, t: usize| {
                    let [a, b, c] = skin.corners(t);
                    (b - a).cross(c - a).normalize_or_zero()
                };
                assert!(normal(&fine, t).dot(normal(&skin, t / 4)) > 0.99, "{shape:?} {t}");
            }
        }
    }

    #[test]
    fn alphas_and_sections_are_divided() {
        let mut skin = skin_of(shapes::shape(Shape::Torus));
        skin.alphas = (0..skin.positions.len()).map(|v| (v % 5) as f32 / 4.0).collect();
        skin.section_of = (0..skin.triangles.len() as u32).map(|t| t % 3).collect();
        let fine = divided(&skin);
        assert_eq!((fine.alphas.len(), fine.section_of.len()), (fine.positions.len(), fine.triangles.len()));
        for (t, [a, b, c]) in skin.triangles.iter().enumerate() {
            assert_eq!(fine.section_of[4 * t..4 * t + 4], [skin.section_of[t]; 4]);
            let alpha = |v: u32| skin.alphas[v as usize];
            let middles = fine.triangles[4 * t + 3].map(|v| fine.alphas[v as usize]);
            let [a, b, c] = [a, b, c].map(|v| alpha(*v));
            assert_eq!(middles, [0.5 * (b + c), 0.5 * (c + a), 0.5 * (a + b)]);
        }
    }

    #[test]
    fn too_many_triangles_are_refused() {
        let skin = skin_of(shapes::shape(Shape::Hat));
        assert!(check(&skin, 5).is_ok());
        let message = check(&skin, 6).expect_err("5632 * 4096 is more than 20 million");
        assert!(message.contains("23068672") && message.contains("mesh.subdivide"), "{message}");
    }
}
