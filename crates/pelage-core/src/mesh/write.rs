//! Writes OBJ files.

use crate::files::write_buffered;
use crate::{Result, Skin};
use glam::{Vec2, Vec3};
use std::collections::HashMap;
use std::io::{self, Write};
use std::path::Path;

/// Writes `skin` as OBJ with normals, uv where there are any and vertex colours where they are not
/// all white; positions in cm, world space. The file appears complete or not at all.
///
/// # Errors
/// [`crate::Error::Io`] where it cannot be written.
pub fn write_obj(skin: &Skin, path: &Path) -> Result<()> {
    write_buffered(path, |out| Ok(obj(skin, out)?))
}

fn obj(skin: &Skin, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "# pelage {}: skin, cm", env!("CARGO_PKG_VERSION"))?;
    let colored = skin.colors.len() == skin.positions.len() && skin.colors.iter().any(|c| *c != Vec3::ONE);
    for (i, p) in skin.positions.iter().enumerate() {
        write!(out, "v {} {} {}", p.x, p.y, p.z)?;
        if colored {
            let c = skin.colors[i];
            write!(out, " {} {} {}", c.x, c.y, c.z)?;
        }
        writeln!(out)?;
    }
    for n in &skin.normals {
        writeln!(out, "vn {} {} {}", n.x, n.y, n.z)?;
    }
    // Corners that agree share a vt.
    let mut numbers: HashMap<[u32; 2], usize> = HashMap::new();
    let mut number = |uv: Vec2, out: &mut dyn Write| -> io::Result<usize> {
        let next = numbers.len() + 1;
        let found = *numbers.entry(uv.to_array().map(f32::to_bits)).or_insert(next);
        if found == next {
            writeln!(out, "vt {} {}", uv.x, uv.y)?;
        }
        Ok(found)
    };
    for (t, corners) in skin.triangles.iter().enumerate() {
        let mut vt = [0; 3];
        if let Some(uv) = &skin.corner_uv {
            for k in 0..3 {
                vt[k] = number(uv[t][k], out)?;
            }
        }
        write!(out, "f")?;
        for k in 0..3 {
            let v = corners[k] + 1;
            match vt[k] {
                0 => write!(out, " {v}//{v}")?,
                vt => write!(out, " {v}/{vt}/{v}")?,
            }
        }
        writeln!(out)?;
    }
    Ok(())
}
