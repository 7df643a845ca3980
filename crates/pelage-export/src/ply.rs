//! Surfaces as binary PLY.

use super::{Job, skin_colors};
use glam::{Vec2, Vec3};
use pelage_core::{Result, Skin};
use std::io::{self, Write};

/// Which way v points in a target's images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum V {
    /// v = 0 is the lower edge.
    Up,
    /// v = 0 is the upper edge.
    Down,
}

/// Writes the skin and the objects, each to a file of its own: positions, smoothed normals, and
/// linear colours `r g b` if they vary over the vertices, or `u v` where a colour is an image.
pub(super) fn write(job: &mut Job<'_>, v: V) -> Result<()> {
    let holds = job.skin_holds();
    job.file("skin.ply", holds, |job, out| ply(&job.world.skin, &skin_colors(job.world), &[], out))?;
    for i in 0..job.objects.len() {
        let (name, holds) = (job.objects[i].file(), job.objects[i].holds());
        job.file(&name, holds, |job, out| {
            let of = &job.objects[i];
            let turned = |uv: &Vec2| if v == V::Up { *uv } else { Vec2::new(uv.x, 1.0 - uv.y) };
            let uv: Vec<Vec2> = of.uv().iter().map(turned).collect();
            ply(&of.surface, of.colors(), &uv, out)
        })?;
    }
    Ok(())
}

fn ply(skin: &Skin, colors: &[Vec3], uv: &[Vec2], out: &mut dyn Write) -> io::Result<()> {
    let colored = colors.len() > 1;
    writeln!(out, "ply\nformat binary_little_endian 1.0\ncomment {}", Job::title())?;
    writeln!(out, "element vertex {}", skin.positions.len())?;
    let more: &[&str] = match (colored, uv.is_empty()) {
        (true, _) => &["r", "g", "b"],
        (false, false) => &["u", "v"],
        (false, true) => &[],
    };
    for name in ["x", "y", "z", "nx", "ny", "nz"].iter().chain(more) {
        writeln!(out, "property float {name}")?;
    }
    writeln!(out, "element face {}", skin.triangles.len())?;
    writeln!(out, "property list uchar int vertex_indices\nend_header")?;
    for (i, (p, n)) in skin.positions.iter().zip(&skin.normals).enumerate() {
        let color = if colored { colors[i].to_array().to_vec() } else { Vec::new() };
        let uv = if colored { None } else { uv.get(i).map(|uv| uv.to_array()) };
        let all = p.to_array().into_iter().chain(n.to_array()).chain(color).chain(uv.into_iter().flatten());
        all.into_iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))?;
    }
    for triangle in &skin.triangles {
        out.write_all(&[3])?;
        triangle.iter().try_for_each(|i| out.write_all(&i.to_le_bytes()))?;
    }
    Ok(())
}
