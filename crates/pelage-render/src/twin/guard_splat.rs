//! Twin of `shaders/guard_splat.wgsl`: extinction at the nodes of the optical-depth lattice.

use crate::twin::lattice;
use crate::twin::lattice::{node_index, node_place};
use glam::Vec3;
use pelage_fur::layout::{Column, FurParameters, Root};
use pelage_fur::shell::{Located, Shell};
use pelage_fur::strands::{position, radius};
use pelage_fur::undercoat::Undercoat;

/// Largest extinction at a node, 1/cm: the largest finite number of 16 bits.
pub const LARGEST: f32 = 65504.0;

/// Deposits per segment.
const PARTS: u32 = 2;

/// Length times diameter of strands deposited at the nodes, cm², and its sum over the parts of the
/// strands that lie within the lattice.
pub fn deposits(
    shell: &Shell,
    fur: &FurParameters,
    roots: &[Root],
    vertices: &[[f32; 4]],
    segments: u32,
) -> (Vec<f64>, f64) {
    let mut nodes = vec![0.0; (fur.lattice.columns * (fur.lattice.levels + 1)) as usize];
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
            let cell = lattice::cell(fur, &place);
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

/// Volume that a node represents, cm³.
pub fn volume(shell: &Shell, fur: &FurParameters, column: &Column, level: u32) -> f32 {
    let (place, _) = node_place(shell, fur, column, level);
    let t = place.t;
    let flat = place.e1.cross(place.e2).length().max(1e-20);
    let raised = (place.e1 + t * place.w1).cross(place.e2 + t * place.w2).length();
    let height = place.extrusion(place.lambda).length() * fur.lattice.reach / fur.lattice.levels as f32;
    // The first and the last node of a column represent half a cell.
    let cells = if level == 0 || level == fur.lattice.levels { 0.5 } else { 1.0 };
    (column.area * (raised / flat).clamp(0.3, 4.0) * height * cells).max(1e-9)
}

/// Projected extinction at a node, 1/cm: that of the undercoat, and that of guard hairs that
/// deposited `deposit` cm².
pub fn extinction(
    fur: &FurParameters,
    undercoat: &Undercoat<'_>,
    column: &Column,
    level: u32,
    deposit: f64,
) -> [f32; 2] {
    let guard = (deposit as f32 / volume(undercoat.shell, fur, column, level)).min(LARGEST);
    let (place, _) = node_place(undercoat.shell, fur, column, level);
    if place.t > 1.0 {
        return [0.0, guard];
    }
    let p = undercoat.domain_point(&place, place.lambda);
    let t = place.t;
    let tangent = (place.direction(place.lambda) + Vec3::from(fur.undercoat.lean) * t).normalize();
    let density = column.density * undercoat.clump_density(p, p, t) * place.crowding(t, tangent);
    [(fur.undercoat.extinction * density).min(LARGEST), guard]
}
