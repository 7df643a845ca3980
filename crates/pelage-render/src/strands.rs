//! Export of the guard hairs of a scene as they are rendered.

use super::plan::SamplePlan;
use crate::prepare::{Prepared, Strands};
use glam::{Vec2, Vec3};
use half::f16;
use pelage_core::hair::HairFile;
use pelage_core::{Error, Result, World};
use pelage_fur::{camera, groom};
use pelage_gpu::recorder::Timings;

/// Grows the guard hairs of `world` with the passes that render them, and reads them back: points
/// in world space (cm), and at each the diameter (cm) and 1 - opacity.
///
/// # Errors
/// [`Error::Unsupported`] if the scene renders no guard hairs; else as [`crate::open`] and
/// [`Prepared::new`].
pub fn strands(world: &World) -> Result<HairFile> {
    let scene = &world.scene;
    if !groom::has_guard(scene) {
        return Err(Error::Unsupported(format!(
            "the scene renders no guard hairs: render.fur is {}, guard.density at most {}",
            format!("{:?}", scene.render.fur).to_lowercase(),
            groom::guard_density(scene)
        )));
    }
    let gpu = crate::open()?;
    let plan = SamplePlan::new(scene);
    let view = camera::frame(&scene.camera, plan.film, Vec2::ZERO, Vec2::ZERO, scene.render.seed);
    let mut timings = Timings::default();
    let prepared = Prepared::new(&gpu, world, &view, &mut timings)?;
    let mut hair = HairFile::default();
    if let Some(strands) = &prepared.resident {
        append(&mut hair, &prepared, strands)?;
    } else {
        for batch in &prepared.batches {
            let strands = prepared.grow(batch, &mut timings)?;
            append(&mut hair, &prepared, &strands)?;
        }
    }
    Ok(hair)
}

/// Reads strands back and adds them to `hair`.
fn append(hair: &mut HairFile, prepared: &Prepared<'_>, strands: &Strands) -> Result<()> {
    if strands.count == 0 {
        return Ok(());
    }
    let segments = u16::try_from(prepared.segments).map_err(|_| {
        Error::Unsupported(format!("{} segments per strand are too many for a HAIR file", prepared.segments))
    })?;
    let points = u64::from(strands.count) * (u64::from(segments) + 1);
    let buffer = strands.buffer("strand_vertices")?;
    // Packing of shaders/shared/strands.wgsl: position; radius (units of 0.01 cm) and opacity as
    // halves.
    let vertices: Vec<[u32; 4]> = prepared.gpu.read(buffer, points * 16)?;
    hair.segments.extend(std::iter::repeat_n(segments, strands.count as usize));
    for [x, y, z, packed] in vertices {
        let [radius, opacity] = [packed, packed >> 16].map(|half| f16::from_bits(half as u16).to_f32());
        hair.points.push(Vec3::new(f32::from_bits(x), f32::from_bits(y), f32::from_bits(z)));
        hair.thickness.push(2.0 * radius * 0.01);
        hair.transparency.push(1.0 - opacity);
    }
    Ok(())
}
