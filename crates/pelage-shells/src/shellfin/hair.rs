//! The longest hair over a point of the skin, along which shells and fins rise. Vectors are
//! relative to the root, in units of the fur's height.

use glam::Vec3;
use pelage_fur::strand_curve::{control_polygon, leg_directions};

/// Control points 1 to 3 of a cubic Bézier curve over upright direction `n` on which height is
/// proportional to the parameter. `lean` is tangential. Without `gravity` the hair is sheared by
/// the lean; with it, it is the groom's strand without its random parts, scaled so that its tip is
/// as high as the fur.
pub fn hair_curve(n: Vec3, lean: Vec3, gravity: Option<f32>) -> [Vec3; 3] {
    let aside = match gravity {
        None => [lean / 3.0, lean * (2.0 / 3.0), lean],
        Some(gravity) => {
            let legs = leg_directions(n, lean, gravity).map(|leg| leg / 3.0);
            let polygon = control_polygon(n, legs);
            polygon.map(|p| (p - n * p.dot(n)) / polygon[2].dot(n).max(0.25))
        }
    };
    // Control points at evenly spaced heights make height proportional to the parameter.
    [0, 1, 2].map(|k| aside[k] + n * ((k + 1) as f32 / 3.0))
}

/// The point `p` of a hair at height `s`, displaced by forces: it keeps its distance from the root
/// and stays above the skin.
// [Xbdev]
// DEVIATION: hairs keep their length; those of the tutorial stretch.
pub fn bent(p: Vec3, displacement: Vec3, n: Vec3, s: f32) -> Vec3 {
    let displaced = p + displacement;
    let p = displaced * (p.length() / displaced.length().max(1e-4));
    p + n * (0.1 * s - p.dot(n)).max(0.0)
}

/// Weight of a brush stroke at a point, 1 at its centre and 0 from `radius` on. Lengths in cm.
pub fn brush_weight(at: Vec3, center: [f32; 3], radius: f32) -> f32 {
    let d = at.distance(center.into()) / radius;
    (1.0 - d * d).max(0.0).powi(2)
}
