//! The origin of a measurement or a figure, and helpers to find its input files and to write its
//! results.

use pelage_core::files::write_atomically;
use pelage_core::{Error, Result};
use pelage_gpu::Gpu;
use serde::{Deserialize, Serialize};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

/// Program, machine, and time of a result.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Provenance {
    /// Version of the program.
    pub version: String,
    /// Commit that the program was built from, or `unknown`.
    pub commit: String,
    /// The arguments of the process.
    pub command: Vec<String>,
    /// UTC, ISO 8601.
    pub date: String,
    /// Adapter name.
    pub adapter: String,
    /// Vulkan, Metal, ...
    pub backend: String,
    /// Cpu, DiscreteGpu, ...
    pub device_type: String,
    /// Driver and its version.
    pub driver: String,
}

impl Provenance {
    /// The provenance of this process, now, on an open device.
    pub fn of(gpu: &Gpu) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: option_env!("PELAGE_COMMIT").unwrap_or("unknown").to_owned(),
            command: std::env::args_os().map(|a| a.to_string_lossy().into_owned()).collect(),
            date: iso_utc(SystemTime::now()),
            adapter: gpu.info.name.clone(),
            backend: format!("{:?}", gpu.info.backend),
            device_type: format!("{:?}", gpu.info.device_type),
            driver: format!("{} {}", gpu.info.driver, gpu.info.driver_info).trim().to_owned(),
        }
    }
}

/// A time as `2016-07-01T12:00:00Z`; times before 1970 count as 1970.
// [Hinnant2021] civil_from_days
pub fn iso_utc(time: SystemTime) -> String {
    let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs());
    let (days, rest) = (seconds / 86_400, seconds % 86_400);
    // Days since 1 March of the year 0, in eras of 400 years: leap days then end a year.
    let z = days + 719_468;
    let era = z / 146_097;
    let day_of_era = z % 146_097;
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let shifted = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * shifted + 2) / 5 + 1;
    let month = if shifted < 10 { shifted + 3 } else { shifted - 9 };
    let year = era * 400 + year_of_era + u64::from(month <= 2);
    format!("{year:04}-{month:02}-{day:02}T{:02}:{:02}:{:02}Z", rest / 3600, rest / 60 % 60, rest % 60)
}

/// Finds a file or folder of the repository (`scenes/...`, `paper_figures/...`) in the working
/// folder or a folder above the program.
///
/// # Errors
/// [`Error::Usage`] with the folders that were searched.
pub fn repository_path(relative: &str) -> Result<PathBuf> {
    let program = std::env::current_exe().unwrap_or_default();
    let above = program.ancestors().skip(1).map(Path::to_owned);
    std::iter::once(PathBuf::from("."))
        .chain(above)
        .map(|folder| if folder == Path::new(".") { PathBuf::from(relative) } else { folder.join(relative) })
        .find(|path| path.exists())
        .ok_or_else(|| {
            Error::Usage(format!(
                "{relative} is neither in the working folder nor in a folder above {}: run pelage in its repository",
                program.display()
            ))
        })
}

/// Whether all faults of an error are missing files that a scene names.
pub(crate) fn only_files_missing(error: &Error) -> bool {
    let missing = |message: &str| message.contains("is not there");
    matches!(error, Error::Scene(faults) if !faults.is_empty() && faults.iter().all(|f| missing(&f.message)))
}

/// Prints to stdout. A closed pipe is not an error.
pub(crate) fn say(text: &str) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::io("stdout", e)),
        _ => Ok(()),
    }
}

/// Writes a text file, whole or not at all.
///
/// # Errors
/// [`Error::Io`].
pub(crate) fn write_text(path: &Path, text: &str) -> Result<()> {
    write_atomically(path, |file| Ok(file.write_all(text.as_bytes())?))
}

/// Writes a value as JSON, whole or not at all.
///
/// # Errors
/// [`Error::Io`].
pub(crate) fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    write_atomically(path, |file| {
        serde_json::to_writer_pretty(&mut *file, value)?;
        Ok(file.write_all(b"\n")?)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn dates() {
        let at = |s| iso_utc(UNIX_EPOCH + Duration::from_secs(s));
        assert_eq!(at(0), "1970-01-01T00:00:00Z");
        assert_eq!(at(951_782_399), "2000-02-28T23:59:59Z");
        assert_eq!(at(951_782_400), "2000-02-29T00:00:00Z");
        assert_eq!(at(1_467_374_405), "2016-07-01T12:00:05Z");
    }
}
