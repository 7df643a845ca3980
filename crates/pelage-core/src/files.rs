//! Atomic output: files appear complete or not at all.

use crate::{Error, Result};
use std::{
    fs::File,
    io::{BufWriter, Write},
    path::{Path, PathBuf},
    sync::{Mutex, MutexGuard, PoisonError},
};

/// Temporary files that exist now.
static TEMPORARIES: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn temporaries() -> MutexGuard<'static, Vec<PathBuf>> {
    TEMPORARIES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the files that are being written, for a process that is about to end; what they were to
/// replace stays.
pub fn remove_temporaries() {
    for path in temporaries().drain(..) {
        // It may have been renamed just now: then the file is complete.
        let _ = std::fs::remove_file(path);
    }
}

/// A temporary file that [`remove_temporaries`] knows while it exists.
struct Temporary {
    file: tempfile::NamedTempFile,
    _listed: Listed,
}

/// The entry of a temporary file in the list; removed when dropped.
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        temporaries().retain(|path| *path != self.0);
    }
}

/// What an encoder or decoder reports; the caller adds the file.
pub type Failure = Box<dyn std::error::Error + Send + Sync>;

/// Checks before a long computation that `path` can be written after it: the folder exists, the
/// name is not that of a folder, a device or a write-protected file, and the disk has room for a
/// few blocks. Leaves nothing behind.
///
/// # Errors
/// [`Error::Io`] with the file and the reason.
pub fn check_target(path: &Path) -> Result<()> {
    let target = resolved(path)?;
    let Temporary { mut file, _listed } = temporary(&target).map_err(|e| Error::io(path, e))?;
    // A full disk may still take an empty file, but not 64 KiB.
    file.write_all(&[0; 1 << 16])
        .and_then(|()| file.as_file().sync_all())
        .map_err(|e| Error::io(path, format!("cannot be written: {e}")))
}

/// Writes a file through a temporary one in the same folder: `write`, fsync, rename. An old file
/// stays until the new one is complete, and stays for good if anything fails.
///
/// # Errors
/// [`Error::Io`] with the file and the failure.
pub fn write_atomically<F>(path: &Path, write: F) -> Result<()>
where
    F: FnOnce(&mut File) -> Result<(), Failure>,
{
    let target = resolved(path)?;
    let fail = |e: &dyn std::fmt::Display| Error::io(path, format!("cannot be written: {e}"));
    let Temporary { mut file, _listed } = temporary(&target).map_err(|e| fail(&e))?;
    write(file.as_file_mut()).map_err(|e| fail(&e))?;
    file.as_file().sync_all().map_err(|e| fail(&e))?;
    file.persist(&target).map_err(|e| fail(&e.error))?;
    // The rename is durable once the folder is synced.
    #[cfg(unix)]
    if let Ok(folder) = File::open(folder_of(&target)) {
        folder.sync_all().ok();
    }
    Ok(())
}

/// [`write_atomically`] through a buffer, for output in small pieces.
///
/// # Errors
/// As [`write_atomically`].
pub fn write_buffered<F>(path: &Path, write: F) -> Result<()>
where
    F: FnOnce(&mut BufWriter<&mut File>) -> Result<(), Failure>,
{
    write_atomically(path, |file| {
        let mut out = BufWriter::with_capacity(1 << 20, file);
        write(&mut out)?;
        Ok(out.flush()?)
    })
}

/// The file to replace. Links are followed, so that they stay links.
fn resolved(path: &Path) -> Result<PathBuf> {
    let fail = |reason: String| Err(Error::io(path, reason));
    if path.file_name().is_none() {
        return fail("is not a file name, expected FOLDER/NAME".into());
    }
    let Ok(meta) = std::fs::metadata(path) else {
        let folder = folder_of(path);
        if !folder.is_dir() {
            return fail(format!("the folder {} does not exist: create it first", folder.display()));
        }
        return Ok(path.to_owned());
    };
    if meta.is_dir() {
        return fail("is a folder, expected a file name".into());
    }
    if !meta.is_file() {
        return fail("is not a regular file: choose another name, because output is written to a temporary file and renamed".into());
    }
    if meta.permissions().readonly() {
        return fail("is write-protected: remove it, change its permissions or choose another name".into());
    }
    path.canonicalize().map_err(|e| Error::io(path, e))
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// A unique temporary beside `target`, removed when dropped.
fn temporary(target: &Path) -> std::io::Result<Temporary> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pelage-").suffix(".part");
    // By default tempfile makes files private to the user; here the umask decides, as for any other
    // output.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let file = builder.tempfile_in(folder_of(target))?;
    let path = file.path().to_owned();
    temporaries().push(path.clone());
    Ok(Temporary { file, _listed: Listed(path) })
}
