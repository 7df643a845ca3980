//! Neighbours of triangles, by a table of directed edges, and counts of edges.

use crate::skin::NONE;

/// The neighbour table of a triangle mesh.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Topology {
    /// For triangle t, `neighbours[t][k]` is the triangle beyond the edge opposite corner k, the
    /// edge from corner k+1 to corner k+2 (mod 3); [`NONE`] at a boundary.
    pub neighbours: Vec<[u32; 3]>,
    /// Undirected edges.
    pub edges: usize,
    /// Undirected edges of one triangle.
    pub boundary_edges: usize,
    /// Undirected edges of more than two triangles.
    pub non_manifold_edges: usize,
    /// Undirected edges of two triangles that run along them in the same direction.
    pub inconsistent_edges: usize,
}

/// The key of the directed edge from vertex `a` to vertex `b`.
pub fn edge_key(a: u32, b: u32) -> u64 {
    (u64::from(a) << 32) | u64::from(b)
}

/// The neighbour table of `triangles`, whose corners must be three different vertices each.
///
/// The neighbour over the edge (a, b) of a triangle is the owner of the directed key (b, a), if
/// that key has exactly one owner and so has (a, b); else the edge counts as a boundary. So every
/// kind of fault (boundary, more than two triangles, opposite winding) ends in [`NONE`] on both
/// sides, and the table is symmetric.
pub fn neighbours(triangles: &[[u32; 3]]) -> Topology {
    let mut topology = Topology { neighbours: vec![[NONE; 3]; triangles.len()], ..Topology::default() };
    let edges = sorted_edges(triangles);
    for group in edges.chunk_by(|a, b| a.key == b.key) {
        topology.edges += 1;
        match group {
            [_] => topology.boundary_edges += 1,
            [a, b] if a.reversed != b.reversed => {
                topology.neighbours[a.triangle as usize][a.corner as usize] = b.triangle;
                topology.neighbours[b.triangle as usize][b.corner as usize] = a.triangle;
            }
            [_, _] => topology.inconsistent_edges += 1,
            _ => topology.non_manifold_edges += 1,
        }
    }
    topology
}

/// The edges without a neighbour, as (triangle, corner that the edge is opposite of), in the order
/// of triangles.
pub fn boundary_edges(topology: &Topology) -> Vec<(u32, u32)> {
    let sides = topology.neighbours.iter().enumerate();
    sides
        .flat_map(|(t, n)| (0..3).filter(move |k| n[*k] == NONE).map(move |k| (t as u32, k as u32)))
        .collect()
}

/// One side of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Edge {
    /// Key of the undirected edge: the smaller vertex first.
    pub key: u64,
    /// The triangle runs from the larger to the smaller vertex.
    pub reversed: bool,
    /// Owner.
    pub triangle: u32,
    /// The corner that the edge is opposite of.
    pub corner: u32,
}

/// All sides of all triangles, those on the same undirected edge next to each other.
pub(super) fn sorted_edges(triangles: &[[u32; 3]]) -> Vec<Edge> {
    let mut edges = Vec::with_capacity(3 * triangles.len());
    for (t, v) in triangles.iter().enumerate() {
        for k in 0..3 {
            let (a, b) = (v[(k + 1) % 3], v[(k + 2) % 3]);
            let key = edge_key(a.min(b), a.max(b));
            edges.push(Edge { key, reversed: a > b, triangle: t as u32, corner: k as u32 });
        }
    }
    edges.sort_unstable();
    edges
}
