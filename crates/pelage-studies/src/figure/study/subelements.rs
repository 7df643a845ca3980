//! The subelements of a prism as bodies, for the studies that draw or intersect them. The
//! renderer's own functions give their numbers.

use glam::Vec3;
use pelage_fur::shell::{Place, subelement};

/// Barycentric corners of the `4^d` cells of a triangle that is subdivided `d` times, by number.
pub(super) fn cells(d: u32) -> Vec<[Vec3; 3]> {
    let n = 1i32 << d;
    let at = |a: i32, b: i32, c: i32| Vec3::new(a as f32, b as f32, c as f32) / n as f32;
    let mut cells = vec![[Vec3::ZERO; 3]; 1 << (2 * d)];
    let mut put = |cell: [Vec3; 3]| {
        let middle = (cell[0] + cell[1] + cell[2]) / 3.0;
        cells[subelement(middle, d) as usize] = cell;
    };
    for a in 0..n {
        for b in 0..n - a {
            let c = n - 1 - a - b;
            put([at(a + 1, b, c), at(a, b + 1, c), at(a, b, c + 1)]);
            if c > 0 {
                put([at(a, b + 1, c), at(a + 1, b, c), at(a + 1, b + 1, c - 1)]);
            }
        }
    }
    cells
}

/// Corners of a subelement in space, cm: first the lower, then the upper three.
pub(super) fn corners(place: &Place, cell: &[Vec3; 3], layer: u32, layers: u32) -> [Vec3; 6] {
    let height = |l: u32| l as f32 / layers as f32;
    let [a, b, c] = *cell;
    let at = |t: f32, l: Vec3| place.point(t, l);
    let (low, high) = (height(layer), height(layer + 1));
    [at(low, a), at(low, b), at(low, c), at(high, a), at(high, b), at(high, c)]
}

/// The convex polygon in which a plane through `origin` cuts a body of six corners; empty if it
/// misses. The slightly curved walls of the body count as flat.
pub(super) fn cut(corners: &[Vec3; 6], origin: Vec3, normal: Vec3) -> Vec<Vec3> {
    const EDGES: [[usize; 2]; 9] = [[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]];
    let side = corners.map(|p| (p - origin).dot(normal));
    let mut points: Vec<Vec3> = EDGES
        .iter()
        .filter(|[a, b]| (side[*a] < 0.0) != (side[*b] < 0.0))
        .map(|[a, b]| corners[*a].lerp(corners[*b], side[*a] / (side[*a] - side[*b])))
        .collect();
    if points.len() < 3 {
        return Vec::new();
    }
    let middle = points.iter().sum::<Vec3>() / points.len() as f32;
    let x = (points[0] - middle).normalize_or(normal.any_orthonormal_vector());
    let y = normal.cross(x);
    let angle = |p: &Vec3| (*p - middle).dot(y).atan2((*p - middle).dot(x));
    points.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_has_a_cell_of_equal_area() {
        for d in 0..5 {
            let cells = cells(d);
            let area = |c: &[Vec3; 3]| (c[1] - c[0]).cross(c[2] - c[0]).length();
            let whole = (Vec3::Y - Vec3::X).cross(Vec3::Z - Vec3::X).length();
            for (id, cell) in cells.iter().enumerate() {
                assert!((area(cell) * cells.len() as f32 / whole - 1.0).abs() < 1e-3, "d = {d}, id {id}");
                // Also near the corners, not only at the centroid by which the cell was numbered.
                for k in 0..3 {
                    let middle = (cell[0] + cell[1] + cell[2]) / 3.0;
                    let near = middle.lerp(cell[k], 0.9);
                    assert_eq!(subelement(near, d), id as u32, "d = {d}, corner {k}");
                }
            }
        }
    }

    #[test]
    fn a_plane_cuts_a_prism() {
        let base = [Vec3::ZERO, Vec3::X, Vec3::Y];
        let body = [base[0], base[1], base[2], base[0] + Vec3::Z, base[1] + Vec3::Z, base[2] + Vec3::Z];
        assert_eq!(cut(&body, Vec3::new(0.0, 0.0, 0.5), Vec3::Z).len(), 3);
        assert_eq!(cut(&body, Vec3::new(0.2, 0.0, 0.0), Vec3::X).len(), 4);
        assert!(cut(&body, Vec3::new(2.0, 0.0, 0.0), Vec3::X).is_empty());
    }
}
