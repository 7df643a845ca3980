//! Colours and colour maps of OBJ's material libraries (.mtl). The reader is tolerant: what it
//! cannot read is left out with a note, since fur does not need it.

use super::statements::{Statements, words};
use crate::mesh::Mesh;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Largest size of a library, bytes.
const MAX_BYTES: u64 = 16 << 20;

#[derive(Default)]
struct Material {
    color: Option<[f32; 3]>,
    map: Option<String>,
}

/// Gives the sections of `mesh`, read from `obj`, the colours and maps of their materials.
pub(super) fn apply(mesh: &mut Mesh, libraries: &[String], obj: &Path) {
    let folder = obj.parent().unwrap_or(Path::new(""));
    let mut materials = HashMap::new();
    for name in libraries {
        // One name with spaces, or several names.
        let whole = folder.join(slashes(name));
        let paths: Vec<PathBuf> = match whole.is_file() {
            true => vec![whole],
            false => name.split_whitespace().map(|n| folder.join(slashes(n))).collect(),
        };
        for path in paths {
            match text_of(&path) {
                Ok(text) => read(&text, &path, &mut materials, &mut mesh.notes),
                Err(reason) => mesh.notes.push(format!(
                    "the material library {} {reason}: its colours and maps are left out",
                    path.display()
                )),
            }
        }
    }
    for section in &mut mesh.sections {
        if let Some(material) = materials.get(&section.material) {
            section.base_color = material.color;
            section.base_map.clone_from(&material.map);
        }
    }
}

fn slashes(name: &str) -> String {
    name.replace('\\', "/")
}

fn text_of(path: &Path) -> Result<Vec<u8>, String> {
    let size = std::fs::metadata(path).map_err(|_| "is not there")?.len();
    if size > MAX_BYTES {
        return Err(format!("has {size} bytes, more than {MAX_BYTES}"));
    }
    std::fs::read(path).map_err(|e| format!("cannot be read ({e})"))
}

fn read(text: &[u8], path: &Path, materials: &mut HashMap<String, Material>, notes: &mut Vec<String>) {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut current: Option<String> = None;
    let (mut damaged, mut missing) = (0, Vec::new());
    let mut statements = Statements::new(text);
    while let Some((_, statement)) = statements.next() {
        let words: Vec<String> = words(statement).map(|w| String::from_utf8_lossy(w).into_owned()).collect();
        let Some((keyword, arguments)) = words.split_first() else { continue };
        if keyword == "newmtl" {
            current = Some(arguments.join(" "));
            continue;
        }
        let Some(name) = &current else { continue };
        match keyword.as_str() {
            "Kd" => {
                let numbers: Option<Vec<f32>> = arguments
                    .iter()
                    .take(3)
                    .map(|w| w.parse().ok().filter(|v: &f32| v.is_finite()))
                    .collect();
                let color = match numbers.as_deref() {
                    Some([r, g, b]) => Some([*r, *g, *b]),
                    Some([grey]) => Some([*grey; 3]),
                    _ => None,
                };
                damaged += usize::from(color.is_none());
                let color = color.map(|c| c.map(|v| v.clamp(0.0, 1.0)));
                materials.entry(name.clone()).or_default().color = color;
            }
            "map_Kd" => {
                let file = slashes(&map_name(arguments));
                if file.is_empty() {
                    damaged += 1;
                    continue;
                }
                let file = folder.join(file.trim_start_matches("./"));
                if !file.is_file() {
                    missing.push(file.display().to_string());
                }
                materials.entry(name.clone()).or_default().map = Some(file.display().to_string());
            }
            _ => {}
        }
    }
    if !missing.is_empty() {
        let (first, more) = (&missing[0], missing.len() - 1);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        notes.push(format!("{}: maps that are not there: {first}{more}", path.display()));
    }
    if damaged > 0 {
        notes.push(format!("{}: {damaged} damaged statements left out", path.display()));
    }
}

/// The file name in the arguments of `map_Kd`, which begin with options.
fn map_name(arguments: &[String]) -> String {
    let mut at = 0;
    while let Some(option) = arguments.get(at).filter(|w| w.starts_with('-')) {
        at += 1;
        match option.as_str() {
            "-mm" => at += 2,
            // One to three numbers.
            "-o" | "-s" | "-t" => {
                let numbers = arguments[at.min(arguments.len())..].iter().take(3);
                at += numbers.take_while(|w| w.parse::<f32>().is_ok()).count();
            }
            _ => at += 1,
        }
    }
    arguments.get(at..).unwrap_or_default().join(" ")
}
