//! Meshes without fur.

use crate::assets::Assets;
use crate::scene::ObjectMaterial;
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
                surface.notes.iter_mut().for_each(|note| *note = format!("object \"{}\": {note}", spec.name));
                objects.push(Object {
                    name: spec.name.clone(),
                    surface,
                    material: spec.material.clone(),
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
