//! pelage: a hybrid fur renderer.

pub mod assets;
pub mod bench;
pub mod camera;
pub mod cli;
pub mod compare;
pub mod error;
pub mod figure;
pub mod files;
pub mod film;
pub mod gpu;
pub mod groom;
pub mod hair;
pub mod layout;
pub mod light;
pub mod maps;
pub mod mesh;
pub mod passes;
pub mod prepare;
pub mod provenance;
pub mod render;
pub mod scene;
pub mod skin;
pub mod stats;
pub mod world;

pub use error::{Error, Result, SceneFault};
pub use scene::Scene;
pub use skin::Skin;
pub use world::World;
