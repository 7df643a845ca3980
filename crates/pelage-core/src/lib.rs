//! What every part of pelage reads: scene files, meshes, maps, lights, cameras and films, with
//! errors and atomic output.

pub mod animation;
pub mod assets;
pub mod error;
pub mod files;
pub mod film;
pub mod hair;
pub mod light;
mod map_detail;
pub mod maps;
pub mod mesh;
pub mod objects;
pub mod parts;
pub mod scene;
pub mod skin;
pub mod stage;
pub mod stats;
pub mod world;

pub use error::{Error, Result, SceneFault};
pub use scene::Scene;
pub use skin::Skin;
pub use world::World;
