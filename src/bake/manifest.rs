//! What baked textures mean: units, sizes, colour space. Written beside them as `manifest.json`.

use crate::scene::BakeSource;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What baked textures mean.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Manifest {
    /// Version of this format: 1.
    pub version: u32,
    /// Program and version that made the textures.
    pub generator: String,
    /// What they were made from.
    pub source: BakeSource,
    /// Seed of everything random.
    pub seed: u32,
    /// Number of layers, innermost first.
    pub layers: u32,
    /// Texels of a layer along u and v.
    pub resolution: [u32; 2],
    /// Texels of the fin along the edge and upwards.
    pub fin_resolution: [u32; 2],
    /// Edges of the torus along u and v, cm: one repeat of the texture on the skin.
    pub patch: [f32; 2],
    /// Length of one repeat of the fin along an edge, cm.
    pub fin_length: f32,
    /// Height of the fur, cm. Layer l is drawn at (l + 0.5) spacings.
    pub height: f32,
    /// Distance between layers, cm: height / layers.
    pub spacing: f32,
    /// Mean colour and coverage of each layer.
    pub summary: Vec<LayerSummary>,
}

/// Means over a layer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LayerSummary {
    /// Mean coverage.
    pub coverage: f32,
    /// Mean optical depth for a look along the normal across the hairs.
    pub optical_depth: f32,
    /// Mean colour, linear RGB, weighted by coverage.
    pub color: [f32; 3],
}
