//! Chiang's model against values of another implementation.

use glam::Vec3;
use pelage_fur::fibre::{Chiang, Fibre, Hit};

/// Roughness along and around, tilt (degrees), index, absorption, direction of the view, of the
/// light, f cos of the light.
type Row = ([f32; 2], f32, f32, f32, [f32; 3], [f32; 3], f32);

/// Mitsuba 3.9.1, `hair`, evaluated one by one in its frame of a cylinder whose normal is +z here
/// and whose tangent is +x.
const MITSUBA: [Row; 11] = [
    ([0.3, 0.3], 2.0, 1.55, 0.05, [0.032, -0.970, 0.239], [-0.655, 0.742, 0.147], 0.04237),
    ([0.3, 0.3], 2.0, 1.55, 0.05, [0.833, 0.482, 0.271], [-0.319, -0.781, 0.537], 0.11669),
    ([0.3, 0.3], 2.0, 1.55, 0.05, [-0.219, -0.145, 0.965], [0.214, -0.004, 0.977], 0.11610),
    ([0.3, 0.3], 2.0, 1.55, 0.05, [0.249, 0.923, 0.292], [0.032, -0.974, 0.224], 0.45755),
    ([0.5, 0.6], -3.0, 1.45, 0.3, [-0.763, -0.552, 0.335], [0.380, -0.081, -0.921], 0.08758),
    ([0.5, 0.6], -3.0, 1.45, 0.3, [-0.371, -0.677, 0.636], [0.941, 0.090, -0.325], 0.02244),
    ([0.5, 0.6], -3.0, 1.45, 0.3, [0.591, 0.565, 0.576], [-0.666, 0.723, -0.185], 0.04446),
    ([0.5, 0.6], -3.0, 1.45, 0.3, [-0.338, 0.922, 0.189], [-0.702, -0.539, 0.466], 0.03284),
    ([0.3, 0.3], 2.0, 1.55, 0.0, [0.368, 0.102, 0.924], [-0.725, -0.053, 0.687], 0.07155),
    ([0.3, 0.3], 2.0, 1.55, 0.0, [0.455, 0.835, 0.309], [-0.279, 0.326, -0.903], 0.26976),
    ([0.3, 0.3], 2.0, 1.55, 0.0, [-0.425, -0.146, 0.893], [-0.118, -0.406, 0.906], 0.02988),
];

/// Relative differences for a model whose tilt and offset are multiplied by `tilt` and `offset`.
fn differences(tilt: f32, offset: f32) -> Vec<f32> {
    let of = |&(roughness, degrees, ior, sigma, eye, light, expected): &Row| {
        let model = Chiang::new(roughness, (tilt * degrees).to_radians(), ior, Some(Vec3::splat(sigma)));
        let [eye, light] = [eye, light].map(|d| Vec3::from(d).normalize());
        let h = offset * (eye.z.atan2(eye.y) - std::f32::consts::FRAC_PI_2).sin();
        let hit = Hit { tint: Vec3::ONE, glint_angle: 0.0, h };
        let found = Fibre::Chiang(model).evaluate(&hit, light, eye) * (1.0 - light.x * light.x).sqrt();
        found.x / expected - 1.0
    };
    MITSUBA.iter().map(of).collect()
}

/// Mitsuba's Bessel function is an approximation, 0.4 % off where a lobe is narrow.
#[test]
fn chiang_has_mitsubas_values() {
    let largest = differences(1.0, 1.0).into_iter().fold(0.0, |m: f32, d| m.max(d.abs()));
    assert!(largest < 0.006, "{largest}");
    for (tilt, offset) in [(-1.0, 1.0), (1.0, -1.0)] {
        let wrong = differences(tilt, offset).into_iter().filter(|d| d.abs() > 0.1).count();
        assert!(wrong >= 8, "tilt x {tilt}, offset x {offset}: only {wrong} values tell");
    }
}
