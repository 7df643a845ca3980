//! Light probes: square images of a whole environment in a circle, resampled to equirectangular
//! maps.
//!
//! Convention: the image is what a camera that looks to -Z sees of a mirror ball. Its centre shows
//! what lies at +Z, behind the camera; the right side shows +X and the top +Y. Straight ahead, -Z,
//! is the whole circle. `environment.rotate` turns it like any map.

use super::environment::Panorama;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::PI;

/// How far from the centre of a light probe a direction is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Probe {
    /// In proportion to its angle from the centre's direction.
    Angular,
    /// Where a mirror ball that is photographed from far away reflects it: the sine of half that
    /// angle, so that equal areas are equal solid angles.
    MirrorBall,
}

/// Smallest side of a light probe, texels.
const SMALLEST: usize = 4;

/// Largest height of the equirectangular map that a light probe becomes, texels.
const LARGEST_HEIGHT: usize = 8192;

/// Half the diagonal of a texel: a texel whose centre is further inside the circle lies in it as a
/// whole.
const HALF_DIAGONAL: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Most samples along a side of a texel of the result. Near the rim of the circle, where all places
/// are almost one direction, a texel covers many of the image's.
const MOST_SAMPLES: usize = 16;

impl Probe {
    /// The name in a scene file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Angular => "angular",
            Self::MirrorBall => "mirror_ball",
        }
    }

    /// Place of a direction of unit length in map space: to the right and upwards from the centre,
    /// by the circle's radius.
    // [Debevec1998]
    pub fn place_of(self, direction: DVec3) -> [f64; 2] {
        let across = direction.x.hypot(direction.y);
        // The angle from +Z in a form that is exact near 0 and pi too.
        let angle = across.atan2(direction.z);
        let radius = self.radius(angle);
        if across > 0.0 {
            [direction.x / across * radius, direction.y / across * radius]
        } else {
            [radius, 0.0]
        }
    }

    /// Unit direction of a place in the circle: the inverse of [`Probe::place_of`].
    pub fn direction_of(self, [x, y]: [f64; 2]) -> DVec3 {
        let radius = x.hypot(y);
        if radius == 0.0 {
            return DVec3::Z;
        }
        let angle = match self {
            Self::Angular => PI * radius,
            Self::MirrorBall => 2.0 * radius.min(1.0).asin(),
        };
        let (sin, cos) = angle.sin_cos();
        DVec3::new(x / radius * sin, y / radius * sin, cos)
    }

    fn radius(self, angle: f64) -> f64 {
        match self {
            Self::Angular => angle / PI,
            Self::MirrorBall => (0.5 * angle).sin(),
        }
    }

    /// Texels of a probe with this radius that a step of 1 rad from the centre, or around it,
    /// passes: the larger of the two.
    fn texels_per_radian(self, radius: f64, angle: f64) -> f64 {
        let outwards = match self {
            Self::Angular => 1.0 / PI,
            Self::MirrorBall => 0.5 * (0.5 * angle).cos(),
        };
        radius * outwards.max(self.radius(angle) / angle.sin().max(1e-9))
    }

    /// The probe of `side` x `side` texels (row by row from the top) as an equirectangular map,
    /// twice as wide as high, `side` texels high but at most 8192.
    ///
    /// Texels that do not lie wholly in the circle do not count: they hold some of what is around
    /// the ball. What only they would show, the directions within 4.8 / `side`^0.5 rad (mirror
    /// ball) or 9 / `side` rad of -Z, has the colours that are nearest to it in the circle.
    ///
    /// # Errors
    /// A message for an image of less than 4 x 4 texels.
    pub fn panorama(self, side: usize, texels: &[[f32; 3]]) -> Result<Panorama, String> {
        if side < SMALLEST || texels.len() != side * side {
            return Err(format!("found {side} x {side} pixels, expected a light probe of 4 x 4 or more"));
        }
        let disc = Disc { side, texels };
        let height = side.min(LARGEST_HEIGHT);
        let map = Panorama { width: 2 * height, height, texels: vec![[0.0; 3]; 2 * height * height] };
        let mut texels = map.texels.clone();
        texels.par_chunks_mut(map.width).enumerate().for_each(|(y, row)| {
            for (x, texel) in row.iter_mut().enumerate() {
                *texel = self.mean(&disc, &map, [x, y]).into();
            }
        });
        Ok(Panorama { texels, ..map })
    }

    /// Mean radiance within the texel of `map` in column x and row y.
    fn mean(self, disc: &Disc<'_>, map: &Panorama, [x, y]: [usize; 2]) -> Vec3 {
        let centre = map.direction_of([x as f64 + 0.5, y as f64 + 0.5]);
        let angle = centre.x.hypot(centre.y).atan2(centre.z);
        let density = self.texels_per_radian(0.5 * disc.side as f64, angle) * PI / map.height as f64;
        let n = ((2.0 * density).ceil() as usize).clamp(1, MOST_SAMPLES);
        let step = |i: usize| (i as f64 + 0.5) / n as f64;
        let edge = |y: usize| (y as f64 / map.height as f64 * PI).cos();
        let (top, bottom) = (edge(y), edge(y + 1));
        let mut sum = Vec3::ZERO;
        for row in 0..n {
            // Even in the cosine: samples of equal solid angle.
            let cos = top + (bottom - top) * step(row);
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            for column in 0..n {
                let azimuth = ((x as f64 + step(column)) / map.width as f64 - 0.5) * 2.0 * PI;
                let (s, c) = azimuth.sin_cos();
                sum += disc.at(self.place_of(DVec3::new(sin * s, cos, -sin * c)));
            }
        }
        sum / (n * n) as f32
    }
}

/// Whether a square image looks like a light probe: black outside the circle, but for texels that
/// the circle cuts, and not black within.
pub(super) fn looks_like_probe(side: usize, texels: &[[f32; 3]]) -> bool {
    let half = 0.5 * side as f64;
    let (mut outside, mut lit) = (0, false);
    for (i, texel) in texels.iter().enumerate() {
        let at = |i: usize| i as f64 + 0.5 - half;
        let black = texel.iter().all(|v| *v == 0.0);
        if at(i % side).hypot(at(i / side)) > half + 2.0 {
            if !black {
                return false;
            }
            outside += 1;
        } else {
            lit |= !black;
        }
    }
    outside > 0 && lit
}

/// Whether the texel in column x and row y of a probe of `side` x `side` texels counts.
pub(super) fn counts(side: usize, [x, y]: [usize; 2]) -> bool {
    let half = 0.5 * side as f64;
    (x as f64 + 0.5 - half).hypot(y as f64 + 0.5 - half) <= half - HALF_DIAGONAL
}

/// The image of a probe.
struct Disc<'a> {
    side: usize,
    texels: &'a [[f32; 3]],
}

impl Disc<'_> {
    /// Bilinear between the texels that count, at a place as of [`Probe::place_of`]; near the
    /// circle and beyond, as further inside.
    fn at(&self, [x, y]: [f64; 2]) -> Vec3 {
        let half = 0.5 * self.side as f64;
        // So far inside, the nearest of the four texels always counts.
        let furthest = half - 2.0 * HALF_DIAGONAL;
        let scale = half.min(furthest / x.hypot(y).max(1e-12));
        let (x, y) = (half + x * scale - 0.5, half - y * scale - 0.5);
        let (x0, y0) = (x.floor().max(0.0), y.floor().max(0.0));
        let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let [column, row] = [x0 as usize + dx, y0 as usize + dy];
            if column >= self.side || row >= self.side || !counts(self.side, [column, row]) {
                continue;
            }
            let weight = (1.0 - (x - column as f64).abs()).max(0.0) * (1.0 - (y - row as f64).abs()).max(0.0);
            sum += Vec3::from(self.texels[row * self.side + column]) * weight as f32;
            weights += weight as f32;
        }
        if weights > 0.0 { sum / weights } else { Vec3::ZERO }
    }
}
