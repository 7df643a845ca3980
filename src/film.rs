//! The film: the finished image as named planes.

/// An image of named planes, row by row from the top, `width * height` values each.
///
/// `R G B` are linear and premultiplied by `A`; the others are named as pbrt's film and Blender name theirs:
/// `guard.R`, `undercoat.R`, `base.R` (premultiplied contributions that add up to `R G B`), `depth.Z` (cm along the
/// viewing direction, infinity where nothing is), `N.X`, `transmittance.Y`, `fragments.Y`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Film {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// The planes: at least `R G B A`.
    pub planes: Vec<Plane>,
}

/// One plane of a [`Film`].
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    /// Channel name as written to EXR.
    pub name: String,
    /// Written as 32-bit float (depth, position, normals, counts) instead of half.
    pub full_precision: bool,
    /// The values.
    pub data: Vec<f32>,
}

impl Film {
    /// The plane called `name`.
    pub fn plane(&self, name: &str) -> Option<&[f32]> {
        self.planes.iter().find(|p| p.name == name).map(|p| p.data.as_slice())
    }

    /// The plane called `name`, to change.
    pub fn plane_mut(&mut self, name: &str) -> Option<&mut [f32]> {
        self.planes.iter_mut().find(|p| p.name == name).map(|p| p.data.as_mut_slice())
    }
}
