//! The environment, in the forms that other renderers take.

use exr::prelude::{Image, SpecificChannels, WritableImage};
use glam::{DVec3, Vec2, Vec3};
use pelage_core::assets::Assets;
use pelage_core::light::environment::{Panorama, map_from_world};
use pelage_core::scene::Environment;
use pelage_core::{Result, files};
use std::f32::consts::FRAC_PI_4;
use std::path::Path;

/// Radiance from infinitely far away.
#[derive(Debug, Clone)]
pub enum Sky {
    /// The same from everywhere, linear RGB.
    Uniform(Vec3),
    /// An equirectangular map, multiplied by the scene's factors.
    Map {
        /// The map.
        panorama: Panorama,
        /// Its rotation about +y, degrees.
        rotate: f32,
    },
}

impl Sky {
    /// Loads the environment of `spec`.
    ///
    /// # Errors
    /// As [`Panorama::load`].
    pub fn load(spec: &Environment, assets: &Assets) -> Result<Self> {
        let factor = Vec3::from(spec.tint) * spec.intensity;
        // Loading the world has reported the notes.
        let Some(mut panorama) = Panorama::of(spec, assets, &mut Vec::new())? else {
            return Ok(Self::Uniform(factor));
        };
        for texel in &mut panorama.texels {
            *texel = (Vec3::from(*texel) * factor).into();
        }
        Ok(Self::Map { panorama, rotate: spec.rotate })
    }
}

/// Writes linear RGB as EXR with 32-bit floats; `texel` gives column and row from the top.
///
/// # Errors
/// [`pelage_core::Error::Io`] if it cannot be written.
pub(super) fn write_exr(
    path: &Path,
    width: usize,
    height: usize,
    texel: impl Fn(usize, usize) -> Vec3 + Sync,
) -> Result<()> {
    files::write_buffered(path, |out| {
        let channels = SpecificChannels::rgb(|at: exr::math::Vec2<usize>| {
            let c = texel(at.x(), at.y());
            (c.x, c.y, c.z)
        });
        Image::from_channels((width, height), channels).write().to_buffered(out)?;
        Ok(())
    })
}

/// The direction (world space, unit) of a point of pbrt's square environment map: x along columns,
/// y along rows from the top, 0..1.
// [Clarberg2008] sec. 2
pub fn square_to_sphere(p: Vec2) -> Vec3 {
    let q = 2.0 * p - Vec2::ONE;
    let a = q.abs();
    let signed = 1.0 - a.x - a.y;
    let r = 1.0 - signed.abs();
    let phi = if r == 0.0 { FRAC_PI_4 } else { ((a.y - a.x) / r + 1.0) * FRAC_PI_4 };
    let z = (1.0 - r * r).copysign(signed);
    let across = r * (2.0 - r * r).max(0.0).sqrt();
    Vec3::new(phi.cos().copysign(q.x) * across, phi.sin().copysign(q.y) * across, z)
}

/// The panorama, rotated by `rotate` degrees, as pbrt's square map of `side` x `side` texels. Each
/// texel is the mean of 4 x 4 lookups.
pub(super) fn squared(
    panorama: &Panorama,
    rotate: f32,
    side: usize,
) -> impl Fn(usize, usize) -> Vec3 + Sync + '_ {
    let map_from_world = map_from_world(rotate);
    move |column, row| {
        const N: usize = 4;
        let mut sum = DVec3::ZERO;
        for i in 0..N * N {
            let offset = Vec2::new((i % N) as f32 + 0.5, (i / N) as f32 + 0.5) / N as f32;
            let direction = square_to_sphere((Vec2::new(column as f32, row as f32) + offset) / side as f32);
            sum += panorama.radiance(map_from_world * direction).as_dvec3();
        }
        (sum / (N * N) as f64).as_vec3()
    }
}

/// Side of a square map that has about as many texels as the panorama.
pub(super) fn side(panorama: &Panorama) -> usize {
    let texels = (panorama.width * panorama.height) as f64;
    (texels.sqrt().ceil() as usize).clamp(16, 4096)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Equal areas of the square are equal solid angles, and every direction has its place.
    #[test]
    fn the_square_covers_the_sphere_evenly() {
        const N: usize = 400;
        let (mut sum, mut octants) = (DVec3::ZERO, [0_usize; 8]);
        for i in 0..N * N {
            let p = Vec2::new((i % N) as f32 + 0.5, (i / N) as f32 + 0.5) / N as f32;
            let d = square_to_sphere(p);
            assert!((d.length() - 1.0).abs() < 1e-5, "{p} {d}");
            sum += d.as_dvec3() * d.as_dvec3();
            let bit = |x: f32, b: usize| if x > 0.0 { b } else { 0 };
            octants[bit(d.x, 1) | bit(d.y, 2) | bit(d.z, 4)] += 1;
        }
        let mean = sum / (N * N) as f64;
        assert!((mean - DVec3::splat(1.0 / 3.0)).abs().max_element() < 2e-4, "{mean}");
        assert!(octants.iter().all(|n| n.abs_diff(N * N / 8) < 2 * N), "{octants:?}");
        assert!(square_to_sphere(Vec2::splat(0.5)).distance(Vec3::Z) < 1e-6);
    }
}
