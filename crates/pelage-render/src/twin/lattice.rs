//! Twin of `shaders/shared/{lattice,column,column_place,record}.wgsl`: the optical-depth lattice.
// Cf. [YukselKeyser2008]

use glam::{Vec2, Vec3};
use pelage_fur::layout::{Column, FurParameters};
use pelage_fur::shell::{Place, Shell};

/// The lattice cell that contains a place: three columns and two levels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// Numbers of the columns.
    pub columns: [u32; 3],
    /// Their weights, which add up to 1.
    pub weights: Vec3,
    /// The lower level.
    pub level: u32,
    /// Weight of the upper level.
    pub fraction: f32,
}

/// Column at grid point `k` of edge number `edge` from vertex `a` to `b`, counted from `a`.
fn edge_column(fur: &FurParameters, edge: u32, a: u32, b: u32, k: u32) -> u32 {
    let from_smaller = if a < b { k } else { fur.lattice.cells - k };
    fur.lattice.vertices + edge * (fur.lattice.cells - 1) + from_smaller - 1
}

/// Column at barycentric coordinates (n - i - j, i, j) / n of a place's triangle. Columns at the
/// skin's vertices come first, then those within edges, then those within triangles.
pub fn column_index(fur: &FurParameters, place: &Place, i: u32, j: u32) -> u32 {
    let n = fur.lattice.cells;
    let [a, b, c] = place.vertices;
    match (i, j) {
        (0, 0) => a,
        (i, _) if i == n => b,
        (_, j) if j == n => c,
        (i, 0) => edge_column(fur, place.edges[2], a, b, i),
        (0, j) => edge_column(fur, place.edges[1], a, c, j),
        (i, j) if i + j == n => edge_column(fur, place.edges[0], b, c, j),
        (i, j) => {
            let of_triangle = (n - 1) * (n - 2) / 2;
            let before: u32 = (1..j).map(|row| n - 1 - row).sum();
            fur.lattice.vertices + fur.lattice.edges * (n - 1) + place.prism * of_triangle + before + i - 1
        }
    }
}

/// The cell that contains a place.
pub fn cell(fur: &FurParameters, place: &Place) -> Cell {
    let height = (place.t / fur.lattice.reach).clamp(0.0, 1.0) * fur.lattice.levels as f32;
    let level = (height as u32).min(fur.lattice.levels - 1);
    let fraction = height - level as f32;
    let inside = place.lambda.max(Vec3::ZERO);
    let lambda = inside / (inside.x + inside.y + inside.z);
    let n = fur.lattice.cells;
    if n == 1 {
        return Cell { columns: place.vertices, weights: lambda, level, fraction };
    }
    let f = Vec2::new(lambda.y, lambda.z) * n as f32;
    let i = (f.x as u32).min(n - 1);
    let j = (f.y as u32).min(n - 1 - i);
    let r = f - Vec2::new(i as f32, j as f32);
    let column = |i, j| column_index(fur, place, i, j);
    let (columns, weights) = if r.x + r.y <= 1.0 || i + j + 1 == n {
        ([column(i, j), column(i + 1, j), column(i, j + 1)], Vec3::new((1.0 - r.x - r.y).max(0.0), r.x, r.y))
    } else {
        (
            [column(i + 1, j + 1), column(i, j + 1), column(i + 1, j)],
            Vec3::new(r.x + r.y - 1.0, 1.0 - r.x, 1.0 - r.y),
        )
    };
    Cell { columns, weights, level, fraction }
}

/// Number of the node of a column at a level, 0..=levels.
pub fn node_index(fur: &FurParameters, column: u32, level: u32) -> u32 {
    column * (fur.lattice.levels + 1) + level
}

/// Barycentric coordinates of a column in its triangle.
pub fn column_lambda(fur: &FurParameters, column: &Column) -> Vec3 {
    let n = fur.lattice.cells as f32;
    let (l1, l2) = ((column.grid & 0xffff) as f32 / n, (column.grid >> 16) as f32 / n);
    Vec3::new(1.0 - l1 - l2, l1, l2)
}

/// Height above the skin of a level, in shell heights.
pub fn level_height(fur: &FurParameters, level: u32) -> f32 {
    level as f32 / fur.lattice.levels as f32 * fur.lattice.reach
}

/// The place of a node, and its position (world, cm).
pub fn node_place(shell: &Shell, fur: &FurParameters, column: &Column, level: u32) -> (Place, Vec3) {
    let mut place = shell.enter(column.prism);
    place.lambda = column_lambda(fur, column);
    place.t = level_height(fur, level);
    (place, place.point(place.t, place.lambda))
}

/// Packs an albedo, 10 bits per channel.
pub fn pack_albedo(c: Vec3) -> u32 {
    let [r, g, b] = c.to_array().map(|x| (x.clamp(0.0, 1.0) * 1023.0).round_ties_even() as u32);
    r | (g << 10) | (b << 20)
}

/// The inverse of [`pack_albedo`].
pub fn unpack_albedo(word: u32) -> Vec3 {
    Vec3::new((word & 1023) as f32, ((word >> 10) & 1023) as f32, ((word >> 20) & 1023) as f32) / 1023.0
}
