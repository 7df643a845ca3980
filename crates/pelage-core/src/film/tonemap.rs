//! From linear colour to display values: exposure, tone mapping, the sRGB transfer function.

use crate::scene::{FilmSpec, Tonemap};
use glam::{DMat3, DVec3, Vec3};

/// Relative luminance of linear Rec. 709 colour.
// [BT709] sec. 3
pub fn luminance(rgb: Vec3) -> f32 {
    rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// `value` in 0..=`limit`; NaN becomes 0.
pub(super) fn clamped(value: f32, limit: f32) -> f32 {
    if value.is_nan() { 0.0 } else { value.clamp(0.0, limit) }
}

/// sRGB code value, 0..1, of a linear value; values outside 0..1 are clamped, NaN becomes 0.
// [IEC61966] sec. 5.2
pub fn srgb_encode(linear: f32) -> f32 {
    let x = clamped(linear, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// Linear value of an sRGB code value, both 0..1.
// [IEC61966] sec. 5.2
pub fn srgb_decode(code: f32) -> f32 {
    let x = clamped(code, 1.0);
    if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

/// Maps exposed linear Rec. 709 colour to display-linear colour in 0..1. Negative and NaN inputs
/// count as 0.
///
/// * `none` clamps.
/// * `neutral`: Khronos PBR neutral.
/// * `agx`: base look without a grading, with the 2.2 display exponent undone.
/// * `aces`: Narkowicz's fit of the ACES RRT and ODT, without his 0.6 pre-exposure.
// [Khronos2024] PBR Neutral specification; [Sobotka2022], [Wrensch2023]; [Narkowicz2015]
pub fn tone_map(kind: Tonemap, rgb: Vec3) -> Vec3 {
    let rgb = Vec3::from(rgb.to_array().map(|v| clamped(v, f32::MAX)));
    let mapped = match kind {
        Tonemap::None => rgb,
        Tonemap::Neutral => neutral(rgb),
        Tonemap::Agx => agx(rgb),
        Tonemap::Aces => aces(rgb),
    };
    mapped.clamp(Vec3::ZERO, Vec3::ONE)
}

/// 8-bit sRGB code values of straight (not premultiplied) linear colour: exposure in stops, tone
/// mapping, encoding.
pub fn display_rgb8(straight: Vec3, spec: &FilmSpec) -> [u8; 3] {
    let display = tone_map(spec.tonemap, straight * spec.exposure.exp2());
    display.to_array().map(|v| (srgb_encode(v) * 255.0).round() as u8)
}

/// Khronos PBR neutral.
// [Khronos2024] F90 = 0.04, Ks = 0.8 - F90, Kd = 0.15
fn neutral(rgb: Vec3) -> Vec3 {
    const F90: f32 = 0.04;
    const KS: f32 = 0.8 - F90;
    const KD: f32 = 0.15;
    let x = rgb.min_element();
    let toe = if x <= 2.0 * F90 { x - x * x / (4.0 * F90) } else { F90 };
    let rgb = rgb - toe;
    let peak = rgb.max_element();
    if peak <= KS {
        return rgb;
    }
    let new_peak = 1.0 - (1.0 - KS) * (1.0 - KS) / (peak + 1.0 - 2.0 * KS);
    let keep = 1.0 / (KD * (peak - new_peak) + 1.0);
    // Divided first: peak may be near the largest float.
    (rgb / peak) * new_peak * keep + Vec3::splat(new_peak * (1.0 - keep))
}

/// Narkowicz's rational fit, written in 1/x above 1 so that it cannot overflow.
fn aces(rgb: Vec3) -> Vec3 {
    let curve = |x: f32| {
        if x <= 1.0 {
            x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
        } else {
            let r = 1.0 / x;
            (2.51 + 0.03 * r) / (2.43 + r * (0.59 + 0.14 * r))
        }
    };
    Vec3::from(rgb.to_array().map(curve))
}

/// AgX: inset matrix, log2 encoding from -12.47393 to 4.026069 stops, sigmoid, outset matrix,
/// display exponent.
///
/// The sigmoid is Sobotka's own (slope 2 at the pivot, powers 3 and 3.25) and not a polynomial fit
/// of it; the outset is the inverse of the inset.
fn agx(rgb: Vec3) -> Vec3 {
    const MIN_EV: f64 = -12.473_931_188_332_413;
    const MAX_EV: f64 = 4.026_068_811_667_588;
    let inset = DMat3::from_cols(
        DVec3::new(0.842_479_062_253_094, 0.042_328_242_261_012_3, 0.042_375_654_905_705_1),
        DVec3::new(0.078_433_599_999_999_2, 0.878_468_636_469_772, 0.078_433_6),
        DVec3::new(0.079_223_745_147_764_3, 0.079_166_127_460_543_4, 0.879_142_973_793_104),
    );
    let encoded = (inset * rgb.as_dvec3()).to_array().map(|v| {
        let stops = v.max(1e-10).log2().clamp(MIN_EV, MAX_EV);
        agx_sigmoid((stops - MIN_EV) / (MAX_EV - MIN_EV))
    });
    let display = inset.inverse() * DVec3::from(encoded);
    DVec3::from(display.to_array().map(|v| v.clamp(0.0, 1.0).powf(2.2))).as_vec3()
}

/// Hyperbolic sigmoid through (0, 0), the pivot (10 / 16.5, 0.5) and (1, 1).
// [Sobotka2022]
fn agx_sigmoid(x: f64) -> f64 {
    const PIVOT: f64 = 10.0 / 16.5;
    const SLOPE: f64 = 2.0;
    // On either side of the pivot: the distance to the end of the curve, and the power of the bend.
    let (reach, power) = if x < PIVOT { (PIVOT, 3.0) } else { (1.0 - PIVOT, 3.25) };
    let bend = (((SLOPE * reach) / 0.5).powf(power) - 1.0) / reach.powf(power);
    let t = x - PIVOT;
    0.5 + SLOPE * t / (1.0 + bend * t.abs().powf(power)).powf(1.0 / power)
}
