//! Hairs as the path tracer takes them.

use glam::{Vec3, Vec4};
use pelage_fur::Layer;
use pelage_fur::strand_curve::color_at;

/// All hairs of one layer, each with `segments + 1` points, one after the other.
#[derive(Debug, Clone)]
pub struct Strands {
    /// The layer.
    pub layer: Layer,
    /// Segments of each strand.
    pub segments: usize,
    /// Position in world space and radius, cm. Root first, strand after strand.
    pub points: Vec<Vec4>,
    /// One for each strand.
    pub hairs: Vec<Hair>,
    /// Opacity at each point of a strand, 0..1: of one strand if it is the same for all, else as
    /// many as there are points; empty where all are opaque.
    pub opacity: Vec<f32>,
    /// Where between root and tip the colour changes from the one to the other, and over what part
    /// of the length, as [`pelage_core::scene::Guard::color_transition`]. That of the undercoat
    /// changes evenly from root to tip.
    pub color_transition: [f32; 2],
    /// The same by hair, where it differs from hair to hair; else empty.
    pub color_transitions: Vec<[f32; 2]>,
}

/// What is constant along a hair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hair {
    /// Colour at the root, linear RGB.
    pub color_root: Vec3,
    /// Colour at the tip, linear RGB.
    pub color_tip: Vec3,
    /// Azimuth of the glints, radians.
    pub glint_angle: f32,
    /// Bit k: whether segment k is present. Undercoat hairs end where the volume's density does.
    pub present: u64,
}

impl Strands {
    /// Opaque strands whose colour changes evenly from root to tip.
    pub fn new(layer: Layer, segments: usize, points: Vec<Vec4>, hairs: Vec<Hair>) -> Self {
        Self {
            layer,
            segments,
            points,
            hairs,
            opacity: Vec::new(),
            color_transition: [0.5, 1.0],
            color_transitions: Vec::new(),
        }
    }

    /// Opacity of hair `i` at its `point`-th point, 0..1.
    pub fn opacity_at(&self, i: usize, point: usize) -> f32 {
        let shared = self.opacity.len() == self.segments + 1;
        let at = if shared { point } else { i * (self.segments + 1) + point };
        self.opacity.get(at).copied().unwrap_or(1.0)
    }

    /// [`Strands::color_transition`] of hair `i`.
    pub fn transition(&self, i: usize) -> [f32; 2] {
        self.color_transitions.get(i).copied().unwrap_or(self.color_transition)
    }

    /// Opaque strands from parts that were grown separately, in their order.
    pub(super) fn joined(layer: Layer, segments: usize, parts: Vec<(Vec<Vec4>, Vec<Hair>)>) -> Self {
        let count = parts.iter().map(|(_, hairs)| hairs.len()).sum();
        let mut points = Vec::with_capacity(count * (segments + 1));
        let mut hairs = Vec::with_capacity(count);
        for (of_points, of_hairs) in parts {
            points.extend(of_points);
            hairs.extend(of_hairs);
        }
        Self::new(layer, segments, points, hairs)
    }

    /// Colour of hair `i` at `s` (0 root, 1 tip), linear RGB in 0..1.
    pub fn color(&self, i: usize, s: f32) -> Vec3 {
        let hair = &self.hairs[i];
        match self.layer {
            Layer::Undercoat => hair.color_root.lerp(hair.color_tip, s).clamp(Vec3::ZERO, Vec3::ONE),
            Layer::Guard => color_at(self.transition(i), [hair.color_root, hair.color_tip], s),
        }
    }
}
