//! Skin and objects as occluders of light outside the shell.

use glam::Vec3;
use pelage_fur::layout::BvhNode;

/// A binary BVH over triangles, built by obvhs: nodes as the shaders read them, and the triangles'
/// indices in the order of the leaves.
pub(super) fn bvh(corners: &[[Vec3; 3]]) -> (Vec<BvhNode>, Vec<u32>) {
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
