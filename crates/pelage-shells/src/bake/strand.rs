//! Hairs on a torus, as the sources of textures grow them, before they are sampled into layers and
//! fins.

use glam::Vec3;

/// A vertex of a hair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knot {
    /// Offset from the root along u, along v and upwards, cm; not wrapped.
    pub offset: Vec3,
    /// Diameter, cm.
    pub diameter: f32,
    /// Opacity; above 1 if the hair represents several.
    pub opacity: f32,
    /// Linear RGB.
    pub color: Vec3,
}

/// A hair: straight pieces between knots, root first.
#[derive(Debug, Clone, PartialEq)]
pub struct Hair {
    /// Root on the torus, in units of its edges along u and v; wrapped to 0..1.
    pub root: [f32; 2],
    /// Knots, root first.
    pub knots: Vec<Knot>,
    /// Whether it is a guard hair.
    pub guard: bool,
}

/// Hairs that can be grown in any order and repeatedly; hair `i` is always the same.
pub trait HairSource: Sync {
    /// Number of hairs.
    fn count(&self) -> u32;
    /// Grows hair `i` < `count`.
    fn hair(&self, i: u32) -> Hair;
    /// Root of hair `i`.
    fn root(&self, i: u32) -> [f32; 2];
}

impl HairSource for Vec<Hair> {
    fn count(&self) -> u32 {
        self.len() as u32
    }

    fn hair(&self, i: u32) -> Hair {
        self[i as usize].clone()
    }

    fn root(&self, i: u32) -> [f32; 2] {
        self[i as usize].root
    }
}

/// A short piece of a hair.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    /// Midpoint relative to the root, cm.
    pub at: Vec3,
    /// Length, cm.
    pub length: f32,
    /// Length x diameter x opacity, cm².
    pub area: f32,
    /// Linear RGB.
    pub color: Vec3,
}

impl Hair {
    /// Length x diameter x opacity of the whole hair, cm².
    pub fn area(&self) -> f64 {
        self.area_below(f32::INFINITY)
    }

    /// Length x diameter x opacity of the part below a height in cm, cm².
    pub fn area_below(&self, height: f32) -> f64 {
        let mut sum = 0.0;
        // Exact for pieces of any length, except for the taper within a piece.
        for pair in self.knots.windows(2) {
            let [a, b] = [pair[0], pair[1]];
            let (low, high) = (a.offset.z.min(b.offset.z), a.offset.z.max(b.offset.z));
            let part = if high <= height {
                1.0
            } else if low >= height {
                0.0
            } else {
                (height - low) / (high - low)
            };
            sum += f64::from(piece_area(&a, &b) * part);
        }
        sum
    }

    /// Largest diameter, cm.
    pub(super) fn thickest(&self) -> f32 {
        self.knots.iter().map(|k| k.diameter).fold(0.0, f32::max)
    }

    /// Divides the hair into steps no longer than `cell` (cm) along each axis and passes those with
    /// a midpoint from `low` to `high` cm to `step`.
    pub(super) fn steps(&self, cell: Vec3, low: f32, high: f32, mut step: impl FnMut(Step)) {
        for pair in self.knots.windows(2) {
            let [a, b] = [&pair[0], &pair[1]];
            let d = b.offset - a.offset;
            if a.offset.z.max(b.offset.z) < low || a.offset.z.min(b.offset.z) > high {
                continue;
            }
            let n = (d.abs() / cell).max_element().ceil().clamp(1.0, 65536.0) as u32;
            let length = d.length() / n as f32;
            let area = piece_area(a, b) / n as f32;
            for k in 0..n {
                let x = (k as f32 + 0.5) / n as f32;
                let at = a.offset + d * x;
                if at.z < low || at.z > high {
                    continue;
                }
                // Area varies linearly from knot to knot; its sum is that of the whole piece.
                let middle = 0.5 * (a.diameter * a.opacity + b.diameter * b.opacity);
                let here = a.diameter * a.opacity * (1.0 - x) + b.diameter * b.opacity * x;
                let area = if middle > 0.0 { area * here / middle } else { 0.0 };
                step(Step { at, length, area, color: a.color.lerp(b.color, x) });
            }
        }
    }
}

fn piece_area(a: &Knot, b: &Knot) -> f32 {
    (b.offset - a.offset).length() * 0.5 * (a.diameter * a.opacity + b.diameter * b.opacity)
}
