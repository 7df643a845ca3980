//! Meshes without fur.

use crate::assets::Assets;
use crate::maps::{VERTEX_COLOR, white_vertices};
use crate::scene::{Color, ObjectMaterial};
use crate::{Error, Result, Scene, Skin, mesh};

/// A mesh without fur, in world space.
#[derive(Debug, Clone)]
pub struct Object {
    /// Its name in the scene.
    pub name: String,
    /// Its surface, cm.
    pub surface: Skin,
    /// Its material.
    pub material: ObjectMaterial,
    /// Its translation, cm: maps without uv move with it.
    pub origin: [f32; 3],
    /// Whether only the shadow on it is seen.
    pub shadow_catcher: bool,
}

/// Loads the objects of a scene. Notes on a surface begin with the object's name.
///
/// # Errors
/// [`Error::Scene`] for objects without a mesh, or whose mesh is missing or damaged, with the
/// object's name; all objects' faults come together. [`Error::Io`] where a file cannot be read.
pub fn load(scene: &Scene, assets: &Assets) -> Result<Vec<Object>> {
    let mut faults = Vec::new();
    let mut objects = Vec::new();
    for spec in &scene.objects {
        match mesh::load(&spec.mesh, &|name| assets.find(name)) {
            Ok(mut surface) => {
                if !spec.mesh.faceted {
                    surface = surface.creased(spec.crease.to_radians());
                }
                let colored = matches!(&spec.material.color, Color::Mapped(m) if m.map == VERTEX_COLOR);
                if colored && !surface.colored {
                    surface.notes.push(white_vertices(&spec.mesh));
                }
                surface.notes.iter_mut().for_each(|note| *note = of_object(&spec.name, note));
                objects.push(Object {
                    name: spec.name.clone(),
                    surface,
                    material: spec.material.clone(),
                    origin: spec.mesh.translate,
                    shadow_catcher: spec.shadow_catcher,
                });
            }
            Err(Error::Scene(found)) => faults.extend(found.into_iter().map(|mut fault| {
                fault.message = format!("object \"{}\": {}", spec.name, fault.message);
                fault
            })),
            Err(other) => return Err(other),
        }
    }
    if faults.is_empty() { Ok(objects) } else { Err(Error::Scene(faults)) }
}

/// A note with the object's name behind the word that marks a warning.
fn of_object(name: &str, note: &str) -> String {
    match note.strip_prefix("warning: ") {
        Some(rest) => format!("warning: object \"{name}\": {rest}"),
        None => format!("object \"{name}\": {note}"),
    }
}
