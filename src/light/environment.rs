//! Equirectangular environment maps and how they become a few directional lights.
//!
//! Convention: the centre column of the map looks to -Z, columns to the right of it towards +X, the top row to +Y.
//! `environment.rotate` turns the map about +Y, counter-clockwise seen from above (right-handed).

use super::Light;
use crate::{
    Error, Result,
    film::{Film, composite::as_scene_fault, io, tonemap::luminance},
};
use glam::{DVec3, Quat, Vec3};
use std::{f64::consts::PI, path::Path};

/// Rotation of directions from world space to the map, for a map turned by `degrees` about +Y.
pub fn map_from_world(degrees: f32) -> Quat {
    Quat::from_rotation_y(-degrees.to_radians())
}

/// An equirectangular map of radiance, linear RGB.
#[derive(Debug, Clone)]
pub struct Panorama {
    /// Texels around the horizon.
    pub width: usize,
    /// Texels from pole to pole.
    pub height: usize,
    /// Row by row from the top.
    pub texels: Vec<[f32; 3]>,
}

impl Panorama {
    /// Reads an HDR, EXR or PNG file.
    ///
    /// # Errors
    /// [`Error::Scene`] if the file is missing, damaged, larger than [`io::MAX_PIXELS`] or holds values that are not
    /// finite; [`Error::Usage`] for an unknown extension.
    pub fn load(path: &Path) -> Result<Self> {
        let film = io::read(path).map_err(as_scene_fault)?;
        Self::from_film(&film).map_err(|reason| Error::fault(path, reason))
    }

    /// Takes `R G B` of a film. Negative values (ringing of a resampled map) become 0.
    ///
    /// # Errors
    /// A message if a plane is missing or a value is not finite.
    pub fn from_film(film: &Film) -> Result<Self, String> {
        let pixels = film.premultiplied().map_err(|e| e.to_string())?;
        let bad = pixels.iter().filter(|p| !p[..3].iter().all(|v| v.is_finite())).count();
        if bad > 0 {
            return Err(format!(
                "{bad} of {} pixels are infinite or not a number; save the map with finite values (half float holds up to 65504)",
                pixels.len()
            ));
        }
        if film.width != 2 * film.height {
            tracing::warn!(
                "environment map of {} x {}: an equirectangular map is twice as wide as high",
                film.width,
                film.height
            );
        }
        let texels = pixels.iter().map(|p| [p[0].max(0.0), p[1].max(0.0), p[2].max(0.0)]).collect();
        Ok(Self { width: film.width as usize, height: film.height as usize, texels })
    }

    /// Radiance that comes from `direction` (map space, any length), bilinear between texel centres; wraps around
    /// the horizon, clamps at the poles.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let [x, y] = self.texel_of(direction.as_dvec3());
        let (x, y) = (x - 0.5, y - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = ((x - x0) as f32, (y - y0) as f32);
        let at = |dx: i64, dy: i64| {
            let column = (x0 as i64 + dx).rem_euclid(self.width as i64) as usize;
            let row = (y0 as i64 + dy).clamp(0, self.height as i64 - 1) as usize;
            Vec3::from(self.texels[row * self.width + column])
        };
        at(0, 0).lerp(at(1, 0), fx).lerp(at(0, 1).lerp(at(1, 1), fx), fy)
    }

    /// Texel coordinates (0..width, 0..height, centres at .5) of a direction in map space.
    pub fn texel_of(&self, direction: DVec3) -> [f64; 2] {
        let d = direction.normalize_or(DVec3::Y);
        let azimuth = d.x.atan2(-d.z);
        let polar = d.y.clamp(-1.0, 1.0).acos();
        [(0.5 + azimuth / (2.0 * PI)) * self.width as f64, polar / PI * self.height as f64]
    }

    /// Unit direction in map space of texel coordinates: the inverse of [`Panorama::texel_of`].
    pub fn direction_of(&self, [x, y]: [f64; 2]) -> DVec3 {
        let azimuth = (x / self.width as f64 - 0.5) * 2.0 * PI;
        let (sin, cos) = (y / self.height as f64 * PI).sin_cos();
        DVec3::new(sin * azimuth.sin(), cos, -sin * azimuth.cos())
    }

    /// Solid angle of a texel in `row`, sr; all texels together make 4 pi.
    pub fn solid_angle(&self, row: usize) -> f64 {
        let edge = |y: usize| (y as f64 / self.height as f64 * PI).cos();
        2.0 * PI / self.width as f64 * (edge(row) - edge(row + 1))
    }

    /// Radiance integrated over the sphere, linear RGB.
    pub fn total(&self) -> DVec3 {
        self.whole().light(self).1
    }

    fn whole(&self) -> Region {
        Region { x: [0, self.width], y: [0, self.height] }
    }

    /// Luminous energy of a texel: luminance times solid angle.
    fn energy(&self, x: usize, y: usize) -> f64 {
        f64::from(luminance(Vec3::from(self.texels[y * self.width + x]))) * self.solid_angle(y)
    }
}

/// Regions narrower and lower than this are not split (radians; three degrees, less than hairs' highlights are
/// wide): their lights would be one to the fur, while the sun alone would take most of them.
const SMALLEST_SPLIT: f64 = PI / 60.0;

/// A rectangle of texels, ends exclusive.
#[derive(Debug, Clone, Copy)]
struct Region {
    x: [usize; 2],
    y: [usize; 2],
}

impl Region {
    /// Energy-weighted sum of directions, and the integral of radiance.
    fn light(&self, map: &Panorama) -> (DVec3, DVec3) {
        let (mut direction, mut irradiance) = (DVec3::ZERO, DVec3::ZERO);
        for y in self.y[0]..self.y[1] {
            let solid_angle = map.solid_angle(y);
            for x in self.x[0]..self.x[1] {
                let rgb = Vec3::from(map.texels[y * map.width + x]);
                irradiance += rgb.as_dvec3() * solid_angle;
                let center = map.direction_of([x as f64 + 0.5, y as f64 + 0.5]);
                direction += center * (f64::from(luminance(rgb)) * solid_angle);
            }
        }
        (direction, irradiance)
    }

    /// Luminous energy.
    fn energy(&self, map: &Panorama) -> f64 {
        self.sums(map, true).iter().sum()
    }

    /// Energies of its rows, or of its columns.
    fn sums(&self, map: &Panorama, rows: bool) -> Vec<f64> {
        let mut sums = vec![0.0; if rows { self.y[1] - self.y[0] } else { self.x[1] - self.x[0] }];
        for y in self.y[0]..self.y[1] {
            for x in self.x[0]..self.x[1] {
                sums[if rows { y - self.y[0] } else { x - self.x[0] }] += map.energy(x, y);
            }
        }
        sums
    }

    /// Angular width (at the centre row) and height, radians.
    fn extent(&self, map: &Panorama) -> [f64; 2] {
        let polar = 0.5 * (self.y[0] + self.y[1]) as f64 / map.height as f64 * PI;
        [
            (self.x[1] - self.x[0]) as f64 * 2.0 * PI / map.width as f64 * polar.sin(),
            (self.y[1] - self.y[0]) as f64 * PI / map.height as f64,
        ]
    }

    /// Whether a split makes two lights that differ.
    fn splittable(&self, map: &Panorama) -> bool {
        let texels = (self.x[1] - self.x[0]) * (self.y[1] - self.y[0]);
        texels > 1 && self.extent(map).into_iter().any(|e| e > SMALLEST_SPLIT)
    }

    /// Splits across the longer side where the energy halves.
    fn split(&self, map: &Panorama) -> [Self; 2] {
        let [width, height] = self.extent(map);
        let rows = (height > width || self.x[1] - self.x[0] < 2) && self.y[1] - self.y[0] >= 2;
        let sums = self.sums(map, rows);
        let half = 0.5 * sums.iter().sum::<f64>();
        let (mut before, mut best, mut cut) = (0.0, f64::INFINITY, 1);
        for (i, sum) in sums[..sums.len() - 1].iter().enumerate() {
            before += sum;
            if (before - half).abs() < best {
                (best, cut) = ((before - half).abs(), i + 1);
            }
        }
        let (mut first, mut second) = (*self, *self);
        if rows {
            first.y[1] = self.y[0] + cut;
            second.y[0] = first.y[1];
        } else {
            first.x[1] = self.x[0] + cut;
            second.x[0] = first.x[1];
        }
        [first, second]
    }
}

/// Turns a map into at most `n` directional lights (map space) that have its energy in each channel.
///
/// The region with the most energy is split across its longer side where its energy halves, until there are `n`;
/// each region becomes a light at the energy-weighted centroid of its directions. [Debevec2005] splits all regions
/// of a level instead, which allows powers of two only. Regions below three degrees are not split, dark ones give no
/// light: there may be fewer than `n` lights.
///
/// DEVIATION: [Debevec2005] splits down to the texel, so that a sun takes most of the lights.
pub fn median_cut(panorama: &Panorama, n: u32) -> Vec<Light> {
    if n == 0 {
        return Vec::new();
    }
    let whole = panorama.whole();
    let mut regions = vec![(whole, whole.energy(panorama))];
    while regions.len() < n as usize {
        let brightest = (0..regions.len())
            .filter(|i| regions[*i].1 > 0.0 && regions[*i].0.splittable(panorama))
            .max_by(|a, b| regions[*a].1.total_cmp(&regions[*b].1));
        let Some(i) = brightest else { break };
        let [first, second] = regions[i].0.split(panorama);
        regions[i] = (first, first.energy(panorama));
        regions.push((second, second.energy(panorama)));
    }
    let light = |(region, _): &(Region, f64)| {
        let (direction, irradiance) = region.light(panorama);
        let direction = direction.normalize_or(DVec3::Y).as_vec3().normalize();
        Light { direction, irradiance: irradiance.as_vec3(), environment: true, undercoat: true }
    };
    regions.iter().map(light).filter(|l| l.irradiance.max_element() > 0.0).collect()
}

/// `n` lights of equal solid angle, spread over the sphere (a Fibonacci spiral), for a sky of the same `radiance`
/// everywhere; together they give 4 pi times the radiance. // [Swinbank2006]
pub fn uniform_sky(radiance: Vec3, n: u32) -> Vec<Light> {
    let golden_angle = PI * (3.0 - 5f64.sqrt());
    (0..n)
        .map(|i| {
            let y = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(n);
            let (radius, azimuth) = ((1.0 - y * y).max(0.0).sqrt(), golden_angle * f64::from(i));
            // One light alone stands above.
            let direction = if n == 1 {
                Vec3::Y
            } else {
                DVec3::new(radius * azimuth.cos(), y, radius * azimuth.sin()).as_vec3().normalize()
            };
            let irradiance = (radiance.as_dvec3() * (4.0 * PI / f64::from(n))).as_vec3();
            Light { direction, irradiance, environment: true, undercoat: true }
        })
        .collect()
}
