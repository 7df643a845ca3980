//! The loaded scene: everything that the passes read, in world space and physical units.

use crate::assets::Assets;
use crate::film::composite::load_plate;
use crate::light::Light;
use crate::maps::{self, MapSet};
use crate::objects::{self, Object};
use crate::scene::{Background, FurLayers};
use crate::{Result, Scene, Skin, stage};

/// A scene with its assets.
#[derive(Debug, Clone)]
pub struct World {
    /// The scene file's content, with the camera and the lights that were chosen for it.
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
    /// What loading repaired, noticed or chose, to be reported to the user.
    pub notes: Vec<String>,
}

impl World {
    /// Number of triangles of the skin and of all objects.
    pub fn triangles(&self) -> u64 {
        let objects: usize = self.objects.iter().map(|o| o.surface.triangles.len()).sum();
        (self.skin.triangles.len() + objects) as u64
    }

    /// Loads the files that `scene` names, and completes its camera and light where it gives none.
    ///
    /// # Errors
    /// [`crate::Error::Scene`] for files that are missing or damaged, the plate behind the fur
    /// included, and for lights that make no sense; [`crate::Error::Io`] where a mesh cannot be
    /// read.
    pub fn load(mut scene: Scene, assets: &Assets) -> Result<Self> {
        let mut skin = crate::mesh::load(&scene.mesh, &|name| assets.find(name))?;
        if !skin.colored && maps::uses_vertex_color(&scene) {
            skin.notes.push(maps::white_vertices(&scene.mesh));
        }
        crate::parts::check(&scene, &skin)?;
        skin.notes.extend(crate::parts::notes(&scene));
        let objects = objects::load(&scene, &skin, assets)?;
        let mut notes = skin.notes.clone();
        notes.extend(objects.iter().flat_map(|o| o.surface.notes.iter().cloned()));
        if scene.render.fur == FurLayers::Shells && !objects.is_empty() {
            notes.push("a picture of shells and fins does not show the scene's objects, only their shadows on the fur".into());
        }
        notes.extend(stage::complete(&mut scene, &skin));
        let lights = crate::light::lights_of(&scene, assets, &mut notes)?;
        if scene.film.background == Background::Plate {
            // Read again for each picture; here its faults and notes count.
            load_plate(&scene, assets, &mut notes)?;
        }
        let maps = MapSet::load(&scene, assets)?;
        notes.extend(maps.notes.iter().cloned());
        notes.extend(crate::map_detail::notes(&scene, &skin, &maps));
        let textures = scene.shells.textures.as_ref().map(|name| assets.find(name)).transpose()?;
        Ok(Self { scene, skin, objects, lights, maps, textures, notes })
    }
}
