//! Files and text that leave the program.

use crate::{Error, Result};
use std::{io::Write, path::Path};

/// Prints to stdout. A reader that has gone away (`pelage schema | head`) is no error.
pub(super) fn print(text: &str) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::io("stdout", e)),
        _ => Ok(()),
    }
}

/// Prints a JSON value to stdout.
pub(super) fn print_json(value: &serde_json::Value) -> Result<()> {
    print(&format!("{value:#}\n"))
}

/// Finds out, before any work is done, whether `path` can be written: its folder takes a new file, and a file of that
/// name that is already there may be replaced.
pub(super) fn test_writable(path: &Path) -> Result<()> {
    let folder = folder_of(path);
    match std::fs::metadata(folder) {
        Err(e) => {
            let reason = format!("cannot write: the folder {}: {e}; create it first", folder.display());
            return Err(Error::io(path, reason));
        }
        Ok(m) if !m.is_dir() => {
            return Err(Error::io(path, format!("cannot write: {} is no folder", folder.display())));
        }
        Ok(_) => {}
    }
    match std::fs::metadata(path) {
        Ok(m) if m.is_dir() => return Err(Error::io(path, "cannot write: there is a folder of that name")),
        Ok(m) if m.permissions().readonly() => {
            return Err(Error::io(
                path,
                "cannot write: the file is there and read-only; it was left as it is",
            ));
        }
        _ => {}
    }
    temporary(folder).map(drop).map_err(|e| {
        Error::io(path, format!("cannot write into the folder {}: {e}; choose another", folder.display()))
    })
}

/// Writes a small file whole or not at all.
pub(super) fn write_file(path: &Path, content: &[u8]) -> Result<()> {
    let save = || -> std::io::Result<()> {
        let mut file = temporary(folder_of(path))?;
        file.write_all(content)?;
        file.as_file().sync_all()?;
        file.persist(path).map_err(|e| e.error)?;
        Ok(())
    };
    save().map_err(|e| Error::io(path, format!("cannot write: {e}")))
}

/// A temporary file with the usual permissions of new files, not the private ones of temporary files.
fn temporary(folder: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pelage-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// The extension in lower case: empty where there is none.
pub(super) fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Bytes in the unit that reads best.
pub(super) fn human_bytes(bytes: u64) -> String {
    let units = [("GiB", 30), ("MiB", 20), ("KiB", 10)];
    match units.iter().find(|(_, shift)| bytes >= 1 << shift) {
        Some((unit, shift)) => format!("{:.1} {unit}", bytes as f64 / (1_u64 << shift) as f64),
        None => format!("{bytes} B"),
    }
}

/// A count with commas.
pub(super) fn count(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(c);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_have_commas() {
        assert_eq!(count(0), "0");
        assert_eq!(count(999), "999");
        assert_eq!(count(82_432), "82,432");
        assert_eq!(count(1_234_567), "1,234,567");
    }
}
