//! What baked textures mean: units, sizes, colour space. Written beside them as `manifest.json`.

use super::memory::MemoryRow;
use pelage_core::scene::BakeSource;
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
    /// Thickness of the slab of fur that the fin shows, cm.
    pub fin_depth: f32,
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

/// What stands in `manifest.json`: what the textures mean, and in which files they are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ManifestFile {
    /// The schema of this file, beside it.
    #[serde(rename = "$schema", default)]
    pub schema: String,
    /// What the textures mean.
    #[serde(flatten)]
    pub manifest: Manifest,
    /// Unit of all lengths: cm.
    pub unit: String,
    /// Primaries and white of all colours: those of Rec. 709 and sRGB.
    pub primaries: String,
    /// The levels of detail, the finest first.
    pub lods: Vec<LodEntry>,
    /// All files.
    pub files: Vec<FileEntry>,
    /// Texture memory.
    pub memory: Vec<MemoryRow>,
}

/// A level of detail.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LodEntry {
    /// 0 is the finest.
    pub level: u32,
    /// Layers of this level.
    pub layers: u32,
    /// Height above the skin of the middle of what each layer stands for, cm.
    pub heights: Vec<f32>,
}

/// A file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FileEntry {
    /// Path from the folder of the manifest, with `/`.
    pub path: String,
    /// What it shows.
    pub content: Content,
    /// Level of detail, 0 the finest.
    pub lod: u32,
    /// The layer it shows; not there for fins and for files that hold all layers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layer: Option<u32>,
    /// How the texels are stored. The first row is that of v = 0: the top of the picture.
    pub texels: Texels,
    /// Width and height of the finest mip level.
    pub size: [u32; 2],
    /// Layers in the file; 0 where it is a plain image and no array.
    pub layers: u32,
    /// Mip levels.
    pub mips: u32,
    /// Bytes of the file.
    pub bytes: u64,
    /// Peak signal-to-noise ratio of the finest mip level against the uncompressed bytes, dB; only
    /// where it is compressed with loss and not equal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub psnr: Option<f32>,
    /// Change of the mean coverage by compression, as part of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coverage_change: Option<f32>,
}

/// What a file shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Content {
    /// The layers, or one of them; wraps around along u and v.
    Layers,
    /// The guard hairs' share of the layers.
    Guard,
    /// The fin; wraps around along u alone.
    Fin,
    /// The guard hairs' share of the fin.
    FinGuard,
}

/// How texels are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Texels {
    /// OpenEXR: 32-bit floats, linear, premultiplied. Exact.
    ExrFloat,
    /// PNG: 8 bits, sRGB, not premultiplied; texels without coverage have the colour of those
    /// around them.
    PngStraight,
    /// KTX 2.0, R8G8B8A8_SRGB: premultiplied in linear light, then encoded; coverage linear.
    Ktx2Rgba8,
    /// KTX 2.0, BC3_SRGB_BLOCK (DXT5) of the same.
    Ktx2Bc3,
    /// KTX 2.0, BC7_SRGB_BLOCK of the same.
    Ktx2Bc7,
}

/// The JSON schema (draft 2020-12) of `manifest.json`.
pub fn manifest_schema() -> serde_json::Value {
    schemars::schema_for!(ManifestFile).to_value()
}
