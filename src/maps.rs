//! Image maps of the groom.

use crate::{Result, Scene, assets::Assets};

/// The images that a scene's groom names, each once.
#[derive(Debug, Clone, Default)]
pub struct MapSet {
    /// The images.
    pub images: Vec<MapImage>,
}

/// One image, linear RGBA (PNG colours decoded from sRGB for colours, raw for scalars: see `name`).
#[derive(Debug, Clone)]
pub struct MapImage {
    /// File name as in the scene.
    pub name: String,
    /// Decoded from sRGB (colours) or raw (scalars).
    pub color: bool,
    /// Texels.
    pub width: u32,
    /// Texels.
    pub height: u32,
    /// Row by row from the top, straight alpha.
    pub texels: Vec<[f32; 4]>,
}

impl MapSet {
    /// Loads every map that `scene` names.
    pub fn load(_scene: &Scene, _assets: &Assets) -> Result<Self> {
        Ok(Self::default())
    }
}
