//! Textures of hair for shells and fins: made from a groom, a particle system or dots, and written for real-time clients.

pub mod gltf;
mod manifest;

pub use manifest::{LayerSummary, Manifest};

/// An image that wraps around: linear RGB, premultiplied by coverage, and coverage.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Texture {
    /// Texels along u.
    pub width: u32,
    /// Texels along v (upwards in a fin).
    pub height: u32,
    /// Row by row, v = 0 first; texel (i, j) is the cell around ((i + 0.5) / width, (j + 0.5) / height).
    pub texels: Vec<[f32; 4]>,
}

/// All textures of one fur.
#[derive(Debug, Clone, PartialEq)]
pub struct FurTextures {
    /// The layers, innermost first, all of one size. Layer `l` stands for the slab of fur from `l` to `l + 1` spacings above the skin and is
    /// drawn in its middle. Coverage is that of a look along the skin's normal with every hair seen from the side: 1 - exp(-tau), tau the hairs'
    /// length x diameter in the texel's column over the texel's area. The innermost layer is not made opaque; the skin lies below it.
    pub layers: Vec<Texture>,
    /// The part of each layer that is guard hair: its share of the premultiplied colour and of the coverage. Empty where the source knows one
    /// kind of hair only.
    pub guard: Vec<Texture>,
    /// Fin: u along the edge, wraps around; v from the skin to the tips, does not wrap. Coverage of a slab of hair seen across.
    pub fin: Texture,
    /// The guard hairs' part of the fin; 0 x 0 where `guard` is empty.
    pub fin_guard: Texture,
    /// What the textures mean.
    pub manifest: Manifest,
}
