//! Reads a mesh file of any kind.

use super::kind::{MeshKind, head_of, kind_of_head, not_a_mesh};
use super::{Mesh, gltf, obj, ply, stl};
use crate::{Error, Result, SceneFault};
use std::path::Path;

/// Limits of a mesh file, checked before memory is spent on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// File size, bytes.
    pub bytes: u64,
    /// Vertices.
    pub vertices: u64,
    /// Triangles after cutting polygons.
    pub triangles: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { bytes: 8 << 30, vertices: 1 << 26, triangles: 1 << 26 }
    }
}

impl Limits {
    /// An error if a file has more.
    pub(super) fn check(&self, file: &Path, vertices: u64, triangles: u64) -> Result<()> {
        if vertices <= self.vertices && triangles <= self.triangles {
            return Ok(());
        }
        let found = format!(
            "found {vertices} vertices and {triangles} triangles, expected at most {} and {}",
            self.vertices, self.triangles
        );
        Err(too_large(file, found))
    }
}

pub(super) fn too_large(file: &Path, message: String) -> Error {
    Error::Scene(vec![SceneFault {
        file: file.to_owned(),
        line: 0,
        column: 0,
        message,
        help: Some("reduce the mesh (decimate it) or split it into several files".into()),
    }])
}

/// Reads a mesh: OBJ, glTF, GLB, PLY or STL, recognised by its content. Positions keep the file's
/// units and axes.
///
/// # Errors
/// [`Error::Io`] where the file, or one that it names, cannot be read; [`Error::Scene`] for a file
/// that is no mesh, for faults of its content (with lines where it has lines) and for one beyond
/// `Limits::default()`.
pub fn read(path: &Path) -> Result<Mesh> {
    let limits = Limits::default();
    let (head, size) = head_of(path).map_err(|e| Error::io(path, e))?;
    let Some(kind) = kind_of_head(&head, size, path) else {
        let (what, help) = not_a_mesh(&head)
            .unwrap_or(("no mesh that can be read", "give an OBJ, glTF, GLB, PLY or STL file"));
        return Err(Error::Scene(vec![SceneFault {
            file: path.to_owned(),
            line: 0,
            column: 0,
            message: format!("this is {what}, expected a mesh"),
            help: Some(help.into()),
        }]));
    };
    if size > limits.bytes {
        return Err(too_large(path, format!("found {size} bytes, expected at most {}", limits.bytes)));
    }
    let bytes = std::fs::read(path).map_err(|e| Error::io(path, e))?;
    let mut mesh = match kind {
        MeshKind::Obj => obj::read_bytes(&bytes, path, &limits)?,
        MeshKind::Gltf | MeshKind::Glb => gltf::parse(&bytes, path, &limits)?,
        MeshKind::Ply => guarded(path, kind, || ply::parse(&bytes, path, &limits))?,
        MeshKind::Stl => stl::parse(&bytes, path, &limits)?,
    };
    mesh.kind = Some(kind);
    let named = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    let other = MeshKind::ALL.into_iter().find(|k| k.extension() == named && *k != kind);
    let is_gltf = |k: MeshKind| matches!(k, MeshKind::Gltf | MeshKind::Glb);
    if other.is_some_and(|other| !(is_gltf(other) && is_gltf(kind))) {
        mesh.notes.push(format!("named .{named}, but read as the {} file that it is", kind.name()));
    }
    Ok(mesh)
}

/// Turns a panic of a reading library into an error.
pub(super) fn guarded<T>(file: &Path, kind: MeshKind, read: impl FnOnce() -> Result<T>) -> Result<T> {
    std::panic::catch_unwind(std::panic::AssertUnwindSafe(read)).unwrap_or_else(|_| {
        Err(Error::fault(file, format!("cannot be read as {}: the file is damaged", kind.name())))
    })
}
