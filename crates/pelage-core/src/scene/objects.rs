//! Meshes without fur.

use super::tree::{Node, Sources};
use super::{Color, MeshSpec, Scene};
use crate::SceneFault;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Largest number of objects.
pub const MAX_OBJECTS: usize = 256;

/// A mesh without fur that stands in the scene: an eye, a collar, the ground.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ObjectSpec {
    /// Name in messages and of the object's matte; each object has its own.
    pub name: String,
    /// Its mesh, in the same world as the skin, with the keys of `[mesh]` except `front`.
    pub mesh: MeshSpec,
    /// Edges at which two triangles meet at a larger angle are sharp, degrees; smaller ones are
    /// shaded as round. Default 40.
    #[schemars(range(min = 0.0, max = 180.0))]
    pub crease: f32,
    /// Its material.
    pub material: ObjectMaterial,
    /// Show only the shadow that falls on it, to composite it over a photograph: a black surface
    /// whose alpha is the share of the light that is missing, 1 - visible / unshadowed irradiance
    /// (luminances). It blocks no light, and hides what is behind it.
    pub shadow_catcher: bool,
}

/// An opaque material: the metallic-roughness model of glTF 2.0 with the clear coat of
/// KHR_materials_clearcoat; index of refraction 1.5.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ObjectMaterial {
    /// Base colour: reflectance of a dielectric's inside, or a metal's colour at normal incidence.
    pub color: Color,
    /// Roughness; its square is the width of the GGX distribution. Default 0.5.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub roughness: f32,
    /// 0: dielectric (default), 1: metal.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub metallic: f32,
    /// Strength of the clear coat. Default 0.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub clearcoat: f32,
    /// Roughness of the clear coat. Default 0.03.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub clearcoat_roughness: f32,
}

impl Default for ObjectSpec {
    fn default() -> Self {
        Self {
            name: String::new(),
            mesh: MeshSpec::default(),
            crease: 40.0,
            material: ObjectMaterial::default(),
            shadow_catcher: false,
        }
    }
}

impl Default for ObjectMaterial {
    fn default() -> Self {
        Self {
            color: Color::Constant([0.5; 3]),
            roughness: 0.5,
            metallic: 0.0,
            clearcoat: 0.0,
            clearcoat_roughness: 0.03,
        }
    }
}

/// Faults of objects: each has a name of its own and exactly one mesh.
pub(super) fn broken(scene: &Scene, tree: &Node, sources: &Sources) -> Vec<SceneFault> {
    let mut faults = Vec::new();
    for (i, object) in scene.objects.iter().enumerate() {
        let mut fault = |key: &str, message: &str, help: &str| {
            let path = format!("objects.{i}{key}");
            let message = format!("{path}: {message}");
            faults.push(sources.fault(tree.origin_of(&path), message, Some(help.to_owned())));
        };
        if object.name.is_empty() {
            fault("", "the key \"name\" is missing or empty", "give each object a name: name = \"left eye\"");
        } else if scene.objects[..i].iter().any(|other| other.name == object.name) {
            let message = format!("an earlier object is called \"{}\" too", object.name);
            fault(".name", &message, "give each object a name of its own");
        } else if object.name == scene.mesh.name() {
            let message = format!("the matte of the body is called \"{}\" too, after its mesh", object.name);
            fault(".name", &message, "give the object another name");
        }
        if object.mesh.front.is_some() {
            let help = "take it away; mesh.rotate turns an object";
            fault(".mesh.front", "an object has no coat that turns with its front", help);
        }
        match (object.mesh.path.as_deref(), object.mesh.shape) {
            (None, None) => fault(
                "",
                "the object has no mesh: neither mesh.path nor mesh.shape is given",
                "name a file (mesh = { path = \"...\" }) or a built-in shape (mesh = { shape = \"sphere\", size = 1 })",
            ),
            (Some(_), Some(_)) => {
                fault(".mesh", "both mesh.path and mesh.shape are given", "keep one of them");
            }
            (Some(""), None) => fault(".mesh.path", "found an empty name", "name a mesh file"),
            _ => {}
        }
    }
    faults
}
