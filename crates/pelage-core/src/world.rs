//! The loaded scene: everything that the passes read, in world space and physical units.

use crate::assets::Assets;
use crate::light::Light;
use crate::maps::{self, MapSet, VERTEX_COLOR};
use crate::{Result, Scene, Skin};

/// A scene with its assets.
#[derive(Debug, Clone)]
pub struct World {
    /// The scene file's content.
    pub scene: Scene,
    /// The skin.
    pub skin: Skin,
    /// All lights, the environment's included.
    pub lights: Vec<Light>,
    /// The image maps that the groom names.
    pub maps: MapSet,
    /// Manifest of the textures that the scene names for its shells.
    pub textures: Option<std::path::PathBuf>,
}

impl World {
    /// Loads the files that `scene` names.
    ///
    /// # Errors
    /// [`crate::Error::Scene`] for files that are missing or damaged and for lights that make no
    /// sense; [`crate::Error::Io`] where a mesh cannot be read.
    pub fn load(scene: Scene, assets: &Assets) -> Result<Self> {
        let mut skin = crate::mesh::load(&scene.mesh, &|name| assets.find(name))?;
        if !skin.colored && maps::uses_vertex_color(&scene) {
            let name = match (&scene.mesh.path, scene.mesh.shape) {
                (Some(path), _) => path.clone(),
                (None, shape) => shape.map_or_else(String::new, |s| format!("the shape {s:?}")),
            };
            skin.notes.push(format!(
                "warning: {name} has no vertex colours: what the scene reads from \"{VERTEX_COLOR}\" is white everywhere"
            ));
        }
        crate::parts::check(&scene, &skin)?;
        skin.notes.extend(crate::parts::notes(&scene));
        let lights = crate::light::lights_of(&scene, assets)?;
        let maps = MapSet::load(&scene, assets)?;
        let textures = scene.shells.textures.as_ref().map(|name| assets.find(name)).transpose()?;
        Ok(Self { scene, skin, lights, maps, textures })
    }
}
