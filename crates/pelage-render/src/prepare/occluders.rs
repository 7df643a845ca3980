//! The skin as an occluder of light outside the shell.

use pelage_core::Skin;
use pelage_fur::layout::BvhNode;

/// A binary BVH over the skin's triangles, built by obvhs: nodes as `light_occlusion` reads them,
/// and triangle numbers in the order of the leaves.
pub(super) fn bvh(skin: &Skin) -> (Vec<BvhNode>, Vec<u32>) {
    use obvhs::{BvhBuildParams, bvh2::builder::build_bvh2_from_tris, triangle::Triangle};
    let triangles: Vec<Triangle> = (0..skin.triangles.len())
        .map(|t| {
            let [v0, v1, v2] = skin.corners(t).map(glam::Vec3A::from);
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
