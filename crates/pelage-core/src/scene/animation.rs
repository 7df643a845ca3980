//! The table `[animation]`: frames, a turning camera, an object that swings.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What changes from frame to frame. Frames are numbered from 1; frame n shows the time (n - 1) /
/// `fps`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Animation {
    /// Number of frames.
    #[schemars(range(min = 1, max = 100_000))]
    pub frames: u32,
    /// Frame rate, 1/s.
    #[schemars(range(min = 0.1, max = 1000.0))]
    pub fps: f32,
    /// Rotation of the camera about the axis `camera.up` through its target over all frames,
    /// degrees, counter-clockwise seen from above. With 360 the animation loops: the first frame
    /// follows the last.
    #[schemars(range(min = -36_000.0, max = 36_000.0))]
    pub turntable: f32,
    /// How the object moves.
    pub motion: Motion,
}

impl Default for Animation {
    fn default() -> Self {
        Self { frames: 48, fps: 24.0, turntable: 0.0, motion: Motion::default() }
    }
}

/// The object swings: its displacement along `axis` is `amplitude` sin(2π `frequency` t).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Motion {
    /// Amplitude, cm.
    #[schemars(range(min = 0.0, max = 1e4))]
    pub amplitude: f32,
    /// Frequency, 1/s.
    #[schemars(range(min = 0.0, max = 100.0))]
    pub frequency: f32,
    /// Direction, world space; must not be zero.
    pub axis: [f32; 3],
}

impl Default for Motion {
    fn default() -> Self {
        Self { amplitude: 0.0, frequency: 1.0, axis: [0.0, 1.0, 0.0] }
    }
}
