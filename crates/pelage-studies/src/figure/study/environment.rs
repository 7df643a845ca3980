//! Fur composited into a plate of the environment that lights it; the environment in a mirror ball;
//! and its map with the directional lights that replace it.

use super::super::{FigureContent, FigureContext};
use crate::report::Table;
use glam::{Quat, Vec3};
use pelage_core::assets::Assets;
use pelage_core::film::composite::Backdrop;
use pelage_core::film::{Film, Metadata, io, tonemap};
use pelage_core::light::Light;
use pelage_core::light::environment::{Panorama, map_from_world};
use pelage_core::scene::FilmSpec;
use pelage_core::{Error, Result, World};
use serde::Deserialize;

/// File name of the plate.
const PLATE: &str = "plate.exr";
/// Radius of the ball by the picture's shorter side.
const BALL: f32 = 0.46;
/// Samples along a pixel's side.
const SAMPLES: usize = 3;
/// Colour beside the ball and around a map that has another shape than the panel, display-linear.
const GREY: Vec3 = Vec3::splat(0.12);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// Scene file, relative to the figure's folder; its background is its environment map.
    scene: String,
    /// Blur of the plate, which is out of focus: standard deviation by the picture's height.
    blur: f32,
}

/// An environment map with the scene's rotation and intensity.
struct Sky {
    map: Panorama,
    map_from_world: Quat,
    factor: Vec3,
    film: FilmSpec,
}

pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let settings: Settings = context.settings()?;
    let (world, assets) = context.load(&settings.scene, &[])?;
    let expected = || Error::fault(context.folder.join(&settings.scene), "expected a map in [environment]");
    let environment = world.scene.environment.as_ref().ok_or_else(expected)?;
    let sky = Sky {
        map: Panorama::of(environment, &assets, &mut Vec::new())?.ok_or_else(expected)?,
        map_from_world: map_from_world(environment.rotate),
        factor: Vec3::from(environment.tint) * environment.intensity,
        film: world.scene.film.clone(),
    };
    let lights: Vec<Light> = world.lights.iter().filter(|light| light.environment).copied().collect();
    let [width, height] = context.size();
    let mut content = FigureContent::default();
    let plate = plate(context, &world, &assets, settings.blur)?;
    let (composed, assets) = context.load(&settings.scene, &["film.background=plate".into(), plate])?;
    content.images.push(context.render_panel("in the plate", &composed, &assets)?);
    content.files.push((PLATE.into(), "The plate, linear light".into()));
    content.picture("mirror ball", sky.ball(width, height));
    content.picture(&format!("map with its {} lights", lights.len()), sky.marked(&lights, width, height));
    content.table(&table(&lights, &sky));
    content.value("lights", lights.len() as f64, 0.0);
    let sum: Vec3 = lights.iter().map(|light| light.irradiance).sum();
    let whole = sky.map.total().as_vec3() * sky.factor;
    let kept = tonemap::luminance(sum) / tonemap::luminance(whole);
    content.value("luminous energy of the lights by that of the map", f64::from(kept), 1e-3);
    Ok(content)
}

/// Writes the camera's view of the map, blurred; returns the override that names the file.
fn plate(context: &FigureContext, world: &World, assets: &Assets, blur: f32) -> Result<String> {
    let [width, height] = context.size();
    let pixels = Backdrop::load(&world.scene, assets)?.pixels(width, height)?.unwrap_or_default();
    let pixels = blurred(&pixels, width as usize, blur * height as f32);
    let film = Film::from_premultiplied(width, height, &pixels);
    let path = context.out.join(PLATE);
    io::write(&film, &path, &Metadata::of_program(), &FilmSpec::default())?;
    // Relative paths would be searched for from the scene's folder.
    let path = path.canonicalize().map_err(|e| Error::io(&path, e))?;
    Ok(format!("film.plate={:?}", path.display().to_string()))
}

/// A Gaussian blur of standard deviation `sigma` pixels along rows, then along columns; border
/// pixels are extended.
fn blurred(pixels: &[[f32; 4]], width: usize, sigma: f32) -> Vec<[f32; 4]> {
    let reach = (3.0 * sigma).ceil() as isize;
    let weights: Vec<f32> = (-reach..=reach).map(|k| (-0.5 * (k as f32 / sigma).powi(2)).exp()).collect();
    let sum: f32 = weights.iter().sum();
    if reach == 0 || pixels.is_empty() {
        return pixels.to_vec();
    }
    let height = pixels.len() / width;
    let along = |from: &[[f32; 4]], [dx, dy]: [isize; 2]| -> Vec<[f32; 4]> {
        let at = |i: usize, k: isize| {
            let x = ((i % width) as isize + k * dx).clamp(0, width as isize - 1) as usize;
            let y = ((i / width) as isize + k * dy).clamp(0, height as isize - 1) as usize;
            from[y * width + x]
        };
        let mean = |i: usize| {
            weights.iter().zip(-reach..=reach).fold([0.0f32; 4], |mean, (weight, k)| {
                let pixel = at(i, k);
                std::array::from_fn(|c| mean[c] + weight / sum * pixel[c])
            })
        };
        (0..from.len()).map(mean).collect()
    };
    along(&along(pixels, [1, 0]), [0, 1])
}

fn table(lights: &[Light], sky: &Sky) -> Table {
    let energy = |light: &Light| tonemap::luminance(light.irradiance);
    let all: f32 = lights.iter().map(energy).sum();
    let mut sorted: Vec<&Light> = lights.iter().collect();
    sorted.sort_by(|a, b| energy(b).total_cmp(&energy(a)));
    let row = |(i, light): (usize, &&Light)| {
        let d = light.direction;
        let [x, y] = sky.texel_of(d);
        let [r, g, b] = light.irradiance.to_array();
        vec![
            (i + 1).to_string(),
            format!("{:.0}", d.x.atan2(-d.z).to_degrees()),
            format!("{:.0}", d.y.clamp(-1.0, 1.0).asin().to_degrees()),
            format!("{x:.0}, {y:.0}"),
            format!("{r:.2}, {g:.2}, {b:.2}"),
            format!("{:.1} %", 100.0 * energy(light) / all),
        ]
    };
    let caption = "The lights, the brightest first. Azimuth from -z towards +x, elevation above the horizon, degrees; place in \
         the map's texels; irradiance across the light's direction.";
    let head = ["", "azimuth", "elevation", "texel", "irradiance (R, G, B)", "of all light"];
    Table::new(caption, &head, sorted.iter().enumerate().map(row).collect())
}

impl Sky {
    fn radiance(&self, direction: Vec3) -> Vec3 {
        self.map.radiance(self.map_from_world * direction) * self.factor
    }

    fn texel_of(&self, direction: Vec3) -> [f64; 2] {
        self.map.texel_of((self.map_from_world * direction).as_dvec3())
    }

    /// Tone-maps radiance with the scene's film settings; display-linear.
    fn shown(&self, light: Vec3) -> Vec3 {
        let codes = tonemap::display_rgb8(light, &self.film);
        Vec3::from(codes.map(|code| tonemap::srgb_decode(f32::from(code) / 255.0)))
    }

    /// A mirror ball, seen along -z from far away.
    fn ball(&self, width: u32, height: u32) -> Film {
        let radius = BALL * width.min(height) as f32;
        let centre = [0.5 * width as f32, 0.5 * height as f32];
        picture(width, height, |x, y| {
            let [dx, dy] = [(x - centre[0]) / radius, (centre[1] - y) / radius];
            let square = dx * dx + dy * dy;
            if square >= 1.0 {
                return GREY;
            }
            let normal = Vec3::new(dx, dy, (1.0 - square).sqrt());
            let seen = Vec3::NEG_Z;
            self.shown(self.radiance(seen - 2.0 * seen.dot(normal) * normal))
        })
    }

    /// The whole map with a disc of the light's hue at each light; brighter lights have larger
    /// discs.
    fn marked(&self, lights: &[Light], width: u32, height: u32) -> Film {
        let map = [self.map.width as f32, self.map.height as f32];
        let scale = (width as f32 / map[0]).min(height as f32 / map[1]);
        let corner = [0.5 * (width as f32 - scale * map[0]), 0.5 * (height as f32 - scale * map[1])];
        let brightest = lights.iter().map(|l| l.irradiance.max_element()).fold(0.0, f32::max);
        let discs: Vec<([f32; 2], f32, Vec3)> = lights
            .iter()
            .map(|light| {
                let [x, y] = self.texel_of(light.direction).map(|v| v as f32);
                let largest = light.irradiance.max_element();
                // Lights differ by a factor of a thousand; the fourth root keeps the weakest
                // visible.
                let radius = 0.045 * height as f32 * (largest / brightest).sqrt().sqrt().max(0.5);
                ([corner[0] + scale * x, corner[1] + scale * y], radius, light.irradiance / largest)
            })
            .collect();
        let ring = (0.006 * height as f32).max(1.0);
        picture(width, height, |x, y| {
            for (centre, radius, hue) in &discs {
                let distance = (x - centre[0]).hypot(y - centre[1]);
                match distance - radius {
                    d if d < -ring => return *hue,
                    // A black and a white ring: one of them contrasts with any map.
                    d if d < 0.0 => return Vec3::ZERO,
                    d if d < ring => return Vec3::ONE,
                    _ => {}
                }
            }
            let [u, v] = [(x - corner[0]) / scale, (y - corner[1]) / scale];
            if !(0.0..map[0]).contains(&u) || !(0.0..map[1]).contains(&v) {
                return GREY;
            }
            let direction = self.map.direction_of([u, v].map(f64::from)).as_vec3();
            self.shown(self.map.radiance(direction) * self.factor)
        })
    }
}

/// A picture of the mean of several samples a pixel; `color` takes pixel coordinates from the upper
/// left corner.
fn picture(width: u32, height: u32, color: impl Fn(f32, f32) -> Vec3) -> Film {
    let at = |pixel: u32, k: usize| pixel as f32 + (k as f32 + 0.5) / SAMPLES as f32;
    let pixels: Vec<[f32; 4]> = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| {
            let all = (0..SAMPLES * SAMPLES).map(|k| color(at(x, k % SAMPLES), at(y, k / SAMPLES)));
            let [r, g, b] = (all.sum::<Vec3>() / (SAMPLES * SAMPLES) as f32).to_array();
            [r, g, b, 1.0]
        })
        .collect();
    Film::from_premultiplied(width, height, &pixels)
}

#[cfg(test)]
mod tests {
    use super::*;
    use pelage_core::scene::Tonemap;

    /// A black map with one lit texel.
    fn sky(x: usize, y: usize) -> Sky {
        let mut map = Panorama { width: 64, height: 32, texels: vec![[0.0; 3]; 64 * 32] };
        map.texels[y * 64 + x] = [0.0, 1.0, 0.0];
        let film = FilmSpec { tonemap: Tonemap::None, ..FilmSpec::default() };
        Sky { map, map_from_world: Quat::IDENTITY, factor: Vec3::ONE, film }
    }

    fn brightest(film: &Film) -> [usize; 2] {
        let green = film.plane("G").unwrap();
        let red = film.plane("R").unwrap();
        let lit = |i: usize| green[i] - red[i];
        let i = (0..green.len()).max_by(|a, b| lit(*a).total_cmp(&lit(*b))).unwrap();
        [i % film.width as usize, i / film.width as usize]
    }

    #[test]
    fn a_light_is_marked_where_the_map_is_bright() {
        let sky = sky(48, 8);
        let direction = sky.map.direction_of([48.5, 8.5]).as_vec3();
        let light =
            Light { direction, irradiance: Vec3::new(0.0, 2.0, 0.0), environment: true, undercoat: true };
        let unmarked = brightest(&sky.marked(&[], 128, 64));
        assert!(unmarked[0].abs_diff(97) <= 1 && unmarked[1].abs_diff(17) <= 1, "{unmarked:?}");
        let film = sky.marked(&[light], 128, 64);
        let at = unmarked[1] * 128 + unmarked[0];
        assert!((film.plane("G").unwrap()[at] - 1.0).abs() < 1e-3);
        assert!(film.plane("R").unwrap().iter().any(|red| *red > 0.5), "a white ring");
    }

    #[test]
    fn a_blur_keeps_light_and_spreads_it() {
        let mut pixels = vec![[0.0; 4]; 21 * 21];
        pixels[10 * 21 + 10] = [1.0; 4];
        let wide = blurred(&pixels, 21, 2.0);
        let sum: f32 = wide.iter().map(|p| p[0]).sum();
        let spread: f32 = wide.iter().enumerate().map(|(i, p)| p[1] * ((i % 21) as f32 - 10.0).powi(2)).sum();
        assert!((sum - 1.0).abs() < 1e-3 && (spread - 4.0).abs() < 0.2, "{sum} {spread}");
        assert_eq!(blurred(&pixels, 21, 0.0), pixels);
        let even = vec![[0.5; 4]; 12];
        assert!(blurred(&even, 4, 1.5).iter().all(|p| (p[2] - 0.5).abs() < 1e-6), "the border is extended");
    }

    #[test]
    fn the_centre_of_a_ball_reflects_what_is_behind_the_camera() {
        // The first column is the direction +z.
        let middle = brightest(&sky(0, 15).ball(64, 64));
        assert!(middle[0].abs_diff(32) <= 2 && middle[1].abs_diff(32) <= 2, "{middle:?}");
        // +x is right of the centre, up is above it.
        let right = brightest(&sky(48, 8).ball(64, 64));
        assert!(right[0] > 40 && right[1] < 30, "{right:?}");
    }
}
