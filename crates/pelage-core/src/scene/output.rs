//! The tables `[film]` and `[render]`: image, sampling, layers, blending, light, memory budget.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Image size, sampling, output.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FilmSpec {
    /// Width, pixels.
    #[schemars(range(min = 1, max = 32768))]
    pub width: u32,
    /// Height, pixels.
    #[schemars(range(min = 1, max = 32768))]
    pub height: u32,
    /// Samples per pixel.
    #[schemars(range(min = 1, max = 65536))]
    pub spp: u32,
    /// Reconstruction filter.
    pub filter: Filter,
    /// Filter radius, pixels; by default the filter's usual one.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 16))]
    pub filter_radius: Option<f32>,
    /// What is seen behind the fur.
    pub background: Background,
    /// Background colour, linear RGB.
    #[schemars(inner(range(min = 0.0)))]
    pub background_color: [f32; 3],
    /// Background plate (any image file that is read as a map), scaled to cover the film.
    pub plate: String,
    /// Exposure, stops.
    #[schemars(range(min = -32.0, max = 32.0))]
    pub exposure: f32,
    /// Tone mapping of PNG output.
    pub tonemap: Tonemap,
    /// Colour space of EXR output, linear; PNG is always sRGB.
    pub color_space: OutputSpace,
}

/// Colour spaces of EXR output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum OutputSpace {
    /// Primaries of ITU-R BT.709 and sRGB, white D65.
    #[default]
    Rec709,
    /// ACEScg: primaries AP1, white of ACES (about D60).
    Acescg,
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
    /// Nothing; alpha is kept.
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
    /// Which layers are rendered.
    pub fur: FurLayers,
    /// How undercoat and guard hairs are blended.
    pub blend: Blend,
    /// Virtual fragments per ray, for `blend = "virtual"`.
    #[schemars(range(min = 1, max = 4096))]
    pub virtual_fragments: u32,
    /// Attenuation parameter a of Andersen et al. 2016, eq. (4), 1/cm, for `blend = "simplified"`.
    #[schemars(range(min = 0.0))]
    pub simplified_attenuation: f32,
    /// Light model.
    pub shading: Shading,
    /// Light scattered by more than one hair.
    pub multiple: MultipleScattering,
    /// How the march finds the optical depth towards a light.
    pub light: LightLookup,
    /// Seed of all random numbers.
    pub seed: u32,
    /// Edge of a tile, samples; by default chosen from the memory budget.
    #[schemars(range(min = 8, max = 32768))]
    pub tile: Option<u32>,
    /// GPU memory budget, bytes.
    #[schemars(range(min = 16_777_216))]
    pub memory: u64,
}

/// Which layers are rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum FurLayers {
    /// The skin alone.
    Base,
    /// Skin and guard hairs.
    Explicit,
    /// Skin and undercoat.
    Implicit,
    /// Skin, undercoat and guard hairs.
    #[default]
    Hybrid,
    /// Shells and fins with baked textures: the real-time image of the same fur.
    Shells,
}

/// How undercoat and guard hairs are blended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum Blend {
    /// One fragment of undercoat on a ray, weaker for the hairs behind it: Andersen et al. 2016,
    /// eq. (4).
    Simplified,
    /// The undercoat on a ray is cut into virtual fragments, which are sorted with the hairs.
    Virtual,
    /// The undercoat is marched between the sorted hairs: the limit of `virtual`.
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
    /// As in Andersen et al. 2016: exponential root darkening, no environment light on the
    /// undercoat, no forward scattering, isotropic extinction.
    Paper,
}

/// Light scattered by more than one hair. With `shading = "paper"` there is none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MultipleScattering {
    /// How it is found.
    pub model: MultipleModel,
    /// Include light that hairs on the light's side scatter forward to a hair.
    pub forward: bool,
    /// Include light that the hairs behind a hair scatter back to it.
    pub backward: bool,
    /// Density factors d_f and d_b of `model = "dual"` (Zinke et al. 2008 use 0.7).
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub density: [f32; 2],
}

/// How light scattered by more than one hair is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum MultipleModel {
    /// `transport` where the coat's fibres are `chiang` or `medulla`, whose light is mostly
    /// scattered more than once; otherwise `similarity`.
    #[default]
    Auto,
    /// Single scattering only.
    None,
    /// Hairs attenuate a light less: the share `undercoat.forward_scattering` of the scattered
    /// light counts as going on.
    Similarity,
    /// Dual scattering, Zinke et al. 2008.
    Dual,
    /// Radiative transfer in a flat coat of the same fibres, looked up by the optical depth towards
    /// each light.
    Transport,
}

/// How the march finds the optical depth towards a light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum LightLookup {
    /// From the optical-depth lattice, filled once.
    #[default]
    Lattice,
    /// By a march towards each of the two brightest lights at every step: slow, to compare with.
    /// Guard hairs cast no shadow then.
    Nested,
}
