//! What one hair leaves in one image: its steps, spread by a Gaussian over a few texels.

use glam::Vec2;

/// Texels of an image that one hair touches, in coordinates of its own: (0, 0) is the texel of the root, nothing is wrapped yet.
#[derive(Default)]
pub(super) struct Stamp {
    steps: Vec<(Vec2, f32)>,
    kernel: [Vec<f32>; 2],
    touched: Vec<f32>,
    /// Lowest column and row.
    pub origin: [i32; 2],
    /// Columns and rows.
    pub size: [usize; 2],
    /// Optical depth, row by row.
    pub depth: Vec<f32>,
}

/// Widest Gaussian, texels.
const WIDEST: f32 = 64.0;

impl Stamp {
    /// Forgets the hair before.
    pub fn clear(&mut self) {
        self.steps.clear();
    }

    /// Adds a step at `at` (texels; a texel's centre lies at half) of an area counted in texels.
    pub fn push(&mut self, at: Vec2, area: f32) {
        self.steps.push((at, area));
    }

    /// Area of all steps, texels.
    pub fn area(&self) -> f32 {
        self.steps.iter().map(|(_, area)| area).sum()
    }

    /// Spreads the steps by a Gaussian of `sigma` texels; each step keeps its area. With `rows`, rows outside 0..rows are not there.
    pub fn spread(&mut self, sigma: Vec2, rows: Option<u32>) {
        let sigma = sigma.clamp(Vec2::splat(0.05), Vec2::splat(WIDEST));
        let reach = (3.0 * sigma).ceil().as_ivec2();
        let (mut low, mut high) = ([i32::MAX; 2], [i32::MIN; 2]);
        for (at, _) in &self.steps {
            let cell = at.floor().as_ivec2();
            for k in 0..2 {
                low[k] = low[k].min(cell[k] - reach[k]);
                high[k] = high[k].max(cell[k] + reach[k]);
            }
        }
        self.depth.clear();
        self.size = [0; 2];
        if self.steps.is_empty() {
            return;
        }
        self.origin = low;
        self.size = [0, 1].map(|k| (high[k] - low[k] + 1) as usize);
        self.depth.resize(self.size[0] * self.size[1], 0.0);
        for (at, area) in &self.steps {
            let cell = at.floor().as_ivec2();
            for k in 0..2 {
                let weights = &mut self.kernel[k];
                weights.clear();
                let scale = -0.5 / (sigma[k] * sigma[k]);
                weights.extend((cell[k] - reach[k]..=cell[k] + reach[k]).map(|i| {
                    let there = k == 0 || rows.is_none_or(|n| i >= 0 && i < n as i32);
                    let d = i as f32 + 0.5 - at[k];
                    if there { (scale * d * d).exp() } else { 0.0 }
                }));
                let sum: f32 = weights.iter().sum();
                if sum > 0.0 {
                    weights.iter_mut().for_each(|w| *w /= sum);
                }
            }
            let [column, row] = [0, 1].map(|k| (cell[k] - reach[k] - low[k]) as usize);
            let [columns, rows] = &self.kernel;
            for (j, wy) in rows.iter().enumerate() {
                let start = (row + j) * self.size[0] + column;
                let line = &mut self.depth[start..start + columns.len()];
                line.iter_mut().zip(columns).for_each(|(d, wx)| *d += area * wy * wx);
            }
        }
    }

    /// How far the steps lie apart, texels: the diagonal of their bounds.
    pub fn extent(&self) -> f32 {
        let start = (Vec2::splat(f32::INFINITY), Vec2::splat(f32::NEG_INFINITY));
        let (low, high) = self.steps.iter().fold(start, |(low, high), (at, _)| (low.min(*at), high.max(*at)));
        if self.steps.is_empty() { 0.0 } else { (high - low).length() }
    }

    /// Raises the depths until the hair, alone, covers its area: where it lies deep over itself, 1 - exp(-tau) covers less.
    /// Hairs at random places then hide as much as Beer and Lambert say, since each hides its own part of what is left.
    pub fn cover(&mut self) {
        self.touched.clear();
        self.touched.extend(self.depth.iter().filter(|d| **d > 0.0));
        let area: f32 = self.touched.iter().sum();
        // Newton's method from below on a concave function: it does not overshoot.
        let mut gain = 1.0f32;
        for _ in 0..24 {
            let (mut covered, mut slope) = (0.0, 0.0);
            for d in &self.touched {
                let through = (-gain * d).exp();
                covered += 1.0 - through;
                slope += d * through;
            }
            let missing = area - covered;
            if missing <= 1e-4 * area || gain >= 64.0 {
                break;
            }
            gain = (gain + missing / slope.max(1e-9)).min(64.0);
        }
        self.depth.iter_mut().for_each(|d| *d *= gain);
    }
}

/// Width of the Gaussian over which a hair of `area` texels, `diameter` texels thick along both axes and `extent` texels long has room
/// to be covered whole; at least half a texel, and as wide as the hair.
pub(super) fn roomy_sigma(diameter: Vec2, extent: f32, area: f32) -> Vec2 {
    let sigma = sigma_of(diameter);
    // A Gaussian of optical depth 12 in its middle covers 6.1 pi sigma²; along a line about 5 sigma.
    let mean = (sigma.x * sigma.y).sqrt();
    let room = 19.2 * mean * mean + 5.0 * mean * extent;
    sigma * (area / room).sqrt().max(1.0)
}

/// Half a texel, widened by the hair: a disc's spread along an axis is a quarter of its diameter.
pub(super) fn sigma_of(diameter: Vec2) -> Vec2 {
    let quarter = 0.25 * diameter;
    (Vec2::splat(0.25) + quarter * quarter).map(f32::sqrt)
}
