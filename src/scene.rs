//! The scene: what a scene file says, resolved. Lengths are cm, densities hairs/cm², diameters µm, colours
//! linear RGB, angles degrees.

mod defaults;
pub mod model;
pub use model::*;
