//! Coverage rows: how far each part that chooses groups, materials or balls reaches, at the corners
//! of the triangles and at the vertices.

use glam::Vec3;
use half::f16;
use pelage_core::scene::{Part, Scene};
use pelage_core::{Skin, parts};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Coverage where a part is far away; halves go down to −65,504.
const FAR: f32 = -60_000.0;

/// Coverage of the parts that choose a region of the mesh.
pub(super) struct Coverage {
    /// Number of halves of a row that are used.
    pub lanes: u32,
    /// By lane, three for each triangle.
    corners: Vec<Vec<f32>>,
    /// By lane, one for each vertex.
    vertices: Vec<Vec<f32>>,
}

impl Coverage {
    /// The coverage of all parts of `scene` that choose a region, in their order.
    pub fn new(scene: &Scene, skin: &Skin) -> Self {
        let (mut corners, mut vertices) = (Vec::new(), Vec::new());
        for part in scene.parts.iter().filter(|part| part.has_region()) {
            let (of_corners, of_vertices) = coverage(skin, part);
            corners.push(of_corners);
            vertices.push(of_vertices);
        }
        Self { lanes: corners.len() as u32, corners, vertices }
    }

    /// Texels of a row, four halves each.
    pub fn texels_of_row(&self) -> u32 {
        self.lanes.div_ceil(4)
    }

    /// All rows: those of the corners, then those of the vertices.
    pub fn texels(&self) -> impl Iterator<Item = [u32; 2]> + '_ {
        let rows = |lanes: &Vec<Vec<f32>>| lanes.first().map_or(0, Vec::len);
        self.rows(&self.corners, rows(&self.corners)).chain(self.rows(&self.vertices, rows(&self.vertices)))
    }

    fn rows<'a>(&self, lanes: &'a [Vec<f32>], rows: usize) -> impl Iterator<Item = [u32; 2]> + 'a {
        let half = move |lane: u32, row: usize| {
            let value = lanes.get(lane as usize).map_or(FAR, |lane| lane[row]);
            u32::from(f16::from_f32(value).to_bits())
        };
        let texels = self.texels_of_row();
        (0..rows).flat_map(move |row| {
            (0..texels).map(move |texel| {
                [0, 2].map(|k| half(4 * texel + k, row) | (half(4 * texel + k + 1, row) << 16))
            })
        })
    }
}

/// Coverage by triangle corner and by vertex: 1 on the chosen triangles and on the sphere of a
/// ball; outside of them it falls by 1 per `edge` cm, below 0 too, and in a ball it rises, so that
/// it can be interpolated before it is cut.
/// If `edge` is 0, each triangle has its own, a ball those whose middle it holds; a vertex then
/// belongs to the part only if all triangles around it do, so that a bare part does not lower the
/// fur beside it.
fn coverage(skin: &Skin, part: &Part) -> (Vec<f32>, Vec<f32>) {
    let (chosen, edge) = (parts::chosen(skin, part), part.edge_cm());
    let mut vertices = vec![1.0; skin.positions.len()];
    if edge <= 0.0 {
        let in_ball = |t: usize| {
            let middle = skin.corners(t).iter().sum::<Vec3>() / 3.0;
            parts::depth_in_balls(part, middle) >= 0.0
        };
        let of_triangle = |t: usize| if chosen[t] && in_ball(t) { 1.0 } else { FAR };
        for (t, triangle) in skin.triangles.iter().enumerate() {
            triangle.iter().for_each(|v| {
                let vertex = &mut vertices[*v as usize];
                *vertex = of_triangle(t).min(*vertex);
            });
        }
        return ((0..3 * skin.triangles.len()).map(|corner| of_triangle(corner / 3)).collect(), vertices);
    }
    if part.has_sections() {
        for (vertex, distance) in vertices.iter_mut().zip(distances(skin, &chosen, edge)) {
            *vertex = 1.0 - distance / edge;
        }
    }
    if !part.balls.is_empty() {
        for (vertex, p) in vertices.iter_mut().zip(&skin.positions) {
            let inside = 1.0 + parts::depth_in_balls(part, *p) / edge;
            *vertex = if part.has_sections() { vertex.min(inside) } else { inside };
        }
    }
    vertices.iter_mut().for_each(|vertex| *vertex = vertex.clamp(FAR, -FAR));
    (skin.triangles.as_flattened().iter().map(|v| vertices[*v as usize]).collect(), vertices)
}

/// A vertex that waits in the order of its distance. Distances are not negative, so that their bits
/// have the same order.
type Waiting = Reverse<(u32, u32)>;

/// Distance along the skin of each vertex from the chosen triangles, cm; 0 on them. Exact where the
/// front is straight. Vertices whose neighbours are all further away than `reach` have an infinite
/// distance.
// [KimmelSethian1998]
fn distances(skin: &Skin, chosen: &[bool], reach: f32) -> Vec<f32> {
    let count = skin.positions.len();
    let mut around = vec![Vec::new(); count];
    let mut found = vec![f32::INFINITY; count];
    for (t, triangle) in skin.triangles.iter().enumerate() {
        for v in triangle.map(|v| v as usize) {
            around[v].push(t as u32);
            if chosen[t] {
                found[v] = 0.0;
            }
        }
    }
    let waiting = |v: usize, distance: f32| Reverse((distance.to_bits(), v as u32));
    let start = (0..count).filter(|v| found[*v] == 0.0);
    let mut queue: BinaryHeap<Waiting> = start.map(|v| waiting(v, 0.0)).collect();
    let mut done = vec![false; count];
    while let Some(Reverse((bits, v))) = queue.pop() {
        let v = v as usize;
        if std::mem::replace(&mut done[v], true) || f32::from_bits(bits) > reach {
            continue;
        }
        for t in &around[v] {
            let corners = skin.triangles[*t as usize].map(|v| v as usize);
            for k in 0..3 {
                let (c, others) = (corners[k], [corners[(k + 1) % 3], corners[(k + 2) % 3]]);
                if done[c] || !others.contains(&v) {
                    continue;
                }
                let distance = beyond(skin, c, others, &found);
                if distance < found[c] {
                    found[c] = distance;
                    queue.push(waiting(c, distance));
                }
            }
        }
    }
    found
}

/// Distance of corner `c` of a triangle by those of its two other corners: of the straight front
/// through these where it crosses the triangle, else along an edge.
fn beyond(skin: &Skin, c: usize, [a, b]: [usize; 2], found: &[f32]) -> f32 {
    let [pa, pb, pc] = [a, b, c].map(|v| skin.positions[v]);
    let along_edges = (found[a] + pa.distance(pc)).min(found[b] + pb.distance(pc));
    let base = pa.distance(pb);
    let Some(x) = (pb - pa).try_normalize().filter(|_| found[a].is_finite() && found[b].is_finite()) else {
        return along_edges;
    };
    // The triangle in its plane: a at the origin, b on the x axis, c at (cx, cy) above it.
    let cx = (pc - pa).dot(x);
    let cy = (pc - pa - cx * x).length();
    let gx = (found[b] - found[a]) / base;
    let gy = (1.0 - gx * gx).max(0.0).sqrt();
    let crossing = cx - cy * gx / gy.max(1e-6);
    if gx.abs() < 1.0 && (-1e-4 * base..=1.0001 * base).contains(&crossing) {
        along_edges.min(found[a] + gx * cx + gy * cy)
    } else {
        along_edges
    }
}
