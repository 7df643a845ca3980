//! The table `[groom]`: the size of the whole coat.

use super::{NoiseDomain, Scalar, Scene};
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
    /// and stay.
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

impl Scene {
    /// Applies `groom.scale` to the lengths of the coat, and sets it to 1.
    pub(super) fn scale_groom(&mut self) {
        let scale = std::mem::take(&mut self.groom).scale;
        if scale == 1.0 {
            return;
        }
        let guard = &mut self.guard;
        for length in [&mut guard.length, &mut guard.curl, &mut guard.frizz, &mut self.undercoat.height] {
            *length = length.scaled(scale);
        }
        guard.curl_frequency /= scale;
        guard.frizz_frequency /= scale;
        guard.clump_density /= scale * scale;
        let undercoat = &mut self.undercoat;
        undercoat.cell = (undercoat.cell * scale).max(1e-4);
        if undercoat.noise_domain == NoiseDomain::Object {
            undercoat.uv_jitter *= scale;
            undercoat.noise_frequency /= scale;
            undercoat.height_frequency /= scale;
        }
        for length in [&mut self.bake.patch, &mut self.bake.height, &mut self.shells.spacing] {
            *length = length.map(|cm| cm * scale);
        }
    }
}
