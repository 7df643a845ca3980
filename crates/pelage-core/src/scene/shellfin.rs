//! The tables `[lapped]`, `[bake]` and `[shells]`: patches, textures of hair, and how shells and
//! fins are drawn.

use super::{Color, Scalar};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Lapped patches: how a skin without useful uv is covered by one small toroidal texture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LappedSpec {
    /// Radius of a patch's outline, cm; by default 0.0465 times the square root of the skin's area.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: Option<f32>,
    /// Irregularity of the outline: spread of its radius, 0..0.9.
    #[schemars(range(min = 0.0, max = 0.9))]
    pub irregularity: f32,
    /// Source of the direction field.
    pub field: FieldSource,
    /// Directions at points of the skin, for `field = "vectors"`; they are interpolated everywhere
    /// else.
    pub vectors: Vec<FieldVector>,
    /// Textures follow the field; false: each patch has a random orientation, which suits upright
    /// hair.
    pub aligned: bool,
    /// Patches overlap within their outlines and shells show all of them, as in Praun et al. 2000;
    /// false: patches are extended to whole faces and each face shows only its topmost patch, as in
    /// Lengyel et al. 2001.
    pub overlapping: bool,
}

impl LappedSpec {
    /// The default radius, relative to the square root of the skin's area.
    pub const RADIUS: f64 = 0.0465;
}

impl Default for LappedSpec {
    fn default() -> Self {
        Self {
            radius: None,
            irregularity: 0.35,
            field: FieldSource::Auto,
            vectors: Vec::new(),
            aligned: true,
            overlapping: false,
        }
    }
}

/// Source of the direction field on the skin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum FieldSource {
    /// The smoothest field that the skin allows.
    #[default]
    Auto,
    /// Downwards (-y), smoothed over half a patch's radius.
    Gravity,
    /// Along `guard.comb_direction`, smoothed in the same way.
    Groom,
    /// Interpolated from `vectors`.
    Vectors,
}

/// A direction at a point of the skin.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FieldVector {
    /// Point, cm, world space; the nearest face is used.
    pub at: [f32; 3],
    /// Direction, world space, projected on the skin; must not be zero.
    pub direction: [f32; 3],
}

/// Textures of hair for shells and fins.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct BakeSpec {
    /// What is baked.
    pub source: BakeSource,
    /// Layers, 1..=128, innermost first.
    #[schemars(range(min = 1, max = 128))]
    pub layers: u32,
    /// Size of a layer along u and v, texels.
    #[schemars(inner(range(min = 4, max = 4096)))]
    pub resolution: [u32; 2],
    /// Size of the fin along the edge and upwards, texels.
    #[schemars(inner(range(min = 4, max = 4096)))]
    pub fin_resolution: [u32; 2],
    /// Edge of the torus that the texture covers, cm; by default 1 cm for `hybrid`, otherwise a
    /// sixteenth of the skin's diameter.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub patch: Option<f32>,
    /// Height of the fur, cm; by default the groom's for `hybrid`, otherwise a thousandth of the
    /// skin's diameter per layer.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub height: Option<f32>,
    /// Thickness of the slab of hair that the fin shows, as a fraction of the torus's edge.
    #[schemars(extend("exclusiveMinimum" = 0, "maximum" = 1))]
    pub fin_slab: f32,
    /// Hair of `source = "particles"`.
    pub particles: Particles,
    /// Dots of `source = "dots"`.
    pub dots: Dots,
}

impl Default for BakeSpec {
    fn default() -> Self {
        Self {
            source: BakeSource::Hybrid,
            layers: 16,
            resolution: [128; 2],
            fin_resolution: [512, 64],
            patch: None,
            height: None,
            fin_slab: 0.06,
            particles: Particles::default(),
            dots: Dots::default(),
        }
    }
}

/// What textures are baked from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum BakeSource {
    /// The scene's groom: its guard hairs and its undercoat.
    #[default]
    Hybrid,
    /// Hair grown by a particle system (Lengyel et al. 2001).
    Particles,
    /// Random dots, fewer in each layer outwards (the xbdev tutorial).
    Dots,
}

/// Hair grown by a particle system in a box whose sides wrap around. Lengths are relative to the
/// box: across the skin 1 is the edge of the torus, upwards 1 is the height of the fur.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Particles {
    /// Hairs in the box.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub count: u32,
    /// Diameter at the root and at the tip, as a fraction of the torus's edge.
    #[schemars(inner(range(min = 0.0, max = 0.5)))]
    pub diameter: [f32; 2],
    /// Lean: tangent of the angle, along +u.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub lean: f32,
    /// Curl radius, as a fraction of the torus's edge.
    #[schemars(range(min = 0.0, max = 0.5))]
    pub curl: f32,
    /// Curl turns over the height.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub curl_frequency: f32,
    /// Random change of the direction over the height.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub noise: f32,
    /// Bend along +u that grows towards the tip, as by gravity.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub gravity: f32,
    /// Pull of the tips towards clump centres, 0..1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub clump: f32,
    /// Clump centres in the box.
    #[schemars(range(min = 1, max = 100_000))]
    pub clumps: u32,
    /// Spread of the length, 0..1, downwards.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub length_variation: f32,
    /// Colour at the root, linear RGB.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub color_root: [f32; 3],
    /// Colour at the tip, linear RGB.
    #[schemars(inner(range(min = 0.0, max = 1.0)))]
    pub color_tip: [f32; 3],
    /// Random brightness variation between hairs, 0..1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub color_variation: f32,
}

impl Default for Particles {
    fn default() -> Self {
        Self {
            count: 1200,
            diameter: [0.012, 0.004],
            lean: 0.0,
            curl: 0.0,
            curl_frequency: 2.0,
            noise: 0.15,
            gravity: 0.0,
            clump: 0.0,
            clumps: 24,
            length_variation: 0.4,
            color_root: [0.10, 0.05, 0.025],
            color_tip: [0.42, 0.26, 0.14],
            color_variation: 0.25,
        }
    }
}

/// Layers of random dots.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Dots {
    /// Dots in the innermost layer.
    #[schemars(range(min = 1, max = 1_000_000))]
    pub base: u32,
    /// Dots in the outermost layer.
    #[schemars(range(min = 0, max = 1_000_000))]
    pub tip: u32,
    /// How the number falls from `base` to `tip`.
    pub profile: DotProfile,
    /// Edge of a dot, texels.
    #[schemars(range(min = 1, max = 64))]
    pub size: u32,
    /// Smallest and largest value of red, green and blue, linear; drawn for each hair.
    #[schemars(inner(inner(range(min = 0.0, max = 1.0))))]
    pub color: [[f32; 2]; 3],
    /// Brightness of the innermost layer, relative to the outermost.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub root_brightness: f32,
}

impl Default for Dots {
    fn default() -> Self {
        Self {
            base: 1000,
            tip: 100,
            profile: DotProfile::Linear,
            size: 1,
            color: [[0.9, 0.9], [0.3, 0.5], [0.3, 0.7]],
            root_brightness: 0.4,
        }
    }
}

/// Number of dots at the height l, 0..1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum DotProfile {
    /// 1 - l.
    #[default]
    Linear,
    /// (1 - l)².
    Power2,
    /// (1 - l)³.
    Power3,
    /// Half 1 - l, half (1 - l)⁵.
    Mixed,
}

/// Shells and fins: how `fur = "shells"` is drawn.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Shells {
    /// `manifest.json` of `pelage bake`; by default textures are baked by `[bake]` when rendering.
    pub textures: Option<String>,
    /// How textures are mapped to the skin.
    pub mapping: Mapping,
    /// Draw the shells.
    pub shells: bool,
    /// Draw the fins.
    pub fins: bool,
    /// How fins appear towards the silhouette.
    pub fade: FinFade,
    /// Cosine below which an edge counts as near the silhouette, for `fade = "threshold"`.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub fin_threshold: f32,
    /// Shells write depth where they are not transparent (Lengyel et al. 2001); false: they only
    /// test it (NVIDIA's sample).
    pub depth_write: bool,
    /// Coverage grows with the length of the view ray within a layer and with its angle to the
    /// hairs; false: the texture's coverage from every direction, as in the first works on shells.
    pub slanted: bool,
    /// Number of shells drawn; by default one for each layer of the textures. Fewer: the inner
    /// ones, from the skin outwards. More: the same fur in thinner layers.
    #[schemars(range(min = 1, max = 128))]
    pub layers: Option<u32>,
    /// Distance between shells, cm; by default that of the textures.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub spacing: Option<f32>,
    /// Factor on the length: a constant or a map; 0: bald.
    #[schemars(extend("minimum" = 0))]
    pub length: Scalar,
    /// Factor on the colour: a constant, vertex colours or an image over the skin's uv.
    pub color: Color,
    /// Light model.
    pub lighting: ShellLighting,
    /// Parameters of `lighting = "table"`.
    pub table: LightingTable,
    /// Comb over the whole skin: a tangential vector, world space, whose length is the tangent of
    /// the lean.
    pub comb: [f32; 3],
    /// Brush strokes.
    pub brushes: Vec<Brush>,
    /// Shadow between hairs by a shifted lookup in the texture.
    pub shadow: ShellShadow,
    /// Forces that bend the hairs, and the spring that restores them.
    pub dynamics: Dynamics,
    /// Fewer shells with distance.
    pub lod: Lod,
}

impl Default for Shells {
    fn default() -> Self {
        Self {
            textures: None,
            mapping: Mapping::Lapped,
            shells: true,
            fins: true,
            fade: FinFade::Cosine,
            fin_threshold: 0.25,
            depth_write: true,
            slanted: true,
            layers: None,
            spacing: None,
            length: Scalar::Constant(1.0),
            color: Color::Constant([1.0; 3]),
            lighting: ShellLighting::Scene,
            table: LightingTable::default(),
            comb: [0.0; 3],
            brushes: Vec::new(),
            shadow: ShellShadow::default(),
            dynamics: Dynamics::default(),
            lod: Lod::default(),
        }
    }
}

/// How textures are mapped to the skin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum Mapping {
    /// On lapped patches.
    #[default]
    Lapped,
    /// On the skin's own uv.
    Uv,
}

/// How fins appear towards the silhouette.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum FinFade {
    /// max(0, 2|p| - 1), p the cosine between the fin's normal and the view (Lengyel et al. 2001).
    #[default]
    Cosine,
    /// Fully visible on edges that are on or near the silhouette (NVIDIA's sample).
    Threshold,
    /// Both: visible within the threshold, faded in from its limit.
    Both,
}

/// Light model of shells and fins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema, Default)]
#[serde(rename_all = "snake_case")]
pub enum ShellLighting {
    /// That of the hybrid fur: its scattering, with the transmittances of its optical-depth
    /// lattice.
    #[default]
    Scene,
    /// The 32 x 32 table of Lengyel et al. 2001, with Banks's darkening towards the skin.
    Table,
}

/// Lengyel et al. 2001: K_a + K_d (1-u²)^(P_d/2) + K_s (1-v²)^(P_s/2), u = T·L, v = T·H.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LightingTable {
    /// Ambient term K_a.
    #[schemars(range(min = 0.0))]
    pub ambient: f32,
    /// Weight of the diffuse term, K_d.
    #[schemars(range(min = 0.0))]
    pub diffuse: f32,
    /// Exponent of the diffuse term, P_d.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub diffuse_exponent: f32,
    /// Weight of the specular term, K_s.
    #[schemars(range(min = 0.0))]
    pub specular: f32,
    /// Exponent of the specular term, P_s.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub specular_exponent: f32,
    /// Brightness of the innermost layer, relative to the outermost.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub self_shadow: f32,
    /// Exponent of its growth towards the outermost layer.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub self_shadow_exponent: f32,
}

impl Default for LightingTable {
    fn default() -> Self {
        Self {
            ambient: 0.15,
            diffuse: 0.35,
            diffuse_exponent: 4.8,
            specular: 0.12,
            specular_exponent: 24.0,
            self_shadow: 0.35,
            self_shadow_exponent: 1.0,
        }
    }
}

/// A stroke of the comb.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Brush {
    /// Centre, cm, world space.
    pub center: [f32; 3],
    /// Radius, cm; the effect falls smoothly to zero there.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: f32,
    /// Comb vector, as `shells.comb`.
    pub direction: [f32; 3],
    /// Factor on the hairs' colour at the centre, which returns to 1 in the same way: shows what a
    /// stroke affects.
    #[serde(default = "white")]
    #[schemars(inner(range(min = 0.0)))]
    pub tint: [f32; 3],
}

fn white() -> [f32; 3] {
    [1.0; 3]
}

/// Shadow between hairs by a second lookup.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ShellShadow {
    /// Shift of the lookup towards the light, as a fraction of the texture.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub offset: f32,
    /// Strength; 0: none, 1: as dark as the tutorial's.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub strength: f32,
}

impl Default for ShellShadow {
    fn default() -> Self {
        Self { offset: 0.0011, strength: 0.0 }
    }
}

/// Forces on hairs and the damped spring that restores them: m b'' = -k b - c b' + m a.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Dynamics {
    /// Acceleration by gravity, cm/s², world space.
    pub gravity: [f32; 3],
    /// Acceleration by the mean wind, cm/s², world space.
    pub wind: [f32; 3],
    /// Share of the wind that varies in gusts, 0..1.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub gust: f32,
    /// Frequency of the gusts, 1/s.
    #[schemars(range(min = 0.0, max = 30.0))]
    pub gust_frequency: f32,
    /// Stiffness per mass k/m, 1/s².
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub stiffness: f32,
    /// Damping per mass c/m, 1/s.
    #[schemars(range(min = 0.0))]
    pub damping: f32,
}

impl Default for Dynamics {
    fn default() -> Self {
        Self {
            gravity: [0.0; 3],
            wind: [0.0; 3],
            gust: 0.5,
            gust_frequency: 0.7,
            stiffness: 2000.0,
            damping: 12.0,
        }
    }
}

/// Levels of detail by distance.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Lod {
    /// Whether coarser levels are used.
    pub enabled: bool,
    /// Distance of the camera, in diameters of the skin, at which the number of shells is halved;
    /// at twice that it is a quarter.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub distance: f32,
}

impl Default for Lod {
    fn default() -> Self {
        Self { enabled: false, distance: 8.0 }
    }
}
