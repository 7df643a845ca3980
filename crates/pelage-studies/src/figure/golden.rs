//! Small versions of the figures, kept in the repository so that a change which alters one is
//! noticed.

use super::content::{Drawing, Record, Value, as_shown};
use super::result_folder;
use crate::compare::compare;
use crate::provenance::write_json;
use pelage_core::film::{Metadata, io};
use pelage_core::{Error, Result};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Folder of the kept results in the figure's folder.
pub(super) const FOLDER: &str = "golden";
/// File of the kept results other than pictures.
const FILE: &str = "golden.json";
/// Largest mean FLIP between the sheets. Two runs on one adapter are equal; on the small pelt of
/// figure 1 a tenth less undercoat gives 0.006, another seed of the hairs 0.04.
const LARGEST_FLIP: f64 = 0.004;

/// The kept part of a record.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Kept {
    /// The assembled panels.
    pub(super) sheet: Option<String>,
    /// Plots and drawings with their captions.
    pub(super) drawings: Vec<Drawing>,
    /// Tables and text, Markdown; shown in the report, not compared.
    pub(super) text: String,
    /// Machine, version and date of the text; empty without text.
    pub(super) provenance: String,
    /// Numbers, which are compared.
    pub(super) values: Vec<Value>,
}

impl Kept {
    pub(super) fn read(folder: &Path) -> Option<Self> {
        serde_json::from_str(&std::fs::read_to_string(folder.join(FOLDER).join(FILE)).ok()?).ok()
    }
}

/// Keeps the results of a record in the figure's folder.
pub(super) fn keep(record: &Record, root: &Path, folder: &Path) -> Result<()> {
    let to = folder.join(FOLDER);
    match std::fs::remove_dir_all(&to) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(Error::io(&to, e)),
        _ => {}
    }
    std::fs::create_dir_all(&to).map_err(|e| Error::io(&to, e))?;
    let from = result_folder(root, &record.figure);
    if let Some(sheet) = &record.sheet {
        // Without command and machine in the metadata, so that the file changes only if the picture
        // does.
        io::write(&io::read(from.join(sheet))?, to.join(sheet), &Metadata::default(), &as_shown())?;
    }
    for file in record.drawings.iter().map(|d| &d.file) {
        std::fs::copy(from.join(file), to.join(file)).map_err(|e| Error::io(to.join(file), e))?;
    }
    let p = &record.provenance;
    let kept = Kept {
        sheet: record.sheet.clone(),
        drawings: record.drawings.clone(),
        text: record.text.clone(),
        provenance: match record.text.is_empty() {
            true => String::new(),
            false => format!("{}, {}, pelage {}, {}", p.adapter, p.driver, p.version, p.date),
        },
        values: record.values.clone(),
    };
    write_json(&to.join(FILE), &kept)
}

/// The differences from the kept results, one line each.
///
/// # Errors
/// [`Error::Io`] for files that cannot be read.
pub(super) fn differences(record: &Record, root: &Path, folder: &Path) -> Result<Vec<String>> {
    let name = &record.figure;
    let Some(kept) = Kept::read(folder) else {
        return Ok(vec![format!("{name}: nothing is kept: pelage figure {name} --quick --bless")]);
    };
    let mut lines = Vec::new();
    let [now, then]: [PathBuf; 2] = [result_folder(root, name), folder.join(FOLDER)];
    match (&record.sheet, &kept.sheet) {
        _ if !record.missing.is_empty() => {}
        (Some(sheet), Some(old)) => {
            let [sheet, old] = [io::read(now.join(sheet))?, io::read(then.join(old))?];
            match compare(&sheet, &old) {
                Ok(found) if found.all.flip <= LARGEST_FLIP => {}
                Ok(found) => lines.push(format!(
                    "{name}: the picture differs: mean FLIP {:.4}, at most {LARGEST_FLIP}",
                    found.all.flip
                )),
                Err(error) => lines.push(format!("{name}: {error}")),
            }
        }
        (None, None) => {}
        (sheet, _) => {
            lines.push(format!("{name}: {} a picture", if sheet.is_some() { "has" } else { "lacks" }))
        }
    }
    let files = |drawings: &[Drawing]| drawings.iter().map(|d| d.file.clone()).collect::<Vec<_>>();
    let [now, then] = [files(&record.drawings), files(&kept.drawings)];
    if now != then {
        lines.push(format!("{name}: drawings are {now:?}, kept are {then:?}"));
    }
    lines.extend(values(&record.values, &kept.values).into_iter().map(|line| format!("{name}: {line}")));
    Ok(lines)
}

fn values(now: &[Value], then: &[Value]) -> Vec<String> {
    let mut lines = Vec::new();
    for old in then {
        match now.iter().find(|value| value.name == old.name) {
            None => lines.push(format!("{:?} is no longer measured", old.name)),
            // Written so that a NaN is reported.
            Some(value) if (value.value - old.value).abs() <= old.tolerance => {}
            Some(value) => lines.push(format!(
                "{:?} is {}, expected {} ± {}",
                old.name, value.value, old.value, old.tolerance
            )),
        }
    }
    for value in now.iter().filter(|value| !then.iter().any(|old| old.name == value.name)) {
        lines.push(format!("{:?} is new", value.name));
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(name: &str, value: f64) -> Value {
        Value { name: name.into(), value, tolerance: 0.1 }
    }

    #[test]
    fn numbers_are_compared_with_the_kept_ones() {
        assert!(values(&[value("a", 1.05)], &[value("a", 1.0)]).is_empty());
        assert_eq!(values(&[value("a", 1.2)], &[value("a", 1.0)]).len(), 1);
        assert_eq!(values(&[value("a", f64::NAN)], &[value("a", 1.0)]).len(), 1);
        assert_eq!(values(&[value("b", 1.0)], &[value("a", 1.0)]).len(), 2, "one is gone, one is new");
    }
}
