//! Hair as a damped spring: the bend of the tips by gravity, wind and the motion of the object.
//!
//! b'' = −(k/m) b − (c/m) b' + a, where b is the displacement of the tips in the object's frame
//! (cm) and a the sum of gravity, wind and the negative of the object's acceleration. A client
//! displaces the hair at height h (0..1) by b h³.
// [Xbdev] dynamics

use glam::DVec3;
use pelage_core::animation;
use pelage_core::scene::{Dynamics, Motion};
use std::f64::consts::TAU;

/// Time step relative to the longest stable step and to the period of the forces; the result is
/// within a few hundredths of the exact motion.
const STEP: f64 = 0.01;

/// Beyond this number of steps the spring is so stiff that it is replaced by its equilibrium under
/// the current forces; its oscillation is faster than any frame rate.
const MOST_STEPS: f64 = 4e6;

/// Ratio of the two gust frequencies: the golden ratio, so that they never fall into step.
const GOLDEN: f64 = 1.618_033_988_749_895;

/// State of the spring.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spring {
    /// Displacement of the tips, cm.
    pub bend: DVec3,
    /// Velocity of the tips, cm/s.
    pub velocity: DVec3,
}

impl Spring {
    /// One step of `dt` s by the semi-implicit Euler method under acceleration `a` (cm/s²). The
    /// bend is clamped to `limit` cm; at the limit the outward velocity is removed.
    // [Xbdev] F = -k x, F = m a
    // DEVIATION: damped, and clamped to the length of the hair; the tutorial's spring is undamped
    // and its displacement unlimited.
    pub fn step(&mut self, dynamics: &Dynamics, a: DVec3, dt: f64, limit: f64) {
        let (stiffness, damping) = (f64::from(dynamics.stiffness), f64::from(dynamics.damping));
        // Damping is implicit: it never overshoots, however strong it is.
        self.velocity = (self.velocity + (a - stiffness * self.bend) * dt) / (1.0 + damping * dt);
        self.bend += self.velocity * dt;
        let length = self.bend.length();
        if length > limit {
            let outwards = self.bend / length;
            self.bend = outwards * limit;
            self.velocity -= outwards * self.velocity.dot(outwards).max(0.0);
        }
    }
}

/// Longest step for which [`Spring::step`] is stable for any damping, s: 2/sqrt(k/m).
pub fn longest_stable_step(dynamics: &Dynamics) -> f64 {
    2.0 / f64::from(dynamics.stiffness).sqrt()
}

/// Acceleration that bends the hair at `time` (s), cm/s²: gravity, wind with gusts, and the
/// inertial acceleration in the object's frame.
pub fn driving_acceleration(dynamics: &Dynamics, motion: &Motion, time: f64) -> DVec3 {
    let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let phase = TAU * f64::from(dynamics.gust_frequency) * time;
    // Both sines start at zero: the first frame has the mean wind.
    let gust = 0.5 * (phase.sin() + (GOLDEN * phase).sin());
    vector(dynamics.gravity) + vector(dynamics.wind) * (1.0 + f64::from(dynamics.gust) * gust)
        - animation::acceleration(motion, time).as_dvec3()
}

/// Bend of the tips at `time` (s), cm, world space, at most `limit` cm long. At time 0 the hair is
/// at rest under gravity and the mean wind, which is also the bend of a still image. The result
/// depends on the time alone, not on frames rendered before.
pub fn bend(dynamics: &Dynamics, motion: &Motion, limit: f32, time: f64) -> glam::Vec3 {
    let limit = f64::from(limit.max(0.0));
    let rest = |t: f64| {
        let force = driving_acceleration(dynamics, motion, t) / f64::from(dynamics.stiffness);
        force.clamp_length_max(limit)
    };
    let fastest = f64::from(motion.frequency).max(GOLDEN * f64::from(dynamics.gust_frequency));
    let dt = STEP * longest_stable_step(dynamics).min(1.0 / fastest.max(1e-3));
    let steps = (time.max(0.0) / dt).floor();
    if steps > MOST_STEPS || !steps.is_finite() {
        return rest(time).as_vec3();
    }
    let mut spring = Spring { bend: rest(0.0), velocity: DVec3::ZERO };
    for i in 0..steps as u64 {
        spring.step(dynamics, driving_acceleration(dynamics, motion, i as f64 * dt), dt, limit);
    }
    // The remainder is a step of its own, so that all frames share one grid of steps.
    let reached = steps * dt;
    spring.step(dynamics, driving_acceleration(dynamics, motion, reached), time.max(0.0) - reached, limit);
    spring.bend.as_vec3()
}
