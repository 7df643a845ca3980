//! Metadata of baked textures: units, sizes, colour space. Written as `manifest.json`.

use super::memory::MemoryRow;
use pelage_core::scene::BakeSource;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Metadata of baked textures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Manifest {
    /// Version of this format: 1.
    pub version: u32,
    /// Program and version that wrote the textures.
    pub generator: String,
    /// Source of the hair.
    pub source: BakeSource,
    /// Seed of all random numbers.
    pub seed: u32,
    /// Number of layers, innermost first.
    pub layers: u32,
    /// Texels of a layer along u and v.
    pub resolution: [u32; 2],
    /// Texels of the fin along the edge and upwards.
    pub fin_resolution: [u32; 2],
    /// Edges of the torus along u and v, cm: one repeat of the texture on the skin.
    pub patch: [f32; 2],
    /// Length along an edge of one repeat of the fin, cm.
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
    /// Mean optical depth along the normal, with every hair perpendicular to it.
    pub optical_depth: f32,
    /// Mean colour, linear RGB, weighted by coverage.
    pub color: [f32; 3],
}

/// Contents of `manifest.json`: metadata of the textures, and their files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ManifestFile {
    /// The schema of this file, in the same folder.
    #[serde(rename = "$schema", default)]
    pub schema: String,
    /// Metadata of the textures.
    #[serde(flatten)]
    pub manifest: Manifest,
    /// Unit of all lengths: cm.
    pub unit: String,
    /// Primaries and white point of all colours: those of Rec. 709 and sRGB.
    pub primaries: String,
    /// The levels of detail, finest first.
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
    /// Number of layers at this level.
    pub layers: u32,
    /// For each layer, the height above the skin of the middle of the slab that it represents, cm.
    pub heights: Vec<f32>,
}

/// A file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FileEntry {
    /// Path relative to the manifest's folder, with `/`.
    pub path: String,
    /// Contents of the file.
    pub content: Content,
    /// Level of detail; 0 is the finest.
    pub lod: u32,
    /// Index of the layer; absent for fins and for files that hold all layers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub layer: Option<u32>,
    /// How the texels are stored. The first row, at the top of the image, has v = 0.
    pub texels: Texels,
    /// Width and height of the finest mip level.
    pub size: [u32; 2],
    /// Number of array layers; 0 for a plain image.
    pub layers: u32,
    /// Number of mip levels.
    pub mips: u32,
    /// Size of the file in bytes.
    pub bytes: u64,
    /// Peak signal-to-noise ratio of the finest mip level relative to the uncompressed bytes, dB;
    /// absent for lossless files and for equal bytes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub psnr: Option<f32>,
    /// Relative change of the mean coverage by compression.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coverage_change: Option<f32>,
}

/// Contents of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Content {
    /// The layers, or one of them; wraps around along u and v.
    Layers,
    /// Contribution of the guard hairs to the layers.
    Guard,
    /// The fin; wraps around along u only.
    Fin,
    /// Contribution of the guard hairs to the fin.
    FinGuard,
}

/// How texels are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Texels {
    /// OpenEXR: 32-bit floats, linear, premultiplied. Exact.
    ExrFloat,
    /// PNG: 8 bits, sRGB, not premultiplied; texels without coverage have the colour of their
    /// surroundings.
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
