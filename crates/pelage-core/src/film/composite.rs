//! The background behind the fur.

use super::{Film, io, resample};
use crate::assets::Assets;
use crate::light::environment::{Panorama, map_from_world};
use crate::scene::{Background, Camera};
use crate::{Error, Result, Scene};
use glam::{Quat, Vec3};
use rayon::prelude::*;

/// A premultiplied pixel `front` over a premultiplied pixel `back`, both `[r g b a]`. All images
/// are blended by this function.
// [PorterDuff1984] over
pub fn over(front: [f32; 4], back: [f32; 4]) -> [f32; 4] {
    let through = 1.0 - front[3];
    std::array::from_fn(|c| front[c] + through * back[c])
}

/// A background with its files loaded. Load it before rendering, so that a missing file is reported
/// early.
#[derive(Debug, Clone)]
pub enum Backdrop {
    /// None; alpha is kept.
    Transparent,
    /// A colour, linear RGB.
    Color([f32; 3]),
    /// Premultiplied pixels of a plate, and its width and height.
    Plate(Vec<[f32; 4]>, [usize; 2]),
    /// An environment map as the camera sees it.
    Environment {
        /// The map; `None` for a uniform sky.
        panorama: Option<Panorama>,
        /// Rotation of directions from world space to the map.
        map_from_world: Quat,
        /// Factor on the radiance: intensity times tint.
        factor: Vec3,
        /// The camera.
        camera: Camera,
    },
}

impl Backdrop {
    /// Loads the background of `scene.film.background`.
    ///
    /// # Errors
    /// [`Error::Scene`] if a plate or map is missing or damaged, if the background is `environment`
    /// but the scene has none or has `environment.visible = false`, or if the camera has no valid
    /// view.
    pub fn load(scene: &Scene, assets: &Assets) -> Result<Self> {
        match scene.film.background {
            Background::Transparent => Ok(Self::Transparent),
            Background::Color => Ok(Self::Color(scene.film.background_color)),
            // Loading the world has reported the notes.
            Background::Plate => load_plate(scene, assets, &mut Vec::new()),
            Background::Environment => {
                let Some(environment) = &scene.environment else {
                    return Err(Error::fault(
                        "film.background",
                        "found \"environment\" in a scene without [environment]: add one or choose another background",
                    ));
                };
                if !environment.visible {
                    return Err(Error::fault(
                        "environment.visible",
                        "found false, expected true because film.background is \"environment\": set it or choose another background",
                    ));
                }
                view_of(&scene.camera)?;
                Ok(Self::Environment {
                    // Loading the world has reported the notes.
                    panorama: Panorama::of(environment, assets, &mut Vec::new())?,
                    map_from_world: map_from_world(environment.rotate),
                    factor: Vec3::from(environment.tint) * environment.intensity,
                    camera: scene.camera.clone(),
                })
            }
        }
    }

    /// The background as premultiplied pixels of a film of `width` x `height`; `None` if it is
    /// transparent.
    ///
    /// # Errors
    /// [`Error::Scene`] if the camera has no valid view.
    pub fn pixels(&self, width: u32, height: u32) -> Result<Option<Vec<[f32; 4]>>> {
        let (w, h) = (width as usize, height as usize);
        Ok(match self {
            Self::Transparent => None,
            Self::Color([r, g, b]) => Some(vec![[*r, *g, *b, 1.0]; w * h]),
            Self::Plate(pixels, size) => Some(resample::cover(pixels, *size, [w, h])),
            Self::Environment { panorama, map_from_world, factor, camera } => {
                let view = view_of(camera)?;
                let Some(panorama) = panorama else {
                    return Ok(Some(vec![[factor.x, factor.y, factor.z, 1.0]; w * h]));
                };
                // As many lookups along a pixel's side as it covers texels of the map, at most 8.
                let pixel = 2.0 * view.half_height / height as f32;
                let texel = std::f32::consts::PI / panorama.height as f32;
                let n = (pixel / texel).ceil().clamp(1.0, 8.0) as usize;
                let look = |i: usize| {
                    let sum = (0..n * n).fold(Vec3::ZERO, |sum, s| {
                        let at = |i: usize, s: usize| i as f32 + (s as f32 + 0.5) / n as f32;
                        let ray = view.ray([at(i % w, s % n), at(i / w, s / n)], [width, height]);
                        sum + panorama.radiance(*map_from_world * ray)
                    });
                    let radiance = sum / (n * n) as f32 * *factor;
                    [radiance.x, radiance.y, radiance.z, 1.0]
                };
                Some((0..w * h).into_par_iter().map(look).collect())
            }
        })
    }

    /// Composites the film over the background: `R G B A` change, and alpha becomes 1 with an
    /// opaque background.
    ///
    /// If the film has contribution planes (`base.R` ...), planes `background.R G B` are added, so
    /// that they still add up to `R G B`.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if the film lacks a plane, else as [`Backdrop::pixels`].
    pub fn under(&self, film: &mut Film) -> Result<()> {
        let mut pixels = film.premultiplied()?;
        let Some(back) = self.pixels(film.width, film.height)? else {
            return Ok(());
        };
        let layered = film.plane("base.R").is_some() && film.plane("background.R").is_none();
        if layered {
            for (c, name) in ["background.R", "background.G", "background.B"].into_iter().enumerate() {
                let part = |(front, back): (&[f32; 4], &[f32; 4])| (1.0 - front[3]) * back[c];
                film.push(name, false, pixels.iter().zip(&back).map(part).collect());
            }
        }
        pixels.par_iter_mut().zip(&back).for_each(|(front, back)| *front = over(*front, *back));
        film.set_premultiplied(&pixels);
        Ok(())
    }
}

/// Loads the plate of a scene; adds what was changed in it to `notes`.
///
/// # Errors
/// [`Error::Scene`] if it has none, or one that is missing or damaged, or holds values that are not
/// finite.
pub(crate) fn load_plate(scene: &Scene, assets: &Assets, notes: &mut Vec<String>) -> Result<Backdrop> {
    if scene.film.plate.is_empty() {
        return Err(Error::fault(
            "film.plate",
            "found no name, expected an image file because film.background is \"plate\"",
        ));
    }
    let path = assets.find(&scene.film.plate)?;
    let film = io::read_asset(&path, "", notes)?;
    let pixels = film.premultiplied()?;
    if let Some(i) = pixels.iter().position(|p| p.iter().any(|v| !v.is_finite())) {
        let (x, y) = (i % film.width as usize, i / film.width as usize);
        return Err(Error::fault(
            &path,
            format!("found a pixel at {x}, {y} that is not a finite number, expected finite values"),
        ));
    }
    Ok(Backdrop::Plate(pixels, [film.width as usize, film.height as usize]))
}

/// First pixel, and pixel after the last, of the part `crop` (x0 x1 y0 y1 in 0..1) of a film of
/// `size` pixels.
pub fn crop_pixels(size: [u32; 2], [x0, x1, y0, y1]: [f32; 4]) -> [[u32; 2]; 2] {
    let pixel = |x: f32, n: u32| (x.clamp(0.0, 1.0) * n as f32).round() as u32;
    [[pixel(x0, size[0]), pixel(y0, size[1])], [pixel(x1, size[0]), pixel(y1, size[1])]]
}

/// Makes everything outside the part `crop` of a film transparent: `R G B A` and the background's
/// planes are 0 there.
pub fn clear_outside(film: &mut Film, crop: [f32; 4]) {
    let [low, high] = crop_pixels([film.width, film.height], crop);
    let width = film.width as usize;
    let inside = |i: usize| {
        let at = [(i % width) as u32, (i / width) as u32];
        (0..2).all(|k| low[k] <= at[k] && at[k] < high[k])
    };
    let cleared = ["R", "G", "B", "A", "background.R", "background.G", "background.B"];
    for plane in film.planes.iter_mut().filter(|p| cleared.contains(&p.name.as_str())) {
        plane.data.iter_mut().enumerate().filter(|(i, _)| !inside(*i)).for_each(|(_, v)| *v = 0.0);
    }
}

/// [`Backdrop::load`], then [`Backdrop::under`].
///
/// # Errors
/// As these two.
pub fn over_background(film: &mut Film, scene: &Scene, assets: &Assets) -> Result<()> {
    Backdrop::load(scene, assets)?.under(film)
}

/// The camera's axes in world space.
struct View {
    forward: Vec3,
    right: Vec3,
    up: Vec3,
    /// Tangent of half the vertical field of view.
    half_height: f32,
}

impl View {
    /// Direction through a point of the film (pixels from its upper left corner), not normalised.
    fn ray(&self, [x, y]: [f32; 2], [width, height]: [u32; 2]) -> Vec3 {
        let half_width = self.half_height * width as f32 / height as f32;
        self.forward
            + self.right * ((2.0 * x / width as f32 - 1.0) * half_width)
            + self.up * ((1.0 - 2.0 * y / height as f32) * self.half_height)
    }
}

fn view_of(camera: &Camera) -> Result<View> {
    let forward = (Vec3::from(camera.target) - Vec3::from(camera.eye)).try_normalize();
    let right = forward.and_then(|f| f.cross(Vec3::from(camera.up)).try_normalize());
    match (forward, right) {
        (Some(forward), Some(right)) if camera.fov > 0.0 && camera.fov < 180.0 => Ok(View {
            forward,
            right,
            up: right.cross(forward),
            half_height: (camera.fov.to_radians() / 2.0).tan(),
        }),
        _ => Err(Error::fault(
            "camera",
            "found a camera without a valid view, expected eye and target to differ, up not along the view, and fov in 0..180",
        )),
    }
}
