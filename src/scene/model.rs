//! The scene file as types. Every field has a default, so that an empty table is a valid one.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A whole scene.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(deny_unknown_fields, default)]
pub struct Scene {
    /// A groom preset (`brown_mink`, ...) that `guard` and `undercoat` start from.
    pub preset: Option<String>,
    /// The skin.
    pub mesh: MeshSpec,
    /// The camera.
    pub camera: Camera,
    /// Directional lights.
    pub lights: Vec<DirectionalLight>,
    /// Image-based light, turned into directional lights.
    pub environment: Option<Environment>,
    /// The bare skin.
    pub base: BaseMaterial,
    /// Guard hairs.
    pub guard: Guard,
    /// Undercoat.
    pub undercoat: Undercoat,
    /// Image size, sampling and output transform.
    pub film: FilmSpec,
    /// What is rendered, how it is blended.
    pub render: RenderSpec,
}

/// A groom parameter: a constant, a vertex colour or an image map read at the root.
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
    /// Which channel is read.
    #[serde(default)]
    pub channel: Channel,
    /// Factor on the texel (1 where not given).
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
    Constant([f32; 3]),
    /// `value * texel` (PNG texels are decoded from sRGB).
    Mapped(ColorMap),
}

/// The source of a mapped colour.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ColorMap {
    /// An image file, or `vertex_color`.
    pub map: String,
    /// Factor on the texel.
    #[serde(default = "white")]
    pub value: [f32; 3],
}

fn one() -> f32 {
    1.0
}
fn white() -> [f32; 3] {
    [1.0; 3]
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
    /// The largest value the parameter can take for texels in 0..=1.
    pub fn max(&self) -> f32 {
        match self {
            Self::Constant(v) => *v,
            Self::Mapped(m) => (m.value + m.offset).max(m.offset),
        }
    }
}

/// Where the skin comes from. Exactly one of `path` and `shape` is given.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(deny_unknown_fields, default)]
pub struct MeshSpec {
    /// An OBJ file.
    pub path: Option<String>,
    /// A procedural shape.
    pub shape: Option<Shape>,
    /// Largest side of the bounding box after scaling, cm. Not given: the file's numbers are cm.
    pub size: Option<f32>,
    /// Further uniform scale.
    pub scale: Option<f32>,
    /// Rotation about x, then y, then z, degrees.
    pub rotate: [f32; 3],
    /// Translation after scale and rotation, cm.
    pub translate: [f32; 3],
    /// Move the centre of the bounding box to the origin first.
    pub center: bool,
    /// Repairs become errors.
    pub strict: bool,
}

/// Shapes that are part of the program. Sizes in cm.
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
    /// Torus, radii 5 and 2 cm.
    Torus,
    /// Pyramid, base 10 cm.
    Pyramid,
    /// Rounded die, edge 8 cm.
    Die,
    /// An animal-like closed body, 20 cm long.
    Critter,
}

/// Pinhole or thin-lens camera.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Camera {
    /// Eye position, cm.
    pub eye: [f32; 3],
    /// The point looked at, cm.
    pub target: [f32; 3],
    /// Up direction.
    pub up: [f32; 3],
    /// Vertical field of view, degrees.
    pub fov: f32,
    /// Distance of the near plane, cm.
    pub near: f32,
    /// Depth of field, if any.
    pub lens: Option<Lens>,
}

/// Depth of field.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Lens {
    /// Aperture diameter, cm.
    pub aperture: f32,
    /// Distance of the plane in focus from the eye along the viewing direction, cm. Not given: the target.
    pub focus: Option<f32>,
    /// How it is made.
    pub method: LensMethod,
}

/// How depth of field is made.
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
    pub irradiance: [f32; 3],
}

/// An equirectangular environment map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Environment {
    /// HDR or EXR file, or empty for a uniform sky of colour `tint`.
    pub map: String,
    /// Number of directional lights made of it: 1..=64.
    pub lights: u32,
    /// Factor on the radiance.
    pub intensity: f32,
    /// Colour factor on the radiance.
    pub tint: [f32; 3],
    /// Rotation about +y, degrees.
    pub rotate: f32,
    /// Light the undercoat too (Andersen et al. 2016 do not).
    pub undercoat: bool,
    /// Show the map behind the fur where the film's background is `environment`.
    pub visible: bool,
}

/// The bare skin: Lambertian.
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
    /// Hairs/cm².
    pub density: Scalar,
    /// Length, cm.
    pub length: Scalar,
    /// Relative spread of the length, 0..1 (uniform, downwards).
    pub length_variation: f32,
    /// Diameter at root, widest place and tip, µm.
    pub diameter: [f32; 3],
    /// Where along the hair it is widest, 0..1.
    pub widest: f32,
    /// Factor on the diameter.
    pub thickness: Scalar,
    /// Segments a strand.
    pub segments: u32,
    /// Bend by gravity (-y), 0 none.
    pub gravity: f32,
    /// Comb direction, world space; projected on the skin. Zero: none.
    pub comb_direction: [f32; 3],
    /// Comb strength: tangent of the lean, 0 upright.
    pub comb: Scalar,
    /// Random lean of each hair, degrees (standard deviation of the cone).
    pub spread: f32,
    /// Pull of the tips towards clump centres, 0..1.
    pub clump: Scalar,
    /// Clump centres/cm².
    pub clump_density: f32,
    /// Curl radius, cm.
    pub curl: Scalar,
    /// Curl turns per cm.
    pub curl_frequency: f32,
    /// Frizz amplitude, cm.
    pub frizz: Scalar,
    /// Frizz bends per cm.
    pub frizz_frequency: f32,
    /// Colour at the root.
    pub color_root: Color,
    /// Colour at the tip.
    pub color_tip: Color,
    /// Where between root and tip the colour changes, 0..1, and over what part of the length.
    pub color_transition: [f32; 2],
    /// Random brightness variation between hairs, 0..1.
    pub color_variation: f32,
    /// Opacity at the root (a0).
    pub opacity: f32,
    /// Exponent of the opacity's fall towards the tip (k_t); 0: opaque to the tip.
    pub tip_fade: f32,
    /// Fibre scattering.
    pub fibre: GuardFibre,
    /// Root darkening of `shading = "paper"`: strength k_s and length l_s as part of the hair length.
    pub root_darkening: [f32; 2],
}

/// Scattering of a guard hair: Sadeghi et al. 2010, single scattering, plus Kajiya-Kay diffuse.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GuardFibre {
    /// Intensity of R, TT, TRT.
    pub intensity: [f32; 3],
    /// Longitudinal shift of R, TT, TRT, degrees.
    pub shift: [f32; 3],
    /// Longitudinal width of R, TT, TRT, degrees.
    pub width: [f32; 3],
    /// Azimuthal width of TT, degrees.
    pub azimuth_tt: f32,
    /// Glints: intensity, azimuthal width (degrees).
    pub glint: [f32; 2],
    /// Weight of the Kajiya-Kay diffuse term.
    pub diffuse: f32,
}

/// Undercoat.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Undercoat {
    /// Hairs/cm².
    pub density: Scalar,
    /// Diameter at root and tip, µm.
    pub diameter: [f32; 2],
    /// Height of the shell, cm.
    pub height: Scalar,
    /// Layers n_l, 1..=256.
    pub layers: u32,
    /// Subdivision level d, 0..=7; not given: chosen per triangle from `cell`.
    pub subdivision: Option<u32>,
    /// Wanted edge of a subelement, cm, where `subdivision` is not given.
    pub cell: f32,
    /// Where the noise lives.
    pub noise_domain: NoiseDomain,
    /// Clump noise: bumps per cm.
    pub noise_frequency: f32,
    /// Clump noise: contrast 0..1.
    pub noise_contrast: f32,
    /// Spread of the hair height, 0..1: how far the shell's top is uneven.
    pub height_variation: f32,
    /// Bumps per cm of the height.
    pub height_frequency: f32,
    /// Displacement of the lookup that grows towards the top, cm.
    pub uv_jitter: f32,
    /// Random turn of the tangents that grows towards the top, 0..1.
    pub tangent_jitter: f32,
    /// Exponent of both growths.
    pub jitter_exponent: f32,
    /// Lean along the guard hairs' comb direction: tangent of the angle.
    pub lean: f32,
    /// Colour at the skin (single-scattering albedo).
    pub color_root: Color,
    /// Colour at the tips.
    pub color_tip: Color,
    /// Weight of the Kajiya-Kay diffuse term.
    pub diffuse: f32,
    /// Weight of the Kajiya-Kay specular term.
    pub specular: f32,
    /// Exponent of the specular term.
    pub specular_exponent: f32,
    /// Part of the scattered light that goes on forward and is not counted as attenuation of a light, 0..1.
    /// 0: single scattering as in Andersen et al. 2016.
    pub forward_scattering: f32,
    /// Stored or evaluated densities.
    pub storage: Storage,
    /// Step of the march in mean free paths of the densest undercoat.
    pub step: f32,
}

/// Where the undercoat's noise lives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum NoiseDomain {
    /// 3D simplex noise on the skin's positions: no seams, no uv needed.
    #[default]
    Object,
    /// 2D simplex noise on uv as in Andersen et al. 2016 (needs uv; frequencies are per uv unit).
    Uv,
}

/// Where the undercoat's densities are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum Storage {
    /// Stored where they fit the memory budget.
    #[default]
    Auto,
    /// Four bytes a subelement.
    Stored,
    /// Evaluated at each step of the march.
    Evaluated,
}

/// Image size, sampling, output.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FilmSpec {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Samples a pixel.
    pub spp: u32,
    /// Reconstruction filter.
    pub filter: Filter,
    /// Filter radius, pixels; not given: the filter's usual one.
    pub filter_radius: Option<f32>,
    /// What is seen behind the fur.
    pub background: Background,
    /// Background colour, linear RGB.
    pub background_color: [f32; 3],
    /// Background plate (PNG, HDR or EXR), scaled to cover the film.
    pub plate: String,
    /// Exposure, stops.
    pub exposure: f32,
    /// Tone mapping of PNG output.
    pub tonemap: Tonemap,
}

/// Reconstruction filters.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum Filter {
    /// Box, radius 0.5.
    Box,
    /// Triangle, radius 1.
    Triangle,
    /// Gaussian, radius 1.5, sigma 0.5.
    #[default]
    Gaussian,
    /// Mitchell-Netravali, radius 2.
    Mitchell,
}

/// What is seen behind the fur.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum Background {
    /// Nothing: alpha stays.
    Transparent,
    /// A colour.
    #[default]
    Color,
    /// The plate.
    Plate,
    /// The environment map.
    Environment,
}

/// Tone mapping of PNG output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum Tonemap {
    /// Exposure and sRGB only.
    None,
    /// Khronos PBR neutral.
    #[default]
    Neutral,
    /// AgX.
    Agx,
    /// ACES (Narkowicz's fit).
    Aces,
}

/// What is rendered and how.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct RenderSpec {
    /// Which layers.
    pub fur: Fur,
    /// How undercoat and guard hairs are blended.
    pub blend: Blend,
    /// Virtual fragments a ray, for `blend = "virtual"`.
    pub virtual_fragments: u32,
    /// Attenuation parameter a of Andersen et al. 2016, eq. (4), 1/cm, for `blend = "simplified"`.
    pub simplified_attenuation: f32,
    /// Light model.
    pub shading: Shading,
    /// Seed of everything random.
    pub seed: u32,
    /// Edge of a tile in samples; not given: chosen from the memory budget.
    pub tile: Option<u32>,
    /// GPU memory budget, bytes.
    pub memory: u64,
}

/// Which layers are rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum Fur {
    /// The skin alone.
    Base,
    /// Skin and guard hairs.
    Explicit,
    /// Skin and undercoat.
    Implicit,
    /// All.
    #[default]
    Hybrid,
}

/// How undercoat and guard hairs are blended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum Blend {
    /// Andersen et al. 2016, eq. (4).
    Simplified,
    /// Virtual fragments.
    Virtual,
    /// Marching between the sorted fragments.
    #[default]
    Exact,
}

/// Light model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum Shading {
    /// Undercoat and guard hairs shadow themselves and each other.
    #[default]
    Physical,
    /// As in the paper: exponential root darkening, no environment light on the undercoat.
    Paper,
}
