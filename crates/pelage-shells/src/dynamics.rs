//! Hair as a damped spring: how far the tips are bent by gravity, wind and the motion of the object.
//!
//! b'' = -(k/m) b - (c/m) b' + a, where b is the displacement of the tips in the object's frame (cm) and a the sum of gravity, wind and
//! minus the object's acceleration. A client bends the hair at height h (0..1) by b h³.
// [Xbdev] dynamics

use glam::DVec3;
use pelage_core::animation;
use pelage_core::scene::{Dynamics, Motion};
use std::f64::consts::TAU;

/// Part of the longest stable step, and of a period of the forces, that is taken: within some hundredths of the exact motion.
const STEP: f64 = 0.01;

/// A spring so stiff that it would need more steps than this follows the forces at once: it swings faster than any frame shows.
const MOST_STEPS: f64 = 4e6;

/// Gusts at the golden ratio of the first frequency never fall in step with it.
const GOLDEN: f64 = 1.618_033_988_749_895;

/// The bend of the tips and how fast it changes.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spring {
    /// cm.
    pub bend: DVec3,
    /// cm/s.
    pub velocity: DVec3,
}

impl Spring {
    /// One step of semi-implicit Euler over `dt` s under the acceleration `a` (cm/s²); the bend is kept within `limit` cm, where it loses
    /// its speed outwards.
    // [Xbdev] F = -k x, F = m a
    // DEVIATION: damped, and clamped at the length of the hair; the tutorial's spring swings for ever and as far as it likes.
    pub fn step(&mut self, dynamics: &Dynamics, a: DVec3, dt: f64, limit: f64) {
        let (stiffness, damping) = (f64::from(dynamics.stiffness), f64::from(dynamics.damping));
        // The damping is implicit: it never overshoots, however strong it is.
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

/// The step below which [`Spring::step`] does not grow without bound, whatever the damping, s: 2/sqrt(k/m).
pub fn longest_stable_step(dynamics: &Dynamics) -> f64 {
    2.0 / f64::from(dynamics.stiffness).sqrt()
}

/// The acceleration that bends hairs at `time` (s), cm/s²: gravity, wind with its gusts, and what the object's motion adds in its own frame.
pub fn driving_acceleration(dynamics: &Dynamics, motion: &Motion, time: f64) -> DVec3 {
    let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let phase = TAU * f64::from(dynamics.gust_frequency) * time;
    // Both sines start at zero: the first frame has the mean wind.
    let gust = 0.5 * (phase.sin() + (GOLDEN * phase).sin());
    vector(dynamics.gravity) + vector(dynamics.wind) * (1.0 + f64::from(dynamics.gust) * gust)
        - animation::acceleration(motion, time).as_dvec3()
}

/// The bend of the tips at `time` (s), cm, world space, at most `limit` cm long. At time 0 the hair rests under gravity and the mean wind, so
/// that a still has the bend of time 0. The same time gives the same bend, whatever frames were rendered before.
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
    // What is left of the time, so that steps lie on one grid for all frames.
    let reached = steps * dt;
    spring.step(dynamics, driving_acceleration(dynamics, motion, reached), time.max(0.0) - reached, limit);
    spring.bend.as_vec3()
}
