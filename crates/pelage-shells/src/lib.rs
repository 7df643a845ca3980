//! Shells and fins: lapped textures, baking, and the rasterised renderer.

pub mod bake;
pub mod dynamics;
pub mod lapped;
pub mod passes;
pub mod render;
pub mod shellfin;
pub mod twin;

pub use render::{render, render_on, render_with};
