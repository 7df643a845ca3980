//! Lapped textures: a skin covered with patches, each flattened, so that one small toroidal texture clothes any mesh.
//! The method is that of Praun, Finkelstein and Hoppe 2000; the variant without overlap is that of Lengyel et al. 2001.
// [Praun2000], [Lengyel2001] sec. 3.2

use glam::{Vec2, Vec3};

/// A skin covered with patches.
#[derive(Debug, Clone, Default)]
pub struct Lapped {
    /// Direction of the hair on each face: unit, tangent to the face, world space.
    pub field: Vec<Vec3>,
    /// The patches in the order in which they are pasted: a later one lies on the earlier ones.
    pub patches: Vec<Patch>,
    /// The patch that each face shows: the last one pasted that covers it whole.
    pub topmost: Vec<u32>,
    /// uv of each face's corners in its topmost patch, cm: u runs along the field, v across (normal x field). Not wrapped: divide by
    /// the torus's edge for texture coordinates.
    pub corner_uv: Vec<[Vec2; 3]>,
}

/// A flattened piece of the skin.
#[derive(Debug, Clone, Default)]
pub struct Patch {
    /// Its faces, in the order in which it grew.
    pub faces: Vec<u32>,
    /// uv of the corners of each of `faces`, cm, the outline's centre at the origin.
    pub corner_uv: Vec<[Vec2; 3]>,
}
