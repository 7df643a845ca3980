//! The table `[mesh]`: where the skin comes from, its size and its axes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where the skin comes from: exactly one of `path` and `shape`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(deny_unknown_fields, default)]
pub struct MeshSpec {
    /// A mesh file: OBJ, glTF, GLB, PLY or STL, recognised by its content.
    pub path: Option<String>,
    /// A procedural shape.
    pub shape: Option<Shape>,
    /// Largest side of the bounding box after scaling, cm. Without `size`, `scale` and `units`, a
    /// glTF file's metres are kept if that makes it 2 to 500 cm long; all other files are made
    /// 30 cm long.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub size: Option<f32>,
    /// Unit of the file's numbers; where `scale` alone is given, cm. Shapes are in cm.
    pub units: Option<Units>,
    /// Axis that points upwards in the file, turned to +y. By default +y; in PLY and STL files,
    /// which do not say, +y or +z by how the mesh stands, else +y for PLY and +z for STL. Shapes
    /// have +y.
    pub up: Option<UpAxis>,
    /// How vertex colours are encoded; by default those of PLY files with integers are sRGB, all
    /// others linear.
    pub vertex_colors: Option<ColorSpace>,
    /// Further uniform scale.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub scale: Option<f32>,
    /// Rotation about x, then y, then z, degrees.
    pub rotate: [f32; 3],
    /// Translation after scale and rotation, cm.
    pub translate: [f32; 3],
    /// Move the centre of the bounding box to the origin first.
    pub center: bool,
    /// Where the body faces, in world space. The comb directions of a coat are written for a body
    /// that faces -z, and turn with it; by default they stay as they are.
    pub front: Option<Front>,
    /// Report faults of the mesh as errors instead of repairing them.
    pub strict: bool,
    /// How often each triangle is divided into four at the middles of its edges; the surface stays
    /// the same. Heights and colours of the undercoat are read at points of the mesh, so maps with
    /// more detail than it has triangles need this.
    #[schemars(range(min = 0, max = 6))]
    pub subdivide: u32,
    /// Flat shading, to inspect the mesh: triangles share no vertices and have their own normals.
    /// Fur would part along every edge.
    pub faceted: bool,
}

/// Unit of a mesh file's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Units {
    /// Millimetres.
    Mm,
    /// Centimetres.
    Cm,
    /// Metres.
    M,
    /// Inches.
    In,
}

impl Units {
    /// Length of the unit, cm.
    pub fn cm(self) -> f64 {
        match self {
            Self::Mm => 0.1,
            Self::Cm => 1.0,
            Self::M => 100.0,
            Self::In => 2.54,
        }
    }
}

/// Axis that points upwards in a mesh file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum UpAxis {
    /// +x.
    #[serde(rename = "x")]
    X,
    /// +y.
    #[serde(rename = "y")]
    Y,
    /// +z.
    #[serde(rename = "z")]
    Z,
    /// Against x.
    #[serde(rename = "-x")]
    NegativeX,
    /// Against y.
    #[serde(rename = "-y")]
    NegativeY,
    /// Against z.
    #[serde(rename = "-z")]
    NegativeZ,
}

/// How colours are encoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ColorSpace {
    /// Proportional to light.
    Linear,
    /// sRGB.
    Srgb,
}

/// The direction in which a body faces, in world space.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Front {
    /// Guessed: along its longer horizontal side, towards the higher end.
    #[serde(rename = "auto")]
    Auto,
    /// +x.
    #[serde(rename = "x")]
    X,
    /// -x.
    #[serde(rename = "-x")]
    NegativeX,
    /// +z.
    #[serde(rename = "z")]
    Z,
    /// -z.
    #[serde(rename = "-z")]
    NegativeZ,
}

impl MeshSpec {
    /// Name of the object: the file without folder and extension, or the shape.
    pub fn name(&self) -> String {
        let stem = self.path.as_deref().and_then(|path| std::path::Path::new(path).file_stem());
        let shape = || toml::Value::try_from(self.shape?).ok()?.as_str().map(str::to_owned);
        stem.map(|stem| stem.to_string_lossy().into_owned()).or_else(shape).unwrap_or_else(|| "fur".into())
    }
}

/// Built-in shapes. Sizes in cm.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// Open pelt bent over a cylinder: 3,584 triangles, 190 cm².
    CylinderPelt,
    /// Brimmed fur hat: 5,632 triangles.
    Hat,
    /// Sphere, radius 5 cm.
    Sphere,
    /// Flat square, 10 x 10 cm, facing +y.
    Plane,
    /// Flat disc, radius 5 cm, facing +y.
    Disc,
    /// Cube, edge 10 cm; for an object, whose edges stay sharp.
    Cube,
    /// Closed cylinder, radius 1 cm, 10 cm long, its axis along y; for an object.
    Cylinder,
    /// Torus, radii 5 and 2 cm.
    Torus,
    /// Pyramid, base 10 cm.
    Pyramid,
    /// Rounded die, edge 8 cm.
    Die,
    /// An animal-like closed body, 20 cm long.
    Critter,
}
