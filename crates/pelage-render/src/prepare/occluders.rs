//! Skin and objects as occluders of light outside the shell.

use glam::Vec3;
use pelage_fur::layout::BvhNode;

/// Entries of the stack of `shared/bvh`. A traversal holds at most one node more than the tree
/// has levels below its root.
const STACK: u32 = 48;

/// A binary BVH over triangles: nodes as `shared/bvh` reads them, and the triangles' indices in the
/// order of the leaves. It is built by obvhs; where that is too deep for the stack,
/// as over many triangles in one place, by halves, with at most 32 levels.
pub(super) fn bvh(corners: &[[Vec3; 3]]) -> (Vec<BvhNode>, Vec<u32>) {
    let (nodes, order) = built(corners);
    if levels(&nodes) < STACK { (nodes, order) } else { halved(corners) }
}

/// Levels of a tree below its root.
fn levels(nodes: &[BvhNode]) -> u32 {
    let mut deepest = 0;
    let mut stack = vec![(0, 0)];
    while let Some((node, level)) = stack.pop() {
        deepest = level.max(deepest);
        let BvhNode { first, count, .. } = nodes[node as usize];
        if count == 0 {
            stack.extend([(first, level + 1), (first + 1, level + 1)]);
        }
    }
    deepest
}

/// A tree of which every node has half of its parent's triangles, those that come first along the
/// longest side of its box. Leaves hold one triangle.
fn halved(corners: &[[Vec3; 3]]) -> (Vec<BvhNode>, Vec<u32>) {
    let middle = |t: u32| corners[t as usize].iter().sum::<Vec3>();
    let mut order: Vec<u32> = (0..corners.len() as u32).collect();
    let mut nodes = vec![<BvhNode as bytemuck::Zeroable>::zeroed()];
    let mut rest = vec![(0, 0..order.len())];
    while let Some((node, range)) = rest.pop() {
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for corner in order[range.clone()].iter().flat_map(|t| corners[*t as usize]) {
            (low, high) = (low.min(corner), high.max(corner));
        }
        let (mut first, mut count) = (range.start as u32, range.len() as u32);
        if count > 1 {
            let side = high - low;
            let axis = (0..3).max_by(|a, b| side[*a].total_cmp(&side[*b])).unwrap_or(0);
            order[range.clone()].sort_by(|a, b| middle(*a)[axis].total_cmp(&middle(*b)[axis]));
            (first, count) = (nodes.len() as u32, 0);
            nodes.extend([<BvhNode as bytemuck::Zeroable>::zeroed(); 2]);
            let half = range.start + range.len() / 2;
            rest.extend([(first as usize, range.start..half), (first as usize + 1, half..range.end)]);
        }
        nodes[node] = BvhNode { low: low.into(), first, high: high.into(), count };
    }
    (nodes, order)
}

/// The tree of obvhs.
fn built(corners: &[[Vec3; 3]]) -> (Vec<BvhNode>, Vec<u32>) {
    use obvhs::{BvhBuildParams, bvh2::builder::build_bvh2_from_tris, triangle::Triangle};
    let triangles: Vec<Triangle> = corners
        .iter()
        .map(|corners| {
            let [v0, v1, v2] = corners.map(glam::Vec3A::from);
            Triangle { v0, v1, v2 }
        })
        .collect();
    // The builder recurses deeply where triangles coincide, so it gets a large stack.
    let built = std::thread::scope(|scope| {
        std::thread::Builder::new()
            .stack_size(256 << 20)
            .spawn_scoped(scope, || {
                build_bvh2_from_tris(&triangles, BvhBuildParams::fast_build(), &mut Default::default())
            })
            .map(std::thread::ScopedJoinHandle::join)
    });
    let Ok(Ok(tree)) = built else {
        return (vec![<BvhNode as bytemuck::Zeroable>::zeroed()], vec![0]);
    };
    let nodes = tree
        .nodes
        .iter()
        .map(|node| BvhNode {
            low: node.aabb().min.into(),
            first: node.first_index,
            high: node.aabb().max.into(),
            count: node.prim_count,
        })
        .collect();
    (nodes, tree.primitive_indices)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles in a row, each smaller and nearer than the one before it by the same factor.
    fn shrinking(count: i32) -> Vec<[Vec3; 3]> {
        let of = |i: i32| {
            let s = 0.7f32.powi(i);
            [Vec3::new(s, 0.0, 0.0), Vec3::new(1.1 * s, 0.0, 0.0), Vec3::new(s, 0.1 * s, 0.0)]
        };
        (0..count).map(of).collect()
    }

    /// Triangles of the leaves, each of which must lie in the boxes of all nodes above it.
    fn leaves(corners: &[[Vec3; 3]], nodes: &[BvhNode], order: &[u32]) -> Vec<u32> {
        let mut found = Vec::new();
        let mut stack = vec![(0, Vec3::NEG_INFINITY, Vec3::INFINITY)];
        while let Some((node, low, high)) = stack.pop() {
            let of: BvhNode = nodes[node as usize];
            let (low, high) = (low.max(of.low.into()), high.min(of.high.into()));
            if of.count == 0 {
                stack.extend([(of.first, low, high), (of.first + 1, low, high)]);
                continue;
            }
            for t in &order[of.first as usize..][..of.count as usize] {
                for corner in corners[*t as usize] {
                    assert!(corner.cmpge(low - 1e-6).all() && corner.cmple(high + 1e-6).all(), "{t}");
                }
                found.push(*t);
            }
        }
        found.sort_unstable();
        found
    }

    #[test]
    fn no_tree_is_deeper_than_the_stack_of_the_shader() {
        let shader = include_str!("../../../../shaders/shared/bvh.wgsl");
        assert!(shader.contains(&format!("array<u32, {STACK}>")));
        let corners = shrinking(120);
        assert!(levels(&built(&corners).0) >= STACK, "the case is not hard: {}", levels(&built(&corners).0));
        let (nodes, order) = bvh(&corners);
        assert!(levels(&nodes) <= 7, "{}", levels(&nodes));
        assert_eq!(leaves(&corners, &nodes, &order), (0..120).collect::<Vec<_>>());
    }
}
