//! HAIR files, one per layer.

use super::{Job, curves};
use glam::Vec3;
use pelage_core::{Error, Result};
use pelage_pathtrace::strands::Strands;
use std::io::{self, Write};

/// Writes one HAIR file per layer, then the skin as OBJ.
pub(super) fn write(job: &mut Job<'_>) -> Result<()> {
    layers(job)?;
    job.obj("skin.obj")
}

/// Writes one HAIR file per layer, `guard.hair` and `undercoat.hair`, with diameters, transparency
/// and colours at each point.
pub(super) fn layers(job: &mut Job<'_>) -> Result<()> {
    for strands in job.strands {
        let name = format!("{}.hair", curves::name(strands.layer));
        let points = curves::Counts::of(strands).points;
        if u32::try_from(points).is_err() {
            return Err(Error::Unsupported(format!(
                "{name}: found {points} points, expected at most {}, the limit of a HAIR file: export a smaller part",
                u32::MAX
            )));
        }
        job.file(&name, curves::holds(strands), |_, out| layer(strands, out))?;
    }
    Ok(())
}

// [YukselHair]
fn layer(strands: &Strands, out: &mut dyn Write) -> io::Result<()> {
    const SEGMENTS_POINTS_THICKNESS_TRANSPARENCY_COLORS: u32 = 31;
    let counts = curves::Counts::of(strands);
    out.write_all(b"HAIR")?;
    let words = [counts.runs as u32, counts.points as u32, SEGMENTS_POINTS_THICKNESS_TRANSPARENCY_COLORS];
    for word in words.into_iter().chain([strands.segments as u32]) {
        out.write_all(&word.to_le_bytes())?;
    }
    let float = |out: &mut dyn Write, x: f32| out.write_all(&x.to_le_bytes());
    // Defaults for missing arrays, of which there are none.
    for x in [0.005, 0.0, 1.0, 1.0, 1.0] {
        float(out, x)?;
    }
    let mut info = [0; 88];
    let text = format!("pelage {}, {}, cm", env!("CARGO_PKG_VERSION"), curves::name(strands.layer));
    info.iter_mut().zip(text.bytes()).for_each(|(to, from)| *to = from);
    out.write_all(&info)?;
    for run in curves::runs(strands) {
        out.write_all(&(run.points.len() as u16 - 1).to_le_bytes())?;
    }
    let vector = |out: &mut dyn Write, v: Vec3| v.to_array().into_iter().try_for_each(|x| float(out, x));
    for p in curves::runs(strands).flat_map(|run| run.points) {
        vector(out, p.truncate())?;
    }
    for p in curves::runs(strands).flat_map(|run| run.points) {
        float(out, 2.0 * p.w)?;
    }
    for run in curves::runs(strands) {
        for k in 0..run.points.len() {
            float(out, 1.0 - strands.opacity_at(run.hair, run.first + k))?;
        }
    }
    for run in curves::runs(strands) {
        for k in 0..run.points.len() {
            vector(out, curves::color(strands, run.hair, (run.first + k) as f32))?;
        }
    }
    Ok(())
}
