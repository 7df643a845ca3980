//! The scene file. Lengths are cm, densities hairs/cm², diameters µm, colours linear RGB, angles
//! degrees.
//!
//! A scene file goes through these steps, each in a module of its own: `tree` parses the text to a
//! tree that knows the position of every value, `load` merges includes and the preset under it,
//! `overrides` sets values from the command line, `check` checks the tree against the JSON schema,
//! and `rules` checks what the schema cannot express. All faults are reported together.

mod animation;
mod check;
mod defaults;
mod fibre;
mod groom;
mod load;
mod markdown;
mod mesh;
pub mod model;
mod objects;
mod output;
mod overrides;
mod part;
mod parts;
pub mod preset;
mod rules;
mod schema;
mod shellfin;
mod template;
mod tree;

pub use load::{DEFAULT_PRESET, Override};
pub use markdown::markdown;
pub use model::*;
pub use schema::json_schema;
pub use template::template;
