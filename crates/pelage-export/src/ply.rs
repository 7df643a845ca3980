//! Surfaces as binary PLY.

use super::{Job, skin_colors};
use glam::Vec3;
use pelage_core::{Result, Skin};
use std::io::{self, Write};

/// Writes the skin and the objects, each to a file of its own: positions, smoothed normals, and
/// linear colours `r g b` if they vary over the vertices.
pub(super) fn write(job: &mut Job<'_>) -> Result<()> {
    let holds = job.skin_holds();
    job.file("skin.ply", holds, |job, out| ply(&job.world.skin, &skin_colors(job.world), out))?;
    for i in 0..job.objects.len() {
        let (name, holds) = (job.objects[i].file(), job.objects[i].holds());
        job.file(&name, holds, |job, out| {
            let of = &job.objects[i];
            ply(&of.object.surface, &of.colors, out)
        })?;
    }
    Ok(())
}

fn ply(skin: &Skin, colors: &[Vec3], out: &mut dyn Write) -> io::Result<()> {
    let colored = colors.len() == skin.positions.len();
    writeln!(out, "ply\nformat binary_little_endian 1.0\ncomment {}", Job::title())?;
    writeln!(out, "element vertex {}", skin.positions.len())?;
    let names: &[&str] = if colored {
        &["x", "y", "z", "nx", "ny", "nz", "r", "g", "b"]
    } else {
        &["x", "y", "z", "nx", "ny", "nz"]
    };
    for name in names {
        writeln!(out, "property float {name}")?;
    }
    writeln!(out, "element face {}", skin.triangles.len())?;
    writeln!(out, "property list uchar int vertex_indices\nend_header")?;
    for (i, (p, n)) in skin.positions.iter().zip(&skin.normals).enumerate() {
        for v in [Some(*p), Some(*n), colored.then(|| colors[i])].into_iter().flatten() {
            v.to_array().into_iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))?;
        }
    }
    for triangle in &skin.triangles {
        out.write_all(&[3])?;
        triangle.iter().try_for_each(|i| out.write_all(&i.to_le_bytes()))?;
    }
    Ok(())
}
