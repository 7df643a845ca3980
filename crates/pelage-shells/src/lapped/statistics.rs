//! Statistics of the quality of patches.

use super::{Lapped, flatten::Map, surface::Surface};
use pelage_core::{Result, Skin};
use serde::Serialize;

/// Quality of patches. Means are weighted by area, over the visible faces: those of the topmost
/// patches, or all faces of all patches if they overlap. Needles, faces too thin for single
/// precision to resolve their shape, are left out.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Statistics {
    /// Faces of the skin.
    pub faces: u64,
    /// Number of needles among them.
    pub needles: u64,
    /// Patches.
    pub patches: u64,
    /// Patches of a single face.
    pub single_face_patches: u64,
    /// Radius of the outlines, cm.
    pub radius: f64,
    /// Fraction of the area that patches cover, 0..1.
    pub coverage: f64,
    /// Area of all patches over the area of the skin: the mean number of patches on a point.
    pub layers: f64,
    /// Mean stretch of a face: its largest singular value or the inverse of its smallest, whichever
    /// is larger. 1 is an isometry.
    pub mean_stretch: f64,
    /// Largest stretch.
    pub worst_stretch: f64,
    /// Mean angle between u and the field, degrees; `None` if patches do not follow it.
    pub mean_angle_error: Option<f64>,
    /// Largest angle, degrees; `None` if patches do not follow the field.
    pub worst_angle_error: Option<f64>,
    /// Total length of the edges between faces that show different patches, cm.
    pub seam_length: f64,
    /// Number of faces in all patches, needles included, whose uv area is not positive although the
    /// face has sides.
    pub flipped: u64,
    /// Time taken by [`super::lap`], ms.
    pub time_ms: f64,
}

impl Lapped {
    /// Measures the patches on `skin`, for which they were made.
    ///
    /// # Errors
    /// [`pelage_core::Error::Scene`] if a position of the skin is not finite.
    pub fn statistics(&self, skin: &Skin) -> Result<Statistics> {
        let surface = Surface::new(skin)?;
        let overlapping = self.patches.iter().any(|p| !p.outline.is_empty());
        let mut s = Statistics {
            faces: surface.frames.len() as u64,
            needles: surface.frames.iter().filter(|f| f.needle).count() as u64,
            patches: self.patches.len() as u64,
            single_face_patches: self.patches.iter().filter(|p| p.faces.len() == 1).count() as u64,
            radius: self.radius.into(),
            coverage: self.coverage,
            worst_stretch: 1.0,
            time_ms: self.time_ms,
            ..Default::default()
        };
        let (mut weight, mut pasted, mut angles, mut worst_angle) = (0.0, 0.0, 0.0, 0.0_f64);
        for (number, patch) in self.patches.iter().enumerate() {
            for (f, uv) in patch.faces.iter().zip(&patch.corner_uv) {
                let frame = &surface.frames[*f as usize];
                let uv = uv.map(|p| p.as_dvec2());
                let [a, b, c] = uv;
                // A face collapsed to a point has no orientation.
                if (b - a).perp_dot(c - a) <= 0.0 && !(a == b && b == c) {
                    s.flipped += 1;
                }
                pasted += frame.area;
                if frame.needle || !(overlapping || self.topmost[*f as usize] == number as u32) {
                    continue;
                }
                let direction = frame.tangential(self.field[*f as usize].as_dvec3());
                let map = Map::of(&frame.turned(direction), &uv);
                let stretch = map.stretch[0].max(1.0 / map.stretch[1]);
                weight += frame.area;
                s.mean_stretch += frame.area * stretch;
                s.worst_stretch = s.worst_stretch.max(stretch);
                angles += frame.area * map.angle.abs();
                worst_angle = worst_angle.max(map.angle.abs());
            }
        }
        let weight = if weight > 0.0 { weight } else { 1.0 };
        s.mean_stretch /= weight;
        s.layers = pasted / surface.area;
        s.mean_angle_error = self.aligned.then_some((angles / weight).to_degrees());
        s.worst_angle_error = self.aligned.then_some(worst_angle.to_degrees());
        for f in 0..surface.frames.len() as u32 {
            for (k, g) in surface.around(f).filter(|(_, g)| *g > f) {
                if self.topmost[f as usize] != self.topmost[g as usize] {
                    s.seam_length += surface.side(f, k).length();
                }
            }
        }
        Ok(s)
    }
}
