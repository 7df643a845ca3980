//! Writes patches as OBJ.

use super::Lapped;
use pelage_core::files::write_buffered;
use pelage_core::{Result, Skin};
use std::{
    collections::HashMap,
    io::{self, Write},
    path::Path,
};

/// Writes `skin` with the uv of its patches as OBJ, one group per patch; positions and uv in cm. A
/// face is in the group of the patch that it shows; with overlapping patches it is in the groups of
/// all patches that contain it, in the order of pasting. The file appears complete or not at all.
///
/// # Errors
/// [`pelage_core::Error::Io`].
pub fn write_obj(lapped: &Lapped, skin: &Skin, path: &Path) -> Result<()> {
    write_buffered(path, |out| Ok(obj(lapped, skin, out)?))
}

fn obj(lapped: &Lapped, skin: &Skin, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "# pelage {}: lapped patches, cm; uv in cm, not wrapped", env!("CARGO_PKG_VERSION"))?;
    for p in &skin.positions {
        writeln!(out, "v {} {} {}", p.x, p.y, p.z)?;
    }
    for n in &skin.normals {
        writeln!(out, "vn {} {} {}", n.x, n.y, n.z)?;
    }
    let mut last = 0;
    for (number, patch) in lapped.patches.iter().enumerate() {
        writeln!(out, "g patch_{number:05}")?;
        // Within a patch a vertex has one uv.
        let mut numbers: HashMap<u32, usize> = HashMap::new();
        for (f, uv) in patch.faces.iter().zip(&patch.corner_uv) {
            if patch.outline.is_empty() && lapped.topmost[*f as usize] != number as u32 {
                continue;
            }
            let vertices = skin.triangles[*f as usize];
            let mut vt = [0; 3];
            for k in 0..3 {
                let found = *numbers.entry(vertices[k]).or_insert(last + 1);
                if found > last {
                    last = found;
                    writeln!(out, "vt {} {}", uv[k].x, uv[k].y)?;
                }
                vt[k] = found;
            }
            let [a, b, c] = vertices.map(|v| v + 1);
            writeln!(out, "f {a}/{}/{a} {b}/{}/{b} {c}/{}/{c}", vt[0], vt[1], vt[2])?;
        }
    }
    Ok(())
}
