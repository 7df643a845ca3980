//! The camera, in the quantities that other renderers take.

use glam::{Vec2, Vec3};
use pelage_core::Scene;
use pelage_core::scene::{Filter, LensMethod};
use pelage_fur::camera;

/// Camera and film of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Position, cm.
    pub eye: Vec3,
    /// Unit vector to the right in the image.
    pub right: Vec3,
    /// Unit vector upwards in the image.
    pub up: Vec3,
    /// Unit viewing direction.
    pub forward: Vec3,
    /// Tangent of half the vertical field of view.
    pub tan_y: f32,
    /// Vertical field of view, degrees.
    pub fov: f32,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Distance of the near plane, cm.
    pub near: f32,
    /// Diameter of the aperture and focus distance, cm.
    pub lens: Option<[f32; 2]>,
    /// Whether the scene's depth of field is a post-process.
    pub post: bool,
    /// Reconstruction filter and its radius, pixels.
    pub filter: (Filter, f32),
    /// Samples per pixel.
    pub spp: u32,
}

impl View {
    /// The view of `scene`; its axes are those of [`camera::frame`].
    pub fn of(scene: &Scene) -> Self {
        let (camera, film) = (&scene.camera, &scene.film);
        let size = [film.width, film.height];
        let frame = camera::frame(camera, size, Vec2::ZERO, Vec2::ZERO, 0);
        let distance = Vec3::from(camera.eye).distance(camera.target.into());
        let lens = camera.lens.as_ref().filter(|l| l.aperture > 0.0);
        Self {
            eye: frame.eye.into(),
            right: frame.right.into(),
            up: frame.up.into(),
            forward: frame.forward.into(),
            tan_y: frame.tan_y,
            fov: camera.fov,
            size,
            near: camera.near,
            lens: lens.map(|l| [l.aperture, l.focus.unwrap_or(distance).max(1e-3)]),
            post: lens.is_some_and(|l| l.method == LensMethod::Post),
            filter: (
                film.filter,
                film.filter_radius.unwrap_or_else(|| pelage_core::film::filter::usual_radius(film.filter)),
            ),
            spp: film.spp,
        }
    }
}
