//! The shape of a guard hair: twin of `shaders/shared/strand_curve.wgsl` and of the profiles along
//! the hair in `shaders/guard_strands.wgsl` and `shaders/guard_shade.wgsl`. Baking, glTF and shells
//! use the same functions.
//!
//! The curve is a cubic Bézier curve whose control polygon has three legs. Vectors are relative to
//! the root.
// [Andersen2016] sec. 2 names Bézier shaping; the formulas are ours.

use crate::arithmetic::ease;
use crate::random::random;
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// Unit directions of the three legs. `n` is the unit normal of the skin; `lean` is tangential, its
/// length the tangent of the angle from the normal; `gravity` is the pull towards −y.
pub fn leg_directions(n: Vec3, lean: Vec3, gravity: f32) -> [Vec3; 3] {
    let fall = Vec3::new(0.0, -gravity, 0.0);
    [n + 0.5 * lean, n + 0.9 * lean + 0.35 * fall, n + 1.25 * lean + fall].map(|leg| leg.normalize_or(n))
}

/// The two inner control points and the tip, from the three legs. No control point lies below the
/// tangent plane.
pub fn control_polygon(n: Vec3, [leg1, leg2, leg3]: [Vec3; 3]) -> [Vec3; 3] {
    let above = |p: Vec3| p - n * p.dot(n).min(0.0);
    let p2 = leg1 + leg2;
    // The third leg starts at the second control point as it was before it was raised.
    [leg1, above(p2), above(p2 + leg3)]
}

/// Point of the curve at parameter `s` (0 root, 1 tip), relative to the root.
pub fn bezier([p1, p2, p3]: [Vec3; 3], s: f32) -> Vec3 {
    let r = 1.0 - s;
    3.0 * r * r * s * p1 + 3.0 * r * s * s * p2 + s * s * s * p3
}

/// Two unit vectors perpendicular to the unit vector `n` and to each other.
pub fn sides(n: Vec3) -> [Vec3; 2] {
    let across = if n.x.abs() > 0.7 { Vec3::Y } else { Vec3::X };
    let side = across.cross(n).normalize();
    [side, n.cross(side)]
}

/// The unit vector at `azimuth` (radians) in the plane of two sides.
pub fn side_at([side, other]: [Vec3; 2], azimuth: f32) -> Vec3 {
    azimuth.cos() * side + azimuth.sin() * other
}

/// A Rayleigh deviate of scale 1 from a uniform `u`: a lean of this length in a uniform direction
/// is normally distributed along both axes.
// [BoxMuller1958]
pub fn rayleigh(u: f32) -> f32 {
    (-2.0 * (1.0 - u).ln()).sqrt()
}

/// Offsets of curl and frizz at `s` of a strand `length` cm long, in units of their amplitudes,
/// along the two directions perpendicular to the strand at its root. `seed` is that of the strand;
/// the frequencies are those of curl and frizz, 1/cm.
pub fn curl_and_frizz(
    seed: u32,
    length: f32,
    [curl_frequency, frizz_frequency]: [f32; 2],
    s: f32,
) -> [Vec2; 2] {
    let phase = TAU * random(seed, 3);
    let turn = phase + TAU * curl_frequency * length * s;
    let curl = Vec2::new(turn.cos() - phase.cos(), turn.sin() - phase.sin());
    let frizz = [(4, 1.0), (5, 1.37)]
        .map(|(k, f)| (TAU * random(seed, k) + TAU * frizz_frequency * length * s * f).sin());
    [curl, frizz.into()]
}

/// Diameter at `s`, in the unit of the three given diameters: at the root, at the widest point
/// (`s = widest`) and at the tip.
pub fn diameter([root, largest, tip]: [f32; 3], widest: f32, s: f32) -> f32 {
    if s < widest {
        let x = s / widest.max(1e-3);
        return root + (largest - root) * ease(x);
    }
    let x = (s - widest) / (1.0 - widest).max(1e-3);
    largest + (tip - largest) * x * x
}

/// Colour at `s` of a hair with colours `root` and `tip` at its ends, linear RGB in 0..1;
/// `transition` as in [`tip_share`].
pub fn color_at(transition: [f32; 2], [root, tip]: [Vec3; 2], s: f32) -> Vec3 {
    root.lerp(tip, tip_share(transition, s)).clamp(Vec3::ZERO, Vec3::ONE)
}

/// Weight of the tip's colour at `s`; `transition` is the middle and the width of the change from
/// the root's colour.
pub fn tip_share([middle, width]: [f32; 2], s: f32) -> f32 {
    ease(((s - middle + 0.5 * width) / (width + 1e-4)).clamp(0.0, 1.0))
}
