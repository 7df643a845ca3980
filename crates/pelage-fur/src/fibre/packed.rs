//! The models, as the shaders read them.

use super::{Absorption, FarTable, Fibre};
use crate::layout;
use bytemuck::Zeroable;

/// Number of models that the shaders distinguish.
pub const MODELS: u32 = 5;

impl Fibre {
    /// Index of the model in `shaders/shared/fibre.wgsl`.
    pub fn number(&self) -> u32 {
        match self {
            Self::KajiyaKay(_) => 0,
            Self::Sadeghi(model) if model.albedo.is_none() => 1,
            Self::Sadeghi(_) => 2,
            Self::Chiang(_) => 3,
            Self::Medulla(_) => 4,
        }
    }

    /// The uniform; `base` is the first texel of the model's table in its buffer.
    pub fn packed(&self, base: u32) -> layout::Fibre {
        let none = layout::Fibre::zeroed();
        let packed = match self {
            Self::KajiyaKay(model) => layout::Fibre {
                diffuse: model.diffuse,
                specular: model.specular,
                specular_exponent: model.exponent,
                ..none
            },
            Self::Sadeghi(model) => layout::Fibre {
                intensity: model.intensity,
                diffuse: model.diffuse,
                shift: model.shift,
                azimuth_tt: model.azimuth_tt,
                width: model.width,
                glint: model.glint,
                glint_width: model.glint_width,
                ..none
            },
            Self::Chiang(model) => absorbing(&model.absorption, model.variance, model.shift),
            Self::Medulla(model) => {
                let [square, tilt] = [model.parts.width[0] * model.parts.width[0], model.parts.tilt];
                absorbing(
                    &model.parts.absorption,
                    [2.0 * square, square, 2.25 * square, 1.0],
                    [tilt, tilt, 3.0 * tilt, 0.0],
                )
            }
        };
        layout::Fibre { table_base: base, table_size: self.table().0, ..packed }
    }

    /// The table as stored in buffers, texels of four halves; empty for models without a table.
    pub fn texels(&self) -> Vec<[u32; 2]> {
        let half = |a: f32, b: f32| {
            u32::from(half::f16::from_f32(a).to_bits()) | (u32::from(half::f16::from_f32(b).to_bits()) << 16)
        };
        self.table().1.iter().map(|[r, tt, trt, rest]| [half(*r, *tt), half(*trt, *rest)]).collect()
    }

    /// Size of the table (`[azimuths, inclinations, layers]`) and its values,
    /// `[layer][inclination][azimuth]`.
    fn table(&self) -> ([u32; 3], Vec<[f32; 4]>) {
        if let Self::Sadeghi(super::Sadeghi { albedo: Some(rows), .. }) = self {
            let values = rows.iter().map(|[r, tt, trt]| [*r, *tt, *trt, 0.0]).collect();
            return ([rows.len() as u32, 1, 1], values);
        }
        match FarTable::shared(self) {
            Some(table) => ([table.phis, table.thetas, table.layers].map(|n| n as u32), table.values.clone()),
            None => ([0; 3], Vec::new()),
        }
    }
}

fn absorbing(absorption: &Absorption, variance: [f32; 4], turn: [f32; 4]) -> layout::Fibre {
    let (divisor, absorption) = match absorption {
        Absorption::Color(divisor) => (*divisor, [0.0; 3]),
        Absorption::Fixed(sigma) => (0.0, (*sigma).into()),
    };
    layout::Fibre {
        divisor,
        absorption,
        variance,
        turn_sin: turn.map(f32::sin),
        turn_cos: turn.map(f32::cos),
        ..layout::Fibre::zeroed()
    }
}
