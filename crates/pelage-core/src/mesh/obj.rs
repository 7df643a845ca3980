//! Reads OBJ files. tobj does the parsing, but it knows no line numbers, fails on things that OBJ
//! files may hold, and invents missing indices. So the text is scanned first, every fault is
//! reported with its line, and tobj gets a clean copy.

mod materials;
mod mrgb;
mod scan;
mod statements;

use super::{Mesh, colors, polygon};
use crate::scene::Units;
use crate::{Error, Result};
use glam::{Vec2, Vec3};
use scan::{Clean, Scan};
use statements::{Statements, words};
use std::path::Path;

pub use super::read::Limits;
use super::read::too_large;

/// Approximate peak memory of reading, bytes: the text twice, tobj's tables, the mesh.
fn estimated_bytes(text: u64, count: &Count) -> u64 {
    2 * text + 96 * count.positions + 160 * count.corners
}

/// Reads an OBJ file with its material libraries. Positions keep the file's units; vertex colours
/// are taken as linear.
///
/// # Errors
/// [`Error::Io`] where the file cannot be read; [`Error::Scene`] with file and line for every fault
/// of the text, for a file without faces and for one beyond `Limits::default()`.
pub fn read(path: &Path) -> Result<Mesh> {
    let limits = Limits::default();
    let size = std::fs::metadata(path).map_err(|e| Error::io(path, e))?.len();
    if size > limits.bytes {
        return Err(too_large(path, format!("found {size} bytes, expected at most {}", limits.bytes)));
    }
    read_bytes(&std::fs::read(path).map_err(|e| Error::io(path, e))?, path, &limits)
}

/// As [`read`], for a file whose content is `text`.
pub(super) fn read_bytes(text: &[u8], path: &Path, limits: &Limits) -> Result<Mesh> {
    let (mut mesh, libraries) = parsed(text, path, limits)?;
    materials::apply(&mut mesh, &libraries, path);
    Ok(mesh)
}

/// Reads OBJ text without its material libraries; `file` is the name in messages. Errors as
/// [`read`].
pub fn parse(text: &[u8], file: &Path, limits: &Limits) -> Result<Mesh> {
    Ok(parsed(text, file, limits)?.0)
}

/// The mesh, and the material libraries that the text names.
fn parsed(text: &[u8], file: &Path, limits: &Limits) -> Result<(Mesh, Vec<String>)> {
    if text.starts_with(b"\xFF\xFE") || text.starts_with(b"\xFE\xFF") {
        return Err(Error::fault_at(
            file,
            1,
            "found UTF-16 text, expected OBJ in UTF-8 or ASCII: convert it",
        ));
    }
    let count = Count::of(text);
    if count.positions > limits.vertices || count.triangles > limits.triangles {
        let found = format!(
            "found {} vertices and {} triangles, which would take about {} MiB to read, expected at most {} and {}",
            count.positions,
            count.triangles,
            estimated_bytes(text.len() as u64, &count) >> 20,
            limits.vertices,
            limits.triangles
        );
        return Err(too_large(file, found));
    }
    if count.triangles == 0 {
        let found = format!(
            "found {} vertices and no faces, expected a mesh of `v` and `f` statements",
            count.positions
        );
        return Err(Error::fault(file, found));
    }
    let mrgb = match count.colored {
        0 => mrgb::read(text).map_err(|(line, message)| Error::fault_at(file, line, message))?,
        _ => Vec::new(),
    };
    let mut clean = Scan::run(text, file, &count, mrgb)?;
    let libraries = std::mem::take(&mut clean.libraries);
    let mut mesh = mesh_of(clean, file, &count)?;
    if text.starts_with(b"# pelage ")
        && text.split(|b| *b == b'\n').next().is_some_and(|l| l.ends_with(b", cm"))
    {
        mesh.unit = Some(Units::Cm);
    }
    Ok((mesh, libraries))
}

/// Counts of a file's statements, taken before it is parsed: relative indices, missing uv and
/// memory depend on them.
#[derive(Debug, Default)]
struct Count {
    positions: u64,
    colored: u64,
    texcoords: u64,
    triangles: u64,
    corners: u64,
    corners_with_uv: u64,
}

impl Count {
    fn of(text: &[u8]) -> Self {
        let mut count = Self::default();
        let mut statements = Statements::new(text);
        while let Some((_, statement)) = statements.next() {
            let mut words = words(statement);
            match words.next() {
                Some(b"v") => {
                    count.positions += 1;
                    count.colored += u64::from(matches!(words.count(), 6 | 7));
                }
                Some(b"vt") => count.texcoords += 1,
                Some(b"f") => {
                    let (mut corners, mut with_uv) = (0, 0);
                    for word in words {
                        corners += 1;
                        let uv = word.split(|b| *b == b'/').nth(1);
                        with_uv += u64::from(uv.is_some_and(|uv| !uv.is_empty()));
                    }
                    if corners >= 3 {
                        count.triangles += corners - 2;
                        count.corners += corners;
                        count.corners_with_uv += with_uv;
                    }
                }
                _ => {}
            }
        }
        count
    }

    /// Whether the file has uv and all face corners name them.
    fn uv(&self) -> bool {
        self.texcoords > 0 && self.corners_with_uv == self.corners
    }
}

/// Parses the clean text by tobj and cuts its polygons into triangles.
fn mesh_of(mut clean: Clean, file: &Path, count: &Count) -> Result<Mesh> {
    // Materials are never loaded; all faces are one model, since groups do not reach tobj.
    let options = tobj::LoadOptions { ignore_points: true, ignore_lines: true, ..Default::default() };
    let no_materials = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
    let parsed = tobj::load_obj_buf(&mut clean.text.as_bytes(), &options, no_materials);
    let (models, _) = parsed.map_err(|e| Error::fault(file, format!("cannot be read as OBJ: {e}")))?;
    let Some(model) = models.into_iter().next() else { return Err(Error::fault(file, "found no faces")) };
    let source = model.mesh;
    let mut mesh = Mesh {
        positions: source.positions.chunks_exact(3).map(Vec3::from_slice).collect(),
        corner_uv: count.uv().then(Vec::new),
        sections: std::mem::take(&mut clean.sections.list),
        ..Mesh::default()
    };
    let color_notes = colors::to_unit_range(&mut clean.colors);
    if !clean.colors.is_empty() {
        // The colours that tobj saw are the vertices' numbers.
        let number = |c: &[f32]| c[0] as usize + ((c[1] as usize) << 16);
        let numbers: Vec<usize> = source.vertex_color.chunks_exact(3).map(number).collect();
        mesh.colors = numbers.iter().map(|i| clean.colors[*i]).collect();
        if clean.alphas.iter().any(|a| *a != 1.0) {
            mesh.alphas = numbers.iter().map(|i| clean.alphas[*i].clamp(0.0, 1.0)).collect();
        }
    }
    let uv: Vec<Vec2> = source.texcoords.chunks_exact(2).map(Vec2::from_slice).collect();
    let arities = match source.face_arities.is_empty() {
        true => vec![3; source.indices.len() / 3],
        false => source.face_arities,
    };
    let mut start = 0;
    let mut cutter = polygon::Cutter::new(&mesh.positions);
    for (face, arity) in arities.into_iter().enumerate() {
        let end = start + arity as usize;
        let corners = &source.indices[start..end];
        let cuts = cutter.cut(&mesh.positions, corners);
        mesh.triangles.extend(cuts.iter().map(|t| t.map(|k| corners[k])));
        let section = clean.section_of.get(face).copied().unwrap_or(0);
        mesh.section_of.resize(mesh.triangles.len(), section);
        if let Some(corner_uv) = &mut mesh.corner_uv {
            let indices = &source.texcoord_indices[start..end];
            corner_uv.extend(cuts.iter().map(|t| t.map(|k| uv[indices[k] as usize])));
        }
        start = end;
    }

    let unused = count.positions.saturating_sub(mesh.positions.len() as u64);
    let mut repair = |n: u64, what: &str| (n > 0).then(|| mesh.repairs.push(format!("{n} {what}")));
    repair(unused, "unused vertices dropped");
    repair(clean.short_faces, "faces with fewer than three corners dropped");
    cutter.report(&mut mesh);
    mesh.notes.extend(color_notes);
    let mut note = |n: u64, what: &str| (n > 0).then(|| mesh.notes.push(format!("{n} {what}")));
    note(clean.weighted, "vertices with a weight w other than 1, divided by it");
    note(clean.others, "points, lines, curves or surfaces left out");
    note(clean.polypaint, "vertex colours read from ZBrush's #MRGB lines, their masks as alpha");
    if clean.polypaint > 0 {
        note(
            count.positions.saturating_sub(clean.polypaint),
            "vertices without an #MRGB colour, taken as white",
        );
    }
    if count.colored > 0 {
        note(count.positions - count.colored, "vertices without a colour, taken as white");
    }
    if count.texcoords == 0 {
        note(count.corners_with_uv, "face corners name a uv, but the file has none: read without uv");
    } else if !count.uv() {
        note(count.corners - count.corners_with_uv, "face corners have no uv: the mesh is read without uv");
    }
    Ok(mesh)
}
