//! The scene: what a scene file says, resolved. Lengths are cm, densities hairs/cm², diameters µm, colours
//! linear RGB, angles degrees.
//!
//! A scene file goes through these steps, each in a module of its own: `tree` parses text to a tree that knows where
//! every value stands, `load` merges includes and the preset under it, `overrides` sets what the command line gives,
//! `check` holds the tree against the JSON schema, `rules` looks at what the schema cannot say. All faults come out
//! together.

mod animation;
mod check;
mod defaults;
mod fibre;
mod load;
pub mod model;
mod output;
mod overrides;
pub mod preset;
mod rules;
mod schema;
mod shellfin;
mod tree;

pub use load::Override;
pub use model::*;
pub use schema::json_schema;
