//! The footprint of one hair in one image: its steps, spread by a Gaussian over a few texels.

use glam::Vec2;

/// The texels that a hair touches, in its own coordinates: (0, 0) is the texel of the root, and
/// nothing is wrapped yet.
#[derive(Default)]
pub(super) struct Stamp {
    steps: Vec<(Vec2, f32)>,
    kernel: [Vec<f32>; 2],
    touched: Vec<f32>,
    /// Lowest `[column, row]`.
    pub origin: [i32; 2],
    /// Number of `[columns, rows]`.
    pub size: [usize; 2],
    /// Optical depths, row by row.
    pub depth: Vec<f32>,
}

/// Largest standard deviation of the Gaussian, texels.
const WIDEST: f32 = 64.0;

impl Stamp {
    /// Removes all steps.
    pub fn clear(&mut self) {
        self.steps.clear();
    }

    /// Adds a step at `at` (texels; texel centres are at half-integers) with an area in texels.
    pub fn push(&mut self, at: Vec2, area: f32) {
        self.steps.push((at, area));
    }

    /// Total area of the steps, texels.
    pub fn area(&self) -> f32 {
        self.steps.iter().map(|(_, area)| area).sum()
    }

    /// Spreads the steps by a Gaussian of standard deviation `sigma` texels; each step keeps its
    /// area. With `rows`, the Gaussian is confined to rows 0..rows.
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

    /// Extent of the steps, texels: the diagonal of their bounding box.
    pub fn extent(&self) -> f32 {
        let start = (Vec2::splat(f32::INFINITY), Vec2::splat(f32::NEG_INFINITY));
        let (low, high) = self.steps.iter().fold(start, |(low, high), (at, _)| (low.min(*at), high.max(*at)));
        if self.steps.is_empty() { 0.0 } else { (high - low).length() }
    }

    /// Scales the depths until the hair alone covers its area; where it overlaps itself, 1 −
    /// exp(−τ) covers less. Hairs at random places then attenuate light according to the
    /// Beer–Lambert law, because each covers its fraction of what is left.
    pub fn cover(&mut self) {
        self.touched.clear();
        self.touched.extend(self.depth.iter().filter(|d| **d > 0.0));
        let area: f32 = self.touched.iter().sum();
        // Newton's method from below on a concave function does not overshoot.
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

/// Standard deviation of the Gaussian with which a hair of `area` texels, `diameter` texels thick
/// along both axes and `extent` texels long, can cover its whole area; at least [`sigma_of`] the
/// diameter.
pub(super) fn roomy_sigma(diameter: Vec2, extent: f32, area: f32) -> Vec2 {
    let sigma = sigma_of(diameter);
    // A Gaussian with a peak optical depth of 12 covers 6.1 π σ²; along a line it covers a width of
    // about 5 σ.
    let mean = (sigma.x * sigma.y).sqrt();
    let room = 19.2 * mean * mean + 5.0 * mean * extent;
    sigma * (area / room).sqrt().max(1.0)
}

/// Standard deviation of half a texel, widened by the hair: a disc has a standard deviation of a
/// quarter of its diameter along an axis.
pub(super) fn sigma_of(diameter: Vec2) -> Vec2 {
    let quarter = 0.25 * diameter;
    (Vec2::splat(0.25) + quarter * quarter).map(f32::sqrt)
}
