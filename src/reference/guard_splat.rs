//! Twin of `shaders/guard_splat.wgsl`: what the guard hairs take from the light at the nodes of the light lattice.

use super::lattice::{self, column_spot, node_index};
use super::shell::{Located, Shell};
use super::strands::{position, radius};
use crate::layout::{Column, Fur, Root};

/// Deposits a segment.
const PARTS: u32 = 2;

/// Length times diameter of strands at the nodes, cm2, and how much of it lay within the shell.
pub fn deposits(
    shell: &Shell,
    fur: &Fur,
    roots: &[Root],
    vertices: &[[f32; 4]],
    segments: u32,
) -> (Vec<f64>, f64) {
    let mut nodes = vec![0.0; (fur.columns * (fur.levels + 1)) as usize];
    let mut total = 0.0;
    for (root, strand) in roots.iter().zip(vertices.chunks(segments as usize + 1)) {
        let mut place = shell.enter(root.prism);
        let parts = strand.windows(2).flat_map(|ends| (0..PARTS).map(move |part| (ends, part)));
        for (ends, part) in parts {
            let d = position(ends[1]) - position(ends[0]);
            let amount = d.length() * (radius(ends[0]) + radius(ends[1])) / PARTS as f32;
            let x = position(ends[0]) + d * ((part as f32 + 0.5) / PARTS as f32);
            if shell.locate(&mut place, x, d, 3) != Located::Inside {
                break;
            }
            let cell = lattice::cell(fur, place.prism, place.vertices, place.lambda, place.t);
            total += f64::from(amount);
            for (column, weight) in cell.columns.into_iter().zip(cell.weights.to_array()) {
                let node = node_index(fur, column, cell.level) as usize;
                nodes[node] += f64::from(amount * weight * (1.0 - cell.fraction));
                nodes[node + 1] += f64::from(amount * weight * cell.fraction);
            }
        }
    }
    (nodes, total)
}

/// Volume that each node stands for, cm3.
pub fn volumes(shell: &Shell, fur: &Fur, columns: &[Column]) -> Vec<f32> {
    let mut volumes = Vec::with_capacity(columns.len() * (fur.levels as usize + 1));
    for (i, column) in columns.iter().enumerate() {
        let (prism, lambda) = column_spot(fur, i as u32, column.corner);
        let place = shell.enter(prism);
        let height = place.extrusion(lambda).length() * fur.light_reach / fur.levels as f32;
        let flat = place.e1.cross(place.e2).length().max(1e-20);
        for level in 0..=fur.levels {
            let t = level as f32 / fur.levels as f32 * fur.light_reach;
            let raised = (place.e1 + t * place.w1).cross(place.e2 + t * place.w2).length();
            // The end nodes stand for half a cell.
            let cells = if level == 0 || level == fur.levels { 0.5 } else { 1.0 };
            volumes.push((column.area * (raised / flat).clamp(0.3, 4.0) * height * cells).max(1e-9));
        }
    }
    volumes
}

/// Extinction of the guard hairs at the nodes, 1/cm.
pub fn extinction(deposits: &[f64], volumes: &[f32]) -> Vec<f32> {
    deposits.iter().zip(volumes).map(|(d, v)| *d as f32 / v).collect()
}
