//! Meshes from a file or a procedural shape, and the skin made from them.

mod colors;
mod duplicates;
pub mod gltf;
mod kind;
pub mod obj;
mod orient;
mod place;
pub mod ply;
mod polygon;
mod read;
mod repair;
pub mod shapes;
pub mod stl;
mod subdivide;
pub mod topology;
mod up;
mod write;

pub use kind::{MeshKind, kind_of};
pub use read::{Limits, read};
pub use repair::smoothed_normals;
pub use write::write_obj;

use crate::scene::{ColorSpace, MeshSpec, Units};
use crate::skin::Section;
use crate::{Error, Result, SceneFault, Skin};
use glam::{Vec2, Vec3};
use std::collections::HashMap;
use std::path::PathBuf;

/// A triangle mesh before welding: what the readers and the procedural shapes produce.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// The kind of file that it comes from; `None` for a shape.
    pub kind: Option<MeshKind>,
    /// The unit of the positions, where the format or the file states one.
    pub unit: Option<Units>,
    /// Vertex positions.
    pub positions: Vec<Vec3>,
    /// Vertex colours, 0..=1; empty where there are none.
    pub colors: Vec<Vec3>,
    /// Whether `colors` are encoded as sRGB; else they are linear.
    pub srgb: bool,
    /// Alpha of the vertices, 0..=1; empty where all are 1.
    pub alphas: Vec<f32>,
    /// Corner indices.
    pub triangles: Vec<[u32; 3]>,
    /// uv of each triangle corner, if the mesh has any; v = 0 is the lower edge of an image.
    pub corner_uv: Option<Vec<[Vec2; 3]>>,
    /// Parts of the mesh by name and material; empty where it has only one.
    pub sections: Vec<Section>,
    /// Index in `sections` for each triangle; empty where `sections` is.
    pub section_of: Vec<u32>,
    /// What reading noticed and did not need to repair.
    pub notes: Vec<String>,
    /// What reading repaired; an error where the scene has `mesh.strict`.
    pub repairs: Vec<String>,
}

/// Sections as a reader meets them.
#[derive(Debug, Default)]
pub(crate) struct Sections {
    pub list: Vec<Section>,
    known: HashMap<(String, String), u32>,
}

impl Sections {
    /// Index of the section with this group and material, which is added if it is new.
    pub fn index(&mut self, group: &str, material: &str) -> u32 {
        // Faces of one section follow each other.
        if let Some(last) = self.list.len().checked_sub(1)
            && (self.list[last].group.as_str(), self.list[last].material.as_str()) == (group, material)
        {
            return last as u32;
        }
        let next = self.list.len() as u32;
        let found = *self.known.entry((group.to_owned(), material.to_owned())).or_insert(next);
        if found == next {
            let (group, material) = (group.to_owned(), material.to_owned());
            self.list.push(Section { group, material, ..Section::default() });
        }
        found
    }
}

/// Welds positions, drops what cannot carry fur (zero-area and duplicate triangles, unused
/// vertices), winds the rest consistently and outwards, and smooths normals. The skin's
/// `notes` list each repair with its count, boundary, non-manifold and inconsistent edges, and the
/// number of parts.
pub fn skin_of(mesh: Mesh) -> Skin {
    repair::repair(mesh).0
}

/// Reads or builds the mesh that `spec` names, transforms it to world space (cm, +y up) and makes
/// it a skin. `find` resolves an asset name to a path.
///
/// A file without `size`, `scale` and `units` keeps its own unit if it states one that makes
/// sense, and is made 30 cm long otherwise; a note says so.
///
/// # Errors
/// [`Error::Scene`] where `spec` names no mesh or more than one, for faults of the file (with
/// lines), where no triangle is left, and with `spec.strict` for everything that was repaired or
/// left open, all in one; [`Error::Io`] where the file cannot be read.
pub fn load(spec: &MeshSpec, find: &dyn Fn(&str) -> Result<PathBuf>) -> Result<Skin> {
    load_like(spec, find, None)
}

/// As [`load`], but the file's coordinates are those of the file of another skin, and are taken to
/// world space as that was; of the keys that place a mesh only `translate` counts.
///
/// # Errors
/// As [`load`].
pub fn load_like(
    spec: &MeshSpec,
    find: &dyn Fn(&str) -> Result<PathBuf>,
    like: Option<&Skin>,
) -> Result<Skin> {
    let mut source = Source::default();
    let (name, mut skin) = match (&spec.path, spec.shape) {
        (Some(path), None) => {
            let path = find(path)?;
            let mut mesh = read(&path)?;
            mesh.srgb = spec.vertex_colors.map_or(mesh.srgb, |space| space == ColorSpace::Srgb);
            source = Source { kind: mesh.kind, unit: mesh.unit };
            let (skin, repairs) = repair::repair(mesh);
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
    let placed = match like {
        Some(like) => {
            place::place_like(&mut skin, spec, &like.world_from_file);
            Ok(())
        }
        None => place::place(&mut skin, spec, &source),
    };
    placed
        .and_then(|()| subdivide::check(&skin, spec.subdivide))
        .map_err(|message| Error::fault(name, message))?;
    let world_from_file = skin.world_from_file;
    for _ in 0..spec.subdivide {
        skin = subdivide::divided(&skin);
    }
    skin.world_from_file = world_from_file;
    Ok(if spec.faceted { skin.faceted() } else { skin })
}

/// What a mesh file states about its positions.
#[derive(Debug, Clone, Copy, Default)]
struct Source {
    kind: Option<MeshKind>,
    unit: Option<Units>,
}

impl From<Mesh> for Skin {
    fn from(mesh: Mesh) -> Self {
        skin_of(mesh)
    }
}
