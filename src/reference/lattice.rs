//! Twin of `shaders/shared/lattice.wgsl` and `shaders/shared/column.wgsl`: the light lattice.

use crate::layout::Fur;
use glam::{Vec2, Vec3};

/// The lattice cell that holds a place: three columns, two levels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// Columns.
    pub columns: [u32; 3],
    /// Their weights, which add up to 1.
    pub weights: Vec3,
    /// The lower level.
    pub level: u32,
    /// Part of the upper level.
    pub fraction: f32,
}

/// Columns of a triangle in a lattice of `n` cells along an edge.
pub fn columns_per_triangle(n: u32) -> u32 {
    (n + 1) * (n + 2) / 2
}

/// Column `(i, j)` of a prism: row j counts from the edge between corners 0 and 1.
pub fn column_index(fur: &Fur, prism: u32, vertices: [u32; 3], i: u32, j: u32) -> u32 {
    if fur.lattice == 1 {
        return vertices[if j == 1 { 2 } else { i as usize }];
    }
    let before: u32 = (0..j).map(|row| fur.lattice + 1 - row).sum();
    prism * columns_per_triangle(fur.lattice) + before + i
}

/// The cell of a place; `t` in shell heights.
pub fn cell(fur: &Fur, prism: u32, vertices: [u32; 3], lambda: Vec3, t: f32) -> Cell {
    let height = (t / fur.light_reach).clamp(0.0, 1.0) * fur.levels as f32;
    let level = (height as u32).min(fur.levels - 1);
    let fraction = height - level as f32;
    let n = fur.lattice;
    if n == 1 {
        let inside = lambda.max(Vec3::ZERO);
        let weights = inside / (inside.x + inside.y + inside.z);
        return Cell { columns: vertices, weights, level, fraction };
    }
    let f = Vec2::new(lambda.y, lambda.z).clamp(Vec2::ZERO, Vec2::ONE) * n as f32;
    let j = (f.y as u32).min(n - 1);
    // Points on the far edge belong to the last upright cell of their row.
    let i = (f.x as u32).min(n - 1 - j);
    let r = (f - Vec2::new(i as f32, j as f32)).clamp(Vec2::ZERO, Vec2::ONE);
    let column = |i, j| column_index(fur, prism, vertices, i, j);
    let (columns, weights) = if r.x + r.y <= 1.0 || i + j + 2 > n {
        let sum = (r.x + r.y).max(1.0);
        (
            [column(i, j), column(i + 1, j), column(i, j + 1)],
            Vec3::new(1.0 - (r.x + r.y) / sum, r.x / sum, r.y / sum),
        )
    } else {
        (
            [column(i + 1, j + 1), column(i, j + 1), column(i + 1, j)],
            Vec3::new(r.x + r.y - 1.0, 1.0 - r.x, 1.0 - r.y),
        )
    };
    Cell { columns, weights, level, fraction }
}

/// Node of a column at a level, 0..=levels.
pub fn node_index(fur: &Fur, column: u32, level: u32) -> u32 {
    column * (fur.levels + 1) + level
}

/// Where a column stands: prism and barycentric coordinates. `corner` is 3 x triangle + corner where the columns are
/// the skin's vertices.
pub fn column_spot(fur: &Fur, column: u32, corner: u32) -> (u32, Vec3) {
    if fur.lattice == 1 {
        return (corner / 3, Vec3::AXES[(corner % 3) as usize]);
    }
    let n = fur.lattice;
    let prism = column / columns_per_triangle(n);
    let mut i = column % columns_per_triangle(n);
    let mut j = 0;
    while i > n - j {
        i -= n - j + 1;
        j += 1;
    }
    let (l1, l2) = (i as f32 / n as f32, j as f32 / n as f32);
    (prism, Vec3::new(1.0 - l1 - l2, l1, l2))
}

/// Words of packed optical depths at a node: two lights a word, the slot behind the last light is the eye's.
pub fn tau_pairs(fur: &Fur) -> u32 {
    (fur.lights + 2) / 2
}

/// Three 10-bit parts of 0..1 in a word.
pub fn pack_albedo(c: Vec3) -> u32 {
    let [r, g, b] = c.to_array().map(|x| (x.clamp(0.0, 1.0) * 1023.0).round_ties_even() as u32);
    r | (g << 10) | (b << 20)
}

/// The inverse of [`pack_albedo`].
pub fn unpack_albedo(word: u32) -> Vec3 {
    Vec3::new((word & 1023) as f32, ((word >> 10) & 1023) as f32, ((word >> 20) & 1023) as f32) / 1023.0
}
