//! Equirectangular environment maps and their conversion to a few directional lights. Light probes
//! become such maps when they are read.
//!
//! Convention: the centre column of the map looks to -Z, columns to the right of it towards +X, the
//! top row to +Y. `environment.rotate` turns the map about +Y, counter-clockwise seen from above
//! (right-handed).

use super::Light;
use super::probe;
use crate::assets::Assets;
use crate::film::tonemap::luminance;
use crate::film::{Film, io};
use crate::scene::{Environment, Projection};
use crate::{Error, Result};
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
    /// The map of an environment; `None` for a uniform sky. Adds what was changed in it, or is odd,
    /// to `notes`.
    ///
    /// # Errors
    /// [`Error::Scene`] if the file is missing, and as [`Panorama::load`].
    pub fn of(environment: &Environment, assets: &Assets, notes: &mut Vec<String>) -> Result<Option<Self>> {
        if environment.map.is_empty() {
            return Ok(None);
        }
        let path = assets.find(&environment.map)?;
        Self::load(&path, &environment.layer, environment.projection, notes).map(Some)
    }

    /// Reads an image file; of an EXR, `layer`, or the default one if that is empty. Light probes
    /// are resampled ([`probe::Probe::panorama`]). Adds what was changed, or is odd, to `notes`.
    ///
    /// # Errors
    /// [`Error::Scene`] if the file is missing, damaged, larger than [`io::MAX_PIXELS`] or holds
    /// values that are not finite; for a light probe that is not square, and for a square image
    /// that looks like a light probe where `projection` does not say what it is; [`Error::Usage`]
    /// for an unknown extension.
    pub fn load(
        path: &Path,
        layer: &str,
        projection: Option<Projection>,
        notes: &mut Vec<String>,
    ) -> Result<Self> {
        let film = io::read_asset(path, layer, notes)?;
        let mut found = Vec::new();
        let map = Self::from_film(&film, projection, &mut found).map_err(|e| Error::fault(path, e))?;
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        notes.extend(found.into_iter().map(|note| format!("environment map {name}: {note}")));
        Ok(map)
    }

    /// A map from `R G B` of a film, and notes of what was changed or is odd. Negative values
    /// (ringing of a resampled map) become 0. Values of a light probe outside its circle do not
    /// count.
    ///
    /// # Errors
    /// A message if a plane is missing or a value is not finite; for light probes as
    /// [`Panorama::load`].
    pub fn from_film(
        film: &Film,
        projection: Option<Projection>,
        notes: &mut Vec<String>,
    ) -> Result<Self, String> {
        let pixels = film.premultiplied().map_err(|e| e.to_string())?;
        let (width, height) = (film.width as usize, film.height as usize);
        let probe = projection.and_then(Projection::probe);
        if let Some(probe) = probe
            && width != height
        {
            return Err(format!(
                "found {width} x {height} pixels, expected a square image because environment.projection is \
                 \"{}\": crop it to the square around the circle",
                probe.name()
            ));
        }
        let counts = |i: usize| probe.is_none() || probe::counts(width, [i % width, i / width]);
        let used = || pixels.iter().enumerate().filter(|(i, _)| counts(*i)).map(|(_, p)| &p[..3]);
        let bad = used().filter(|p| !p.iter().all(|v| v.is_finite())).count();
        if bad > 0 {
            return Err(format!(
                "found {bad} of {} pixels infinite or not a number: save the map with finite values (half float holds up to 65504)",
                pixels.len()
            ));
        }
        let negative = used().filter(|p| p.iter().any(|v| *v < 0.0)).count();
        if negative > 0 {
            notes.push(format!("{negative} of {} pixels have negative values, set to 0", pixels.len()));
        }
        let texels: Vec<_> = pixels.iter().map(|p| [p[0].max(0.0), p[1].max(0.0), p[2].max(0.0)]).collect();
        if let Some(probe) = probe {
            return probe.panorama(width, &texels);
        }
        if projection.is_none() && width == height && probe::looks_like_probe(width, &texels) {
            return Err(format!(
                "found a square image of {width} x {height} pixels that is black outside a circle, which is a light \
                 probe: set environment.projection to \"angular\" or \"mirror_ball\" (or to \"equirectangular\")"
            ));
        }
        if projection.is_none() && width != 2 * height {
            notes.push(format!(
                "found {width} x {height} pixels, taken as an equirectangular map, which is twice as wide as high: \
                 what it shows is stretched. For a light probe set environment.projection to \"angular\" or \
                 \"mirror_ball\"; \"equirectangular\" silences this note"
            ));
        }
        Ok(Self { width, height, texels })
    }

    /// Radiance that comes from `direction` (map space, any length), bilinear between texel
    /// centres; wraps around the horizon, clamps at the poles.
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
        Sphere::of(self).light(&self.whole()).irradiance
    }

    fn whole(&self) -> Region {
        Region { x: [0, self.width], y: [0, self.height] }
    }
}

/// Three degrees, less than the width of hairs' highlights: closer lights would look like one on
/// the fur.
const SMALLEST_ANGLE: f64 = PI / 60.0;

/// A rectangle of texels, ends exclusive.
#[derive(Debug, Clone, Copy)]
struct Region {
    x: [usize; 2],
    y: [usize; 2],
}

/// Sums over the texels of a region, or of several.
#[derive(Debug, Clone, Copy)]
struct Sums {
    /// Luminous energy: luminance times solid angle.
    energy: f64,
    /// Directions, weighted by energy.
    direction: DVec3,
    /// Radiance times solid angle.
    irradiance: DVec3,
}

impl Sums {
    fn direction(&self) -> DVec3 {
        self.direction.normalize_or(DVec3::Y)
    }
}

/// A map with the solid angles of its texels and the sines and cosines of its rows and columns.
struct Sphere<'a> {
    map: &'a Panorama,
    /// Solid angle of a texel, sine and cosine of the polar angle of its centre, by row.
    rows: Vec<[f64; 3]>,
    /// Sine and cosine of the azimuth, by column.
    columns: Vec<[f64; 2]>,
}

impl<'a> Sphere<'a> {
    fn of(map: &'a Panorama) -> Self {
        let row = |y: usize| {
            let (sin, cos) = ((y as f64 + 0.5) / map.height as f64 * PI).sin_cos();
            [map.solid_angle(y), sin, cos]
        };
        let column = |x: usize| {
            let (sin, cos) = (((x as f64 + 0.5) / map.width as f64 - 0.5) * 2.0 * PI).sin_cos();
            [sin, cos]
        };
        Self { map, rows: (0..map.height).map(row).collect(), columns: (0..map.width).map(column).collect() }
    }

    /// Calls `each` with column, row, radiance and luminous energy of the texels of a region.
    fn scan(&self, region: &Region, mut each: impl FnMut(usize, usize, Vec3, f64)) {
        for y in region.y[0]..region.y[1] {
            for x in region.x[0]..region.x[1] {
                let radiance = Vec3::from(self.map.texels[y * self.map.width + x]);
                each(x, y, radiance, f64::from(luminance(radiance)) * self.rows[y][0]);
            }
        }
    }

    fn light(&self, region: &Region) -> Sums {
        let mut sums = Sums { energy: 0.0, direction: DVec3::ZERO, irradiance: DVec3::ZERO };
        self.scan(region, |x, y, radiance, energy| {
            let ([solid_angle, sin, cos], [x_sin, x_cos]) = (self.rows[y], self.columns[x]);
            sums.energy += energy;
            sums.direction += DVec3::new(sin * x_sin, cos, -sin * x_cos) * energy;
            sums.irradiance += radiance.as_dvec3() * solid_angle;
        });
        sums
    }

    /// Angular width (at the centre row) and height, radians.
    fn extent(&self, region: &Region) -> [f64; 2] {
        let Region { x, y } = region;
        let polar = 0.5 * (y[0] + y[1]) as f64 / self.map.height as f64 * PI;
        [
            (x[1] - x[0]) as f64 * 2.0 * PI / self.map.width as f64 * polar.sin(),
            (y[1] - y[0]) as f64 * PI / self.map.height as f64,
        ]
    }

    /// Whether a split gives two lights that may differ.
    fn splittable(&self, region: &Region) -> bool {
        let texels = (region.x[1] - region.x[0]) * (region.y[1] - region.y[0]);
        texels > 1 && self.extent(region).into_iter().any(|e| e > SMALLEST_ANGLE)
    }

    /// Splits across the longer side into halves of about equal energy.
    fn split(&self, region: &Region) -> [Region; 2] {
        let Region { x, y } = *region;
        let [width, height] = self.extent(region);
        let rows = (height > width || x[1] - x[0] < 2) && y[1] - y[0] >= 2;
        let mut sums = vec![0.0; if rows { y[1] - y[0] } else { x[1] - x[0] }];
        self.scan(region, |column, row, _, energy| {
            sums[if rows { row - y[0] } else { column - x[0] }] += energy;
        });
        let half = 0.5 * sums.iter().sum::<f64>();
        let (mut before, mut best, mut cut) = (0.0, f64::INFINITY, 1);
        for (i, sum) in sums[..sums.len() - 1].iter().enumerate() {
            before += sum;
            if (before - half).abs() < best {
                (best, cut) = ((before - half).abs(), i + 1);
            }
        }
        if rows {
            [Region { x, y: [y[0], y[0] + cut] }, Region { x, y: [y[0] + cut, y[1]] }]
        } else {
            [Region { x: [x[0], x[0] + cut], y }, Region { x: [x[0] + cut, x[1]], y }]
        }
    }
}

/// Merges lights that are closer than [`SMALLEST_ANGLE`], starting with the brightest; omits dark
/// ones.
fn merged(regions: &[(Region, Sums)]) -> Vec<Sums> {
    let mut sorted: Vec<&Sums> =
        regions.iter().map(|(_, sums)| sums).filter(|sums| sums.irradiance.max_element() > 0.0).collect();
    sorted.sort_by(|a, b| b.energy.total_cmp(&a.energy));
    let mut result: Vec<Sums> = Vec::new();
    for sums in sorted {
        let direction = sums.direction();
        match result.iter_mut().find(|s| s.direction().dot(direction) > SMALLEST_ANGLE.cos()) {
            Some(near) => {
                near.energy += sums.energy;
                near.direction += sums.direction;
                near.irradiance += sums.irradiance;
            }
            None => result.push(*sums),
        }
    }
    result
}

/// Converts a map to at most `n` directional lights (map space) that have its energy in each
/// channel.
///
/// The region with the most energy is split across its longer side where its energy halves, until
/// there are `n` lights; each is the energy-weighted centroid of its region's directions. Debevec
/// (2005) splits all regions of a level instead, which allows powers of two only. There are fewer
/// lights than `n` where the map has no more to distinguish: a dark region gives none.
// [Debevec2005]
// DEVIATION: [Debevec2005] splits down to the texel and keeps all lights, so that a sun, through
// which every cut goes, takes most of them. Here lights closer than three degrees are one, and the
// others get its share of splits.
pub fn median_cut(panorama: &Panorama, n: u32) -> Vec<Light> {
    if n == 0 {
        return Vec::new();
    }
    let sphere = Sphere::of(panorama);
    let with_sums = |region: Region| (region, sphere.light(&region));
    let mut regions = vec![with_sums(panorama.whole())];
    let mut lights = merged(&regions);
    // At most four times as many regions as lights, a bound on the work where everything is merged.
    while lights.len() < n as usize && regions.len() < 4 * n as usize {
        let brightest = (0..regions.len())
            .filter(|i| regions[*i].1.energy > 0.0 && sphere.splittable(&regions[*i].0))
            .max_by(|a, b| regions[*a].1.energy.total_cmp(&regions[*b].1.energy));
        let Some(i) = brightest else { break };
        let [first, second] = sphere.split(&regions[i].0);
        regions[i] = with_sums(first);
        regions.push(with_sums(second));
        let more = merged(&regions);
        // A split may separate what was merged with others, and so add more than one light.
        if more.len() > n as usize {
            break;
        }
        lights = more;
    }
    let light = |sums: &Sums| Light {
        direction: sums.direction().as_vec3().normalize(),
        irradiance: sums.irradiance.as_vec3(),
        environment: true,
        undercoat: true,
    };
    lights.iter().map(light).collect()
}

/// `n` lights of equal solid angle, spread over the sphere (a Fibonacci spiral), for a sky of the
/// same `radiance` everywhere; together they give 4 pi times the radiance.
// [Swinbank2006]
pub fn uniform_sky(radiance: Vec3, n: u32) -> Vec<Light> {
    let golden_angle = PI * (3.0 - 5f64.sqrt());
    (0..n)
        .map(|i| {
            let y = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(n);
            let (radius, azimuth) = ((1.0 - y * y).max(0.0).sqrt(), golden_angle * f64::from(i));
            // A single light is overhead.
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
