//! The loaded scene: everything that the passes read, in world space and physical units.

use crate::assets::Assets;
use crate::light::Light;
use crate::maps::MapSet;
use crate::objects::{self, Object};
use crate::{Result, Scene, Skin};

/// A scene with its assets.
#[derive(Debug, Clone)]
pub struct World {
    /// The scene file's content.
    pub scene: Scene,
    /// The skin.
    pub skin: Skin,
    /// Meshes without fur.
    pub objects: Vec<Object>,
    /// All lights, the environment's included.
    pub lights: Vec<Light>,
    /// The image maps that the groom names.
    pub maps: MapSet,
    /// Manifest of the textures that the scene names for its shells.
    pub textures: Option<std::path::PathBuf>,
}

impl World {
    /// Number of triangles of the skin and of all objects.
    pub fn triangles(&self) -> u64 {
        let objects: usize = self.objects.iter().map(|o| o.surface.triangles.len()).sum();
        (self.skin.triangles.len() + objects) as u64
    }

    /// What loading the meshes repaired or noticed: the skin's notes, then those of the objects.
    pub fn mesh_notes(&self) -> impl Iterator<Item = &String> {
        self.skin.notes.iter().chain(self.objects.iter().flat_map(|o| &o.surface.notes))
    }

    /// Loads the files that `scene` names.
    ///
    /// # Errors
    /// [`crate::Error::Scene`] for files that are missing or damaged and for lights that make no
    /// sense; [`crate::Error::Io`] where a mesh cannot be read.
    pub fn load(scene: Scene, assets: &Assets) -> Result<Self> {
        let skin = crate::mesh::load(&scene.mesh, &|name| assets.find(name))?;
        let objects = objects::load(&scene, assets)?;
        let lights = crate::light::lights_of(&scene, assets)?;
        let maps = MapSet::load(&scene, assets)?;
        let textures = scene.shells.textures.as_ref().map(|name| assets.find(name)).transpose()?;
        Ok(Self { scene, skin, objects, lights, maps, textures })
    }
}
