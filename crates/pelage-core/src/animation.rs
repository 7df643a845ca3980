//! Evaluates the scene's `[animation]` at a frame.

use crate::scene::{Animation, Camera, FurLayers, Motion, Scene};
use glam::{Quat, Vec3};
use std::f64::consts::TAU;

/// The scene at a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameState {
    /// Number of the frame, from 1.
    pub frame: u32,
    /// Time since the first frame, s.
    pub time: f64,
    /// The camera, turned, and moved opposite to the object's motion: the object itself stays in
    /// place. All lights are directional, so the image is that of a moving object.
    pub camera: Camera,
}

/// The scene at `frame`, from 1 (0 counts as 1). Frames beyond `animation.frames` continue the
/// motion.
pub fn at(scene: &Scene, frame: u32) -> FrameState {
    let animation = &scene.animation;
    let frame = frame.max(1);
    let step = f64::from(frame - 1);
    let time = step / f64::from(animation.fps);
    let part = step / f64::from(animation.frames.max(1));
    // Whole turns are taken off in double precision.
    let angle = (f64::from(animation.turntable) * part).rem_euclid(360.0).to_radians() as f32;
    let mut camera = scene.camera.clone();
    let target = Vec3::from(camera.target);
    let up = Vec3::from(camera.up).normalize_or(Vec3::Y);
    let turn = Quat::from_axis_angle(up, angle);
    let moved = offset(&animation.motion, time);
    let eye = Vec3::from(camera.eye);
    let turned = if angle == 0.0 { eye } else { target + turn * (eye - target) };
    camera.eye = (turned - moved).into();
    camera.target = (target - moved).into();
    FrameState { frame, time, camera }
}

/// Whether frames differ: the camera turns, the object swings, or the hair of shells waves in
/// gusts.
pub fn moves(scene: &Scene) -> bool {
    let Animation { turntable, motion, .. } = &scene.animation;
    let dynamics = &scene.shells.dynamics;
    let gusts = scene.render.fur == FurLayers::Shells
        && Vec3::from(dynamics.wind).length() * dynamics.gust * dynamics.gust_frequency > 0.0;
    *turntable != 0.0 || motion.amplitude * motion.frequency != 0.0 || gusts
}

/// Displacement of the object at `time` (s) from its place, cm.
pub fn offset(motion: &Motion, time: f64) -> Vec3 {
    let phase = (f64::from(motion.frequency) * time).fract() * TAU;
    Vec3::from(motion.axis).normalize_or_zero() * (f64::from(motion.amplitude) * phase.sin()) as f32
}

/// Acceleration of the object at `time` (s), cm/s².
pub fn acceleration(motion: &Motion, time: f64) -> Vec3 {
    let omega = TAU * f64::from(motion.frequency);
    offset(motion, time) * (-omega * omega) as f32
}
