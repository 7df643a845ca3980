//! Parts: regions of the skin with a coat of their own, or bare.

use super::model::{BaseMaterial, Guard, Scalar, ScalarMap, Scene, Undercoat};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Largest number of parts.
pub const MAX_PARTS: usize = 15;

/// A region of the skin with a coat of its own, or none. It is the intersection of what `group`,
/// `material`, `balls` and `mask` choose, of which at least one must be given. Later parts lie over
/// earlier ones.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Part {
    /// Name, for messages.
    pub name: String,
    /// Triangles of these groups of the mesh.
    #[serde(skip_serializing_if = "Names::is_empty")]
    pub group: Names,
    /// Triangles of these materials of the mesh.
    #[serde(skip_serializing_if = "Names::is_empty")]
    pub material: Names,
    /// The skin inside of any of these balls: for a mesh without groups.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub balls: Vec<Ball>,
    /// Share of the part at each point, cut to 0..1: an image or the vertex colours.
    pub mask: Option<ScalarMap>,
    /// Width of the transition around what groups, materials and balls choose, cm, by default 1; 0:
    /// a hard border along the edges of triangles. It is measured along the skin from groups and
    /// materials, straight from balls. A mask has its own transition.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub edge: Option<f32>,
    /// `false`: bare skin without hairs.
    pub fur: bool,
    /// A groom preset that lies over the scene's own coat, and under the keys given here.
    pub preset: Option<String>,
    /// Guard hairs; keys that are not given are the preset's or those of the scene's own coat.
    pub guard: Option<Guard>,
    /// Undercoat; as `guard`.
    pub undercoat: Option<Undercoat>,
    /// Material of the skin; as `guard`. Where it is not given for bare skin, it is that of what
    /// lies below.
    pub base: Option<BaseMaterial>,
    /// Where `group`, `material` and `balls` are given.
    #[serde(skip)]
    pub places: [Place; 3],
}

/// A ball in the scene's coordinates, those of the camera.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Ball {
    /// Centre, cm.
    pub center: [f32; 3],
    /// Radius, cm.
    #[schemars(range(min = 0.0, max = 1e6))]
    pub radius: f32,
}

/// One name or several.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Names {
    /// One.
    One(String),
    /// Several.
    Several(Vec<String>),
}

/// A place in a scene file. All places are equal: where a value is written is not part of it.
#[derive(Debug, Clone, Default)]
pub struct Place {
    /// The file.
    pub file: PathBuf,
    /// Line from 1; 0 where there is none.
    pub line: usize,
    /// Column from 1; 0 where there is none.
    pub column: usize,
}

impl PartialEq for Place {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Default for Names {
    fn default() -> Self {
        Self::Several(Vec::new())
    }
}

impl Names {
    /// The names.
    pub fn list(&self) -> &[String] {
        match self {
            Self::One(name) => std::slice::from_ref(name),
            Self::Several(names) => names,
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.list().is_empty()
    }
}

impl Default for Part {
    fn default() -> Self {
        Self {
            name: String::new(),
            group: Names::default(),
            material: Names::default(),
            balls: Vec::new(),
            mask: None,
            edge: None,
            fur: true,
            preset: None,
            guard: None,
            undercoat: None,
            base: None,
            places: Default::default(),
        }
    }
}

impl Part {
    /// Width of the transition around the chosen groups, materials and balls, cm.
    pub fn edge_cm(&self) -> f32 {
        self.edge.unwrap_or(1.0)
    }

    /// Whether groups or materials of the mesh are chosen.
    pub fn has_sections(&self) -> bool {
        !(self.group.is_empty() && self.material.is_empty())
    }

    /// Whether a region of the mesh is chosen, by groups, materials or balls.
    pub fn has_region(&self) -> bool {
        self.has_sections() || !self.balls.is_empty()
    }
}

/// The hairs of a place and the skin under them.
#[derive(Debug, Clone, Copy)]
pub struct Coat<'a> {
    /// Guard hairs.
    pub guard: &'a Guard,
    /// Undercoat.
    pub undercoat: &'a Undercoat,
    /// Material of the skin.
    pub base: &'a BaseMaterial,
}

impl Scene {
    /// The scene's own coat.
    pub fn own_coat(&self) -> Coat<'_> {
        Coat { guard: &self.guard, undercoat: &self.undercoat, base: &self.base }
    }

    /// The coat of a part; `None` if it is bare.
    pub fn coat_of<'a>(&'a self, part: &'a Part) -> Option<Coat<'a>> {
        part.fur.then(|| Coat {
            guard: part.guard.as_ref().unwrap_or(&self.guard),
            undercoat: part.undercoat.as_ref().unwrap_or(&self.undercoat),
            base: part.base.as_ref().unwrap_or(&self.base),
        })
    }

    /// All coats: the scene's own, then those of the parts that are not bare.
    pub fn coats(&self) -> impl Iterator<Item = Coat<'_>> {
        std::iter::once(self.own_coat()).chain(self.parts.iter().filter_map(|part| self.coat_of(part)))
    }

    /// The largest value of a function of a coat.
    pub fn largest(&self, of: impl Fn(&Coat<'_>) -> f32) -> f32 {
        self.coats().map(|coat| of(&coat)).fold(f32::NEG_INFINITY, f32::max)
    }
}

impl<'a> Coat<'a> {
    /// Scalar parameters, which must not be negative, with their keys.
    pub(crate) fn scalars(&self) -> [(&'static str, &'a Scalar); 9] {
        let (guard, undercoat) = (self.guard, self.undercoat);
        [
            ("guard.density", &guard.density),
            ("guard.length", &guard.length),
            ("guard.thickness", &guard.thickness),
            ("guard.comb", &guard.comb),
            ("guard.clump", &guard.clump),
            ("guard.curl", &guard.curl),
            ("guard.frizz", &guard.frizz),
            ("undercoat.density", &undercoat.density),
            ("undercoat.height", &undercoat.height),
        ]
    }
}
