//! Meshes from a file or a procedural shape, and the skin made from them.

pub mod obj;
mod repair;
pub mod shapes;
mod subdivide;
pub mod topology;
mod write;

pub use repair::smoothed_normals;
pub use write::write_obj;

use crate::scene::MeshSpec;
use crate::{Error, Result, SceneFault, Skin};
use glam::{EulerRot, Quat, Vec2, Vec3};
use std::path::PathBuf;

/// A triangle mesh before welding: what the OBJ reader and the procedural shapes produce.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Vertex colours, linear RGB; empty where there are none.
    pub colors: Vec<Vec3>,
    /// Corner indices.
    pub triangles: Vec<[u32; 3]>,
    /// uv of each triangle corner, if the mesh has any.
    pub corner_uv: Option<Vec<[Vec2; 3]>>,
    /// What reading noticed and did not need to repair.
    pub notes: Vec<String>,
    /// What reading repaired; an error where the scene has `mesh.strict`.
    pub repairs: Vec<String>,
}

/// Welds positions, drops what cannot carry fur (zero-area and duplicate triangles, unused
/// vertices), winds the rest consistently (closed parts outwards) and smooths normals. The skin's
/// `notes` list each repair with its count, boundary, non-manifold and inconsistent edges, and the
/// number of parts.
pub fn skin_of(mesh: Mesh) -> Skin {
    repair::repair(mesh).0
}

/// Reads or builds the mesh that `spec` names, transforms it to world space (cm) and makes it a
/// skin. `find` resolves an asset name to a path.
///
/// # Errors
/// [`Error::Scene`] where `spec` names no mesh or more than one, for faults of the file (with
/// lines), where no triangle is left, and with `spec.strict` for everything that was repaired or
/// left open, all in one; [`Error::Io`] where the file cannot be read.
pub fn load(spec: &MeshSpec, find: &dyn Fn(&str) -> Result<PathBuf>) -> Result<Skin> {
    let (name, mut skin) = match (&spec.path, spec.shape) {
        (Some(path), None) => {
            let path = find(path)?;
            let (skin, repairs) = repair::repair(obj::read(&path)?);
            if spec.strict && !repairs.is_empty() {
                return Err(Error::Scene(vec![SceneFault {
                    file: path,
                    line: 0,
                    column: 0,
                    message: format!(
                        "found {}, expected a mesh without faults because mesh.strict is set",
                        repairs.join("; ")
                    ),
                    help: Some(
                        "repair the mesh, or leave mesh.strict out to render it with these repairs".into(),
                    ),
                }]));
            }
            (path.display().to_string(), skin)
        }
        (None, Some(shape)) => {
            let mut skin = skin_of(shapes::shape(shape));
            // Procedural shapes are open or have several parts by design.
            skin.notes.clear();
            (format!("{shape:?}"), skin)
        }
        (None, None) => {
            return Err(Error::fault("mesh", "found neither mesh.path nor mesh.shape, expected one of them"));
        }
        (Some(_), Some(_)) => {
            return Err(Error::fault("mesh", "found both mesh.path and mesh.shape, expected one of them"));
        }
    };
    if skin.triangles.is_empty() {
        return Err(Error::fault(
            name,
            format!("no triangle is left to carry fur, expected one or more; {}", skin.notes.join("; ")),
        ));
    }
    let placed = place(&mut skin, spec).and_then(|()| subdivide::check(&skin, spec.subdivide));
    placed.map_err(|message| Error::fault(name, message))?;
    for _ in 0..spec.subdivide {
        skin = subdivide::divided(&skin);
    }
    Ok(if spec.faceted { skin.faceted() } else { skin })
}

/// Centre, size, scale, rotation (x, then y, then z), translation: in this order.
fn place(skin: &mut Skin, spec: &MeshSpec) -> Result<(), String> {
    for (name, value) in [("mesh.size", spec.size), ("mesh.scale", spec.scale)] {
        if let Some(v) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
            return Err(format!("found {name} = {v}, expected a number above 0"));
        }
    }
    for (name, value) in [("mesh.rotate", spec.rotate), ("mesh.translate", spec.translate)] {
        if !value.iter().all(|v| v.is_finite()) {
            return Err(format!("found {name} = {value:?}, expected finite numbers"));
        }
    }
    let (low, high) = skin.bounds();
    let (low, high) = (low.as_dvec3(), high.as_dvec3());
    let center = if spec.center { (low + high) / 2.0 } else { glam::DVec3::ZERO };
    let side = (high - low).max_element();
    let scale = spec.size.map_or(1.0, |size| f64::from(size) / side) * spec.scale.map_or(1.0, f64::from);
    let [x, y, z] = spec.rotate.map(f32::to_radians);
    // Applied to a column vector: x first.
    let world_from_object = Quat::from_euler(EulerRot::ZYX, z, y, x);
    for p in &mut skin.positions {
        let scaled = ((p.as_dvec3() - center) * scale).as_vec3();
        *p = world_from_object * scaled + Vec3::from_array(spec.translate);
    }
    for n in &mut skin.normals {
        *n = (world_from_object * *n).normalize_or(Vec3::Y);
    }
    let largest = skin.positions.iter().map(|p| p.abs().max_element()).fold(0.0, f32::max);
    if !skin.positions.iter().all(|p| p.is_finite()) || largest > MAX_COORDINATE {
        return Err(format!(
            "found coordinates up to {largest:e} cm, expected at most {MAX_COORDINATE:e}: set mesh.size"
        ));
    }
    if (0..skin.triangles.len()).all(|t| skin.triangle_area(t) == 0.0) {
        return Err(format!(
            "found a mesh whose largest side is {:e} cm, expected triangles with an area: set mesh.size",
            side * scale
        ));
    }
    Ok(())
}

/// Largest coordinate, cm: beyond it, squares of areas overflow f32.
const MAX_COORDINATE: f32 = 1e8;

impl From<Mesh> for Skin {
    fn from(mesh: Mesh) -> Self {
        skin_of(mesh)
    }
}
