//! The built-in shapes as skins.

use pelage_core::scene::{MeshSpec, Shape};
use pelage_core::{Error, Result, Skin, mesh};
use std::path::PathBuf;

/// Every built-in shape.
pub const SHAPES: [Shape; 11] = [
    Shape::CylinderPelt,
    Shape::Hat,
    Shape::Sphere,
    Shape::Plane,
    Shape::Disc,
    Shape::Cube,
    Shape::Cylinder,
    Shape::Torus,
    Shape::Pyramid,
    Shape::Die,
    Shape::Critter,
];

/// Finds no asset.
pub fn no_file(name: &str) -> Result<PathBuf> {
    Err(Error::fault(name, "not found"))
}

/// A shape with the default settings.
pub fn shape(shape: Shape) -> Skin {
    mesh::load(&MeshSpec { shape: Some(shape), ..MeshSpec::default() }, &no_file).expect("shapes load")
}
