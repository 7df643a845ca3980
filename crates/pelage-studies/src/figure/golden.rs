//! Small versions of the figures that are kept in the repository, so that a change which alters one is noticed.

use super::content::{Record, Value};
use super::result_folder;
use crate::compare::compare;
use crate::provenance::write_json;
use pelage_core::film::{Metadata, io};
use pelage_core::scene::{FilmSpec, Tonemap};
use pelage_core::{Error, Result};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Folder of what is kept, in the figure's.
pub(super) const FOLDER: &str = "golden";
/// What is kept besides pictures.
const FILE: &str = "golden.json";
/// Largest mean FLIP between the sheets. Two runs on one adapter are equal; on the small pelt of figure 1 a tenth less undercoat makes
/// 0.006, another seed of the hairs 0.04.
const LARGEST_FLIP: f64 = 0.004;

/// What is kept of a record.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct Kept {
    /// The assembled panels.
    pub(super) sheet: Option<String>,
    /// Plots and drawings with their captions.
    pub(super) drawings: Vec<super::content::Drawing>,
    /// Tables and words as they were, Markdown: for the report, not compared.
    pub(super) text: String,
    /// Machine, version and date of the text; empty without one.
    pub(super) provenance: String,
    /// Numbers that are compared.
    pub(super) values: Vec<Value>,
}

impl Kept {
    pub(super) fn read(folder: &Path) -> Option<Self> {
        serde_json::from_str(&std::fs::read_to_string(folder.join(FOLDER).join(FILE)).ok()?).ok()
    }
}

/// Copies a record's small files to the registry.
pub(super) fn keep(record: &Record, root: &Path, folder: &Path) -> Result<()> {
    let to = folder.join(FOLDER);
    match std::fs::remove_dir_all(&to) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(Error::io(&to, e)),
        _ => {}
    }
    std::fs::create_dir_all(&to).map_err(|e| Error::io(&to, e))?;
    let from = result_folder(root, &record.figure);
    if let Some(sheet) = &record.sheet {
        // Without command and machine: the file changes when the picture does.
        let spec = FilmSpec { tonemap: Tonemap::None, exposure: 0.0, ..FilmSpec::default() };
        io::write(&io::read(from.join(sheet))?, to.join(sheet), &Metadata::default(), &spec)?;
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

/// What differs from what is kept, in words.
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
    let files =
        |drawings: &[super::content::Drawing]| drawings.iter().map(|d| d.file.clone()).collect::<Vec<_>>();
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
            // Written so that what is not a number is told of.
            Some(value) if (value.value - old.value).abs() <= old.tolerance => {}
            Some(value) => lines.push(format!(
                "{:?} is {}, kept is {} give or take {}",
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
    fn numbers_are_held_to_what_is_kept() {
        assert!(values(&[value("a", 1.05)], &[value("a", 1.0)]).is_empty());
        assert_eq!(values(&[value("a", 1.2)], &[value("a", 1.0)]).len(), 1);
        assert_eq!(values(&[value("a", f64::NAN)], &[value("a", 1.0)]).len(), 1);
        assert_eq!(values(&[value("b", 1.0)], &[value("a", 1.0)]).len(), 2, "one is gone, one is new");
    }
}
