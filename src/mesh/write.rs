//! Writing OBJ, and writing files atomically.

use crate::{Error, Result, Skin};
use glam::{Vec2, Vec3};
use std::collections::HashMap;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Writes `skin` as OBJ with normals, uv where there are any and vertex colours where they are not all white;
/// positions in cm, world space. The file appears whole or not at all.
///
/// Errors: [`Error::Io`].
pub fn write_obj(skin: &Skin, path: &Path) -> Result<()> {
    write_atomically(path, |out| obj(skin, out))
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

/// Writes a file through a temporary one in the same folder: after a crash, a full disk or an error the old file is
/// still there, whole. What is not a plain file (a pipe, `/dev/null`) is written directly.
pub(crate) fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> Result<()> {
    let attempt = || -> io::Result<()> {
        // A link is followed, so that it stays a link.
        let path = &std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        if std::fs::metadata(path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
            let mut out = BufWriter::new(std::fs::OpenOptions::new().write(true).open(path)?);
            write(&mut out)?;
            return out.flush();
        }
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut builder = tempfile::Builder::new();
        builder.prefix(".pelage-").suffix(".tmp");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // As any new file; temporary files are private otherwise.
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let mut temporary = builder.tempfile_in(folder)?;
        let mut out = BufWriter::with_capacity(1 << 20, temporary.as_file_mut());
        write(&mut out)?;
        out.flush()?;
        drop(out);
        temporary.as_file().sync_all()?;
        temporary.persist(path).map_err(|e| e.error)?;
        // The new name reaches the disk with its folder; not every system can do this.
        if let Ok(folder) = std::fs::File::open(folder) {
            folder.sync_all().ok();
        }
        Ok(())
    };
    attempt().map_err(|e| Error::io(path, format!("cannot be written: {e}")))
}
