//! The types of a scene file. Every field has a default, so that an empty table is valid.
//!
//! Ranges are given here as schemars attributes and nowhere else: the JSON schema that
//! `pelage schema` prints is also what the loader checks files against.

pub use super::animation::*;
pub use super::fibre::*;
pub use super::groom::*;
pub use super::mesh::*;
pub use super::objects::*;
pub use super::output::*;
pub use super::part::*;
pub use super::shellfin::*;
use crate::light::probe::Probe;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A whole scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(deny_unknown_fields, default)]
pub struct Scene {
    /// The JSON schema that an editor checks this file against; not read. `None` once a scene is
    /// loaded.
    #[serde(rename = "$schema", skip_serializing)]
    pub schema: Option<String>,
    /// Scene files, relative to this one, whose values this file overrides; a later one overrides
    /// an earlier one. Empty once a scene is loaded.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub include: Vec<String>,
    /// A groom preset (`brown_mink`, ...) that `guard`, `undercoat` and `base` start from.
    pub preset: Option<String>,
    /// The skin.
    pub mesh: MeshSpec,
    /// Meshes without fur. They cover fur and skin, cast shadows on them, and receive theirs.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[schemars(length(max = 256))]
    pub objects: Vec<ObjectSpec>,
    /// The camera.
    pub camera: Camera,
    /// Directional lights; with those of the environment at most 64.
    #[schemars(length(max = 64))]
    pub lights: Vec<DirectionalLight>,
    /// Image-based light, converted to directional lights.
    pub environment: Option<Environment>,
    /// Material of the skin.
    pub base: BaseMaterial,
    /// The coat as a whole.
    #[serde(skip_serializing_if = "GroomSpec::is_one")]
    pub groom: GroomSpec,
    /// Guard hairs.
    pub guard: Guard,
    /// Undercoat.
    pub undercoat: Undercoat,
    /// Regions of the skin with a coat of their own, or bare; at most 15.
    #[schemars(length(max = 15))]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<Part>,
    /// Image size, sampling and output transform.
    pub film: FilmSpec,
    /// What is rendered, and how.
    pub render: RenderSpec,
    /// Patches that cover the skin with one small texture.
    pub lapped: LappedSpec,
    /// Textures for shells and fins.
    pub bake: BakeSpec,
    /// How shells and fins are drawn.
    pub shells: Shells,
    /// What changes from frame to frame.
    pub animation: Animation,
}

/// A groom parameter: a constant, or a vertex colour or image map read at the hair's root.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Scalar {
    /// The same everywhere.
    Constant(f32),
    /// `value * texel + offset`, the texel from an image or from the vertex colours.
    Mapped(ScalarMap),
}

/// The source of a mapped scalar.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScalarMap {
    /// An image file, or `vertex_color`.
    pub map: String,
    /// Layer of an EXR image (its name without `.R`); by default the channels without a layer, else
    /// the first layer.
    #[serde(default)]
    pub layer: String,
    /// Which channel is read.
    #[serde(default)]
    pub channel: Channel,
    /// Factor on the texel, by default 1.
    #[serde(default = "one")]
    pub value: f32,
    /// Added after the factor.
    #[serde(default)]
    pub offset: f32,
}

/// A channel of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// Red.
    #[default]
    R,
    /// Green.
    G,
    /// Blue.
    B,
    /// Alpha.
    A,
}

/// A colour parameter, linear RGB.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum Color {
    /// The same everywhere.
    Constant(#[schemars(inner(range(min = 0.0, max = 1.0)))] [f32; 3]),
    /// `value * texel` (PNG texels are decoded from sRGB).
    Mapped(ColorMap),
}

/// The source of a mapped colour.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ColorMap {
    /// An image file, or `vertex_color`.
    pub map: String,
    /// Layer of an EXR image (its name without `.R`); by default the channels without a layer, else
    /// the first layer.
    #[serde(default)]
    pub layer: String,
    /// Factor on the texel.
    #[serde(default = "white")]
    #[schemars(inner(range(min = 0.0)))]
    pub value: [f32; 3],
}

fn one() -> f32 {
    1.0
}
fn white() -> [f32; 3] {
    [1.0; 3]
}

impl Channel {
    /// Index of the channel in a texel.
    pub fn index(self) -> usize {
        match self {
            Self::R => 0,
            Self::G => 1,
            Self::B => 2,
            Self::A => 3,
        }
    }
}

impl From<f32> for Scalar {
    fn from(v: f32) -> Self {
        Self::Constant(v)
    }
}
impl From<[f32; 3]> for Color {
    fn from(v: [f32; 3]) -> Self {
        Self::Constant(v)
    }
}
impl Scalar {
    /// The largest value that the parameter can take for texels in 0..=1.
    pub fn max(&self) -> f32 {
        match self {
            Self::Constant(v) => *v,
            Self::Mapped(m) => (m.value + m.offset).max(m.offset),
        }
    }
}

/// Pinhole or thin-lens camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Camera {
    /// Whether position and target are given or chosen from the skin; by default chosen if neither
    /// `eye` nor `target` is given.
    pub frame: Framing,
    /// Where the camera stands if `frame = "auto"`: azimuth about +y, from +z towards +x, and
    /// elevation, degrees; by default three-quarters from the front, a little from above.
    #[schemars(inner(range(min = -360.0, max = 360.0)))]
    pub view: Option<[f32; 2]>,
    /// Position of the camera, cm.
    pub eye: [f32; 3],
    /// The point that the camera looks at, cm.
    pub target: [f32; 3],
    /// Up direction.
    pub up: [f32; 3],
    /// Vertical field of view, degrees; 20, that of a portrait lens, if `frame = "auto"`.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 180))]
    pub fov: f32,
    /// Distance of the near plane, cm.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub near: f32,
    /// Depth of field, if any.
    pub lens: Option<Lens>,
}

/// How the camera's position and target are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum Framing {
    /// By `eye` and `target`.
    #[default]
    Given,
    /// So that the whole fur is in the picture, seen from the direction `view`.
    Auto,
}

/// Depth of field.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Lens {
    /// Aperture diameter, cm.
    #[schemars(range(min = 0.0))]
    pub aperture: f32,
    /// Distance of the plane in focus from the camera along the viewing direction, cm; by default
    /// that of the target.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub focus: Option<f32>,
    /// How it is computed.
    pub method: LensMethod,
}

/// How depth of field is computed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum LensMethod {
    /// Each sample of a pixel has its own point on the lens.
    #[default]
    Samples,
    /// Post-process, as in Andersen et al. 2016.
    Post,
}

/// A directional light.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct DirectionalLight {
    /// Direction from the scene towards the light.
    pub direction: [f32; 3],
    /// Irradiance on a surface that faces the light, linear RGB.
    #[schemars(inner(range(min = 0.0)))]
    pub irradiance: [f32; 3],
}

/// Light from all around, by an environment map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Environment {
    /// Image file (HDR or EXR for more than 0..1); empty for a uniform sky of colour `tint`.
    pub map: String,
    /// Layer of an EXR image (its name without `.R`); by default the channels without a layer, else
    /// the first layer.
    pub layer: String,
    /// How the map shows the directions; by default as `equirectangular`, except that a square
    /// image that is black outside a circle must say what it is.
    pub projection: Option<Projection>,
    /// Number of directional lights that it is converted to, 1..=64.
    #[schemars(range(min = 1, max = 64))]
    pub lights: u32,
    /// Factor on the radiance.
    #[schemars(range(min = 0.0))]
    pub intensity: f32,
    /// Colour factor on the radiance, linear RGB.
    #[schemars(inner(range(min = 0.0)))]
    pub tint: [f32; 3],
    /// Rotation about +y, degrees.
    pub rotate: f32,
    /// Light the undercoat too (Andersen et al. 2016 do not).
    pub undercoat: bool,
    /// Show the map behind the fur where the film's background is `environment`.
    pub visible: bool,
}

/// How an environment map shows the directions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Projection {
    /// Longitude and latitude: the centre shows -z, the right side +x, the top row +y.
    Equirectangular,
    /// A light probe, square: the centre shows +z, the right +x, the top +y, as in a mirror ball;
    /// the distance from the centre is the angle, up to -z at the circle.
    Angular,
    /// A photograph, cropped to a square, of a mirror ball by a distant camera that looks to -z:
    /// the centre shows +z, the right +x, the top +y, the circle -z.
    MirrorBall,
}

impl Projection {
    /// The kind of light probe; `None` for a map that is none.
    pub fn probe(self) -> Option<Probe> {
        match self {
            Self::Equirectangular => None,
            Self::Angular => Some(Probe::Angular),
            Self::MirrorBall => Some(Probe::MirrorBall),
        }
    }
}

/// Material of the skin: Lambertian.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BaseMaterial {
    /// Reflectance.
    pub color: Color,
}

/// Guard hairs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Guard {
    /// Density, hairs/cm².
    #[schemars(extend("minimum" = 0))]
    pub density: Scalar,
    /// Length, cm.
    #[schemars(extend("minimum" = 0))]
    pub length: Scalar,
    /// Relative spread of the length, 0..1 (uniform, downwards).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub length_variation: f32,
    /// Diameter at the root, at the widest point and at the tip, µm.
    #[schemars(inner(range(min = 0.001, max = 10000.0)))]
    pub diameter: [f32; 3],
    /// Position of the widest point along the hair, 0..1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub widest: f32,
    /// Factor on the diameter.
    #[schemars(extend("minimum" = 0))]
    pub thickness: Scalar,
    /// Segments per strand.
    #[schemars(range(min = 1, max = 64))]
    pub segments: u32,
    /// Bend by gravity (-y); 0: none.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub gravity: f32,
    /// Comb direction, world space, projected on the skin; zero: none.
    pub comb_direction: [f32; 3],
    /// Comb strength: tangent of the lean; 0: upright.
    #[schemars(extend("minimum" = 0))]
    pub comb: Scalar,
    /// Random lean of each hair (standard deviation of the cone), degrees.
    #[schemars(range(min = 0.0, max = 90.0))]
    pub spread: f32,
    /// Pull of the tips towards clump centres, 0..1.
    #[schemars(extend("minimum" = 0, "maximum" = 1))]
    pub clump: Scalar,
    /// Density of clump centres, 1/cm².
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub clump_density: f32,
    /// Curl radius, cm.
    #[schemars(extend("minimum" = 0))]
    pub curl: Scalar,
    /// Turns of the curl, 1/cm.
    #[schemars(range(min = 0.0))]
    pub curl_frequency: f32,
    /// Frizz amplitude, cm.
    #[schemars(extend("minimum" = 0))]
    pub frizz: Scalar,
    /// Bends of the frizz, 1/cm.
    #[schemars(range(min = 0.0))]
    pub frizz_frequency: f32,
    /// Colour at the root.
    pub color_root: Color,
    /// Colour at the tip.
    pub color_tip: Color,
    /// Colour transition between root and tip: position of its middle along the hair, 0..1, and its
    /// extent as a fraction of the length.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub color_transition: [f32; 2],
    /// Random brightness variation between hairs, 0..1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub color_variation: f32,
    /// Opacity at the root (a0).
    #[schemars(range(min = 0.0, max = 1.0))]
    pub opacity: f32,
    /// Exponential decay of the opacity towards the tip (k_t); 0: constant.
    #[schemars(range(min = 0.0))]
    pub tip_fade: f32,
    /// Scattering.
    pub fibre: FibreSpec,
    /// Root darkening of `shading = "paper"`: strength k_s and length l_s as a fraction of the
    /// hair's length.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub root_darkening: [f32; 2],
}

/// Undercoat.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Undercoat {
    /// Density, hairs/cm².
    #[schemars(extend("minimum" = 0))]
    pub density: Scalar,
    /// Diameter at root and tip, µm.
    #[schemars(inner(range(min = 0.001, max = 10000.0)))]
    pub diameter: [f32; 2],
    /// Height of the undercoat, cm.
    #[schemars(extend("minimum" = 0))]
    pub height: Scalar,
    /// Layers n_l, 1..=256.
    #[schemars(range(min = 1, max = 256))]
    pub layers: u32,
    /// Subdivision level d, 0..=7; by default chosen for each triangle from `cell`.
    #[schemars(range(min = 0, max = 7))]
    pub subdivision: Option<u32>,
    /// Desired edge of a subelement, cm, where `subdivision` is not given.
    #[schemars(range(min = 0.0001))]
    pub cell: f32,
    /// Domain of the noise.
    pub noise_domain: NoiseDomain,
    /// Bumps of the clump noise, 1/cm.
    #[schemars(range(min = 0.0))]
    pub noise_frequency: f32,
    /// Contrast of the clump noise, 0..1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub noise_contrast: f32,
    /// Spread of the hairs' height, 0..1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub height_variation: f32,
    /// Bumps of the height noise, 1/cm.
    #[schemars(range(min = 0.0))]
    pub height_frequency: f32,
    /// Jitter of the noise lookup, growing towards the tips, cm.
    #[schemars(range(min = 0.0))]
    pub uv_jitter: f32,
    /// Random jitter of the tangents, growing towards the tips, 0..1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub tangent_jitter: f32,
    /// Exponent of the growth of both jitters with height.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub jitter_exponent: f32,
    /// Lean along the guard hairs' comb direction: tangent of the angle.
    #[schemars(range(min = 0.0))]
    pub lean: f32,
    /// Colour at the skin (single-scattering albedo).
    pub color_root: Color,
    /// Colour at the tips.
    pub color_tip: Color,
    /// Scattering.
    pub fibre: FibreSpec,
    /// Share of the scattered light that goes on forward and does not count as attenuation of a
    /// light, 0..1. 0: single scattering as in Andersen et al. 2016.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub forward_scattering: f32,
    /// Whether densities are stored or evaluated.
    pub storage: Storage,
    /// Step of the march, mean free paths (of the densest undercoat).
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 10))]
    pub step: f32,
}

/// Domain of the undercoat's noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum NoiseDomain {
    /// 3D simplex noise on the skin's positions, relative to `mesh.translate`: no seams, no uv
    /// needed.
    #[default]
    Object,
    /// 2D simplex noise on uv as in Andersen et al. 2016 (needs uv; frequencies are per uv unit).
    Uv,
}

/// Whether the undercoat's densities are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum Storage {
    /// Stored if they fit into the memory budget, otherwise evaluated.
    #[default]
    Auto,
    /// Stored, in four bytes per subelement.
    Stored,
    /// Evaluated at each step of the march.
    Evaluated,
}
