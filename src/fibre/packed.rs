//! Models as the shaders read them.

use super::{Absorption, FarTable, Fibre};
use crate::layout;
use bytemuck::Zeroable;

/// Number of models that shaders tell apart.
pub const MODELS: u32 = 5;

impl Fibre {
    /// The model's number in `shaders/shared/fibre.wgsl`.
    pub fn number(&self) -> u32 {
        match self {
            Self::KajiyaKay(_) => 0,
            Self::Sadeghi(model) if model.albedo.is_none() => 1,
            Self::Sadeghi(_) => 2,
            Self::Chiang(_) => 3,
            Self::Medulla(_) => 4,
        }
    }

    /// The uniform.
    pub fn packed(&self) -> layout::Fibre {
        let none = layout::Fibre::zeroed();
        match self {
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
        }
    }

    /// Width, height and layers of the table, and its texels: one empty texel where there is none.
    pub fn texels(&self) -> ([u32; 3], Vec<[f32; 4]>) {
        if let Self::Sadeghi(super::Sadeghi { albedo: Some(rows), .. }) = self {
            let texels = rows.iter().map(|[r, tt, trt]| [*r, *tt, *trt, 0.0]).collect();
            return ([rows.len() as u32, 1, 1], texels);
        }
        match FarTable::shared(self) {
            Some(table) => ([table.phis, table.thetas, table.layers].map(|n| n as u32), table.values.clone()),
            None => ([1; 3], vec![[0.0; 4]]),
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
