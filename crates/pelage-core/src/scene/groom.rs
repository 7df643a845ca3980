//! The table `[groom]`: the size of the whole coat.

use super::{Guard, NoiseDomain, Scalar, Scene, Undercoat};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The coat as a whole.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct GroomSpec {
    /// Factor on every length of the coat, so that a preset fits a smaller or larger body; by
    /// default 1.
    ///
    /// Multiplied by it: `guard.length`, `guard.curl`, `guard.frizz`, `undercoat.height`,
    /// `undercoat.cell`, `undercoat.uv_jitter`, and, where they are given, `bake.patch`,
    /// `bake.height` and `shells.spacing`. Divided by it: `guard.curl_frequency`,
    /// `guard.frizz_frequency`, `undercoat.noise_frequency`, `undercoat.height_frequency`.
    /// `guard.clump_density`, which is per area, is divided by its square. Maps keep their shape:
    /// value and offset are scaled. With `noise_domain = "uv"` noise and jitter are in units of uv
    /// and stay. The coats of parts are scaled alike; `edge` of a part, a width on the body, stays.
    ///
    /// Diameters and hairs/cm² stay: hairs of small and large mammals are about equally thick and
    /// dense, and their coats differ in length. A longer coat therefore blocks more light. Textures
    /// that were baked before (`shells.textures`) stay too.
    ///
    /// It is applied once when a scene is loaded: the keys above then hold the scaled values, and
    /// this one is 1.
    #[schemars(range(min = 0.001, max = 1000.0))]
    pub scale: f32,
}

impl Default for GroomSpec {
    fn default() -> Self {
        Self { scale: 1.0 }
    }
}

impl GroomSpec {
    /// Whether the lengths of the coat stay as they are.
    pub(super) fn is_one(&self) -> bool {
        self.scale == 1.0
    }
}

impl Scalar {
    /// The parameter times `factor`, wherever it comes from.
    fn scaled(&self, factor: f32) -> Self {
        match self {
            Self::Constant(value) => Self::Constant(value * factor),
            Self::Mapped(map) => {
                let mut map = map.clone();
                map.value *= factor;
                map.offset *= factor;
                Self::Mapped(map)
            }
        }
    }
}

impl Guard {
    /// Multiplies the lengths of the hairs.
    fn scale(&mut self, scale: f32) {
        for length in [&mut self.length, &mut self.curl, &mut self.frizz] {
            *length = length.scaled(scale);
        }
        self.curl_frequency /= scale;
        self.frizz_frequency /= scale;
        self.clump_density /= scale * scale;
    }
}

impl Undercoat {
    /// Multiplies the lengths of the hairs and of the noise.
    fn scale(&mut self, scale: f32) {
        self.height = self.height.scaled(scale);
        self.cell = (self.cell * scale).max(1e-4);
        if self.noise_domain == NoiseDomain::Object {
            self.uv_jitter *= scale;
            self.noise_frequency /= scale;
            self.height_frequency /= scale;
        }
    }
}

impl Scene {
    /// Applies `groom.scale` to the lengths of the coats of the scene and its parts, and sets it
    /// to 1.
    pub(super) fn scale_groom(&mut self) {
        let scale = std::mem::take(&mut self.groom).scale;
        if scale == 1.0 {
            return;
        }
        self.guard.scale(scale);
        self.undercoat.scale(scale);
        for part in &mut self.parts {
            part.guard.iter_mut().for_each(|guard| guard.scale(scale));
            part.undercoat.iter_mut().for_each(|undercoat| undercoat.scale(scale));
        }
        for length in [&mut self.bake.patch, &mut self.bake.height, &mut self.shells.spacing] {
            *length = length.map(|cm| cm * scale);
        }
    }
}
