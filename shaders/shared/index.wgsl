// Linear index of an invocation in a dispatch folded to two dimensions, with workgroups of 64.
fn linear_index(global_id: vec3u, groups: vec3u) -> u32 {
    return global_id.y * groups.x * 64u + global_id.x;
}
