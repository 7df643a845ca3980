//! Reads OBJ files. tobj does the parsing, but it knows no line numbers, fails on things that OBJ
//! files may hold, and invents missing indices. So the text is scanned first, every fault is
//! reported with its line, and tobj gets a clean copy.

mod polygon;
mod statements;

use super::Mesh;
use crate::{Error, Result, SceneFault};
use glam::{Vec2, Vec3};
use statements::{Statements, words};
use std::collections::HashSet;
use std::fmt::Write as _;
use std::path::Path;

/// Limits of a file, checked before memory is spent on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// File size, bytes.
    pub bytes: u64,
    /// `v` statements.
    pub vertices: u64,
    /// Triangles after cutting polygons.
    pub triangles: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { bytes: 8 << 30, vertices: 1 << 26, triangles: 1 << 26 }
    }
}

/// Approximate peak memory of reading, bytes: the text twice, tobj's tables, the mesh.
fn estimated_bytes(text: u64, count: &Count) -> u64 {
    2 * text + 96 * count.positions + 160 * count.corners
}

/// Reads an OBJ file. Positions keep the file's units.
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
    parse(&std::fs::read(path).map_err(|e| Error::io(path, e))?, path, &limits)
}

/// Reads OBJ text; `file` is the name in messages. Errors as [`read`].
pub fn parse(text: &[u8], file: &Path, limits: &Limits) -> Result<Mesh> {
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
    let clean = Scan::run(text, file, &count)?;
    mesh_of(&clean, file, &count)
}

fn too_large(file: &Path, message: String) -> Error {
    Error::Scene(vec![SceneFault {
        file: file.to_owned(),
        line: 0,
        column: 0,
        message,
        help: Some("reduce the mesh (decimate it) or split it into several files".into()),
    }])
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
                    count.colored += u64::from(words.count() == 6);
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

/// The clean text for tobj, and what the scan noticed.
#[derive(Default)]
struct Clean {
    text: String,
    weighted: u64,
    short_faces: u64,
    others: u64,
}

/// Largest number of faults that are reported for a file; further ones are counted.
const MAX_FAULTS: usize = 10;

/// The scan: checks each statement and rewrites it for tobj, with absolute indices and without what
/// is not used.
struct Scan<'a> {
    file: &'a Path,
    count: &'a Count,
    positions: u64,
    texcoords: u64,
    clean: Clean,
    faults: Vec<SceneFault>,
    more_faults: u64,
}

impl<'a> Scan<'a> {
    fn run(text: &[u8], file: &'a Path, count: &'a Count) -> Result<Clean> {
        let mut scan = Self {
            file,
            count,
            positions: 0,
            texcoords: 0,
            clean: Clean { text: String::with_capacity(text.len()), ..Clean::default() },
            faults: Vec::new(),
            more_faults: 0,
        };
        let mut statements = Statements::new(text);
        while let Some((line, statement)) = statements.next() {
            let mut words = words(statement);
            let checked = match words.next() {
                Some(b"v") => scan.position(words),
                Some(b"vt") => scan.texcoord(words),
                Some(b"f") => scan.face(words),
                Some(b"l" | b"p" | b"curv" | b"curv2" | b"surf") => {
                    scan.clean.others += 1;
                    Ok(())
                }
                // Normals are computed anew; groups, materials and the rest do not matter for fur.
                _ => Ok(()),
            };
            if let Err(message) = checked {
                scan.fault(line, message);
            }
        }
        if scan.faults.is_empty() {
            return Ok(scan.clean);
        }
        if scan.more_faults > 0
            && let Some(last) = scan.faults.last_mut()
        {
            last.help = Some(format!("{} more faults like these follow", scan.more_faults));
        }
        Err(Error::Scene(scan.faults))
    }

    fn fault(&mut self, line: usize, message: String) {
        if self.faults.len() == MAX_FAULTS {
            self.more_faults += 1;
            return;
        }
        self.faults.push(SceneFault { file: self.file.to_owned(), line, column: 0, message, help: None });
    }

    fn position<'w>(&mut self, words: impl Iterator<Item = &'w [u8]>) -> Result<(), String> {
        self.positions += 1;
        let v = words.map(number).collect::<Result<Vec<f32>, String>>()?;
        let (position, color) = match v[..] {
            [x, y, z] => ([x, y, z], [1.0; 3]),
            [x, y, z, r, g, b] => ([x, y, z], [r, g, b]),
            [x, y, z, w] => {
                self.clean.weighted += u64::from(w != 1.0);
                let position = [x / w, y / w, z / w];
                if position.iter().any(|p| !p.is_finite()) {
                    return Err(format!(
                        "found w = {w}, expected a number by which the position can be divided"
                    ));
                }
                (position, [1.0; 3])
            }
            _ => {
                return Err(format!(
                    "found `v` with {} numbers, expected x y z, x y z w or x y z r g b",
                    v.len()
                ));
            }
        };
        if let Some(c) = color.iter().find(|c| **c < 0.0) {
            return Err(format!("found a vertex colour of {c}, expected 0 or more"));
        }
        let ([x, y, z], [r, g, b]) = (position, color);
        // An f32 is written as the shortest text that reads back as the same number.
        let written = if self.count.colored > 0 {
            writeln!(self.clean.text, "v {x} {y} {z} {r} {g} {b}")
        } else {
            writeln!(self.clean.text, "v {x} {y} {z}")
        };
        written.map_err(|e| e.to_string())
    }

    fn texcoord<'w>(&mut self, words: impl Iterator<Item = &'w [u8]>) -> Result<(), String> {
        self.texcoords += 1;
        let uv = words.map(number).collect::<Result<Vec<f32>, String>>()?;
        let (u, v) = match uv[..] {
            [u] => (u, 0.0),
            [u, v] | [u, v, _] => (u, v),
            _ => return Err(format!("found `vt` with {} numbers, expected u v", uv.len())),
        };
        writeln!(self.clean.text, "vt {u} {v}").map_err(|e| e.to_string())
    }

    fn face<'w>(&mut self, words: impl Iterator<Item = &'w [u8]>) -> Result<(), String> {
        let start = self.clean.text.len();
        let result = self.corners(words);
        if !matches!(result, Ok(3..)) {
            self.clean.text.truncate(start);
            self.clean.short_faces += u64::from(result.is_ok());
        }
        result.map(|_| ())
    }

    fn corners<'w>(&mut self, words: impl Iterator<Item = &'w [u8]>) -> Result<u64, String> {
        self.clean.text.push('f');
        let mut corners = 0;
        for word in words {
            let mut parts = word.split(|b| *b == b'/');
            let (v, vt, vn) = (parts.next().unwrap_or_default(), parts.next(), parts.next());
            if parts.next().is_some() {
                return Err(format!(
                    "found the corner `{}`, expected v, v/vt, v//vn or v/vt/vn",
                    shown(word)
                ));
            }
            let v = index(v, self.positions, self.count.positions, "vertices")?;
            let (vt, vn) = (vt.unwrap_or_default(), vn.unwrap_or_default());
            if !vn.is_empty() {
                integer(vn)?;
            }
            let written = match vt {
                b"" => write!(self.clean.text, " {v}"),
                // Without any vt the index means nothing; a note says so.
                _ if self.count.texcoords == 0 => {
                    integer(vt)?;
                    write!(self.clean.text, " {v}")
                }
                _ => {
                    let vt = index(vt, self.texcoords, self.count.texcoords, "uv")?;
                    match self.count.uv() {
                        true => write!(self.clean.text, " {v}/{vt}"),
                        false => write!(self.clean.text, " {v}"),
                    }
                }
            };
            written.map_err(|e| e.to_string())?;
            corners += 1;
        }
        self.clean.text.push('\n');
        Ok(corners)
    }
}

/// A word as messages show it.
fn shown(word: &[u8]) -> String {
    String::from_utf8_lossy(word).chars().take(40).collect()
}

fn number(word: &[u8]) -> Result<f32, String> {
    let parsed = std::str::from_utf8(word).ok().and_then(|w| w.parse::<f32>().ok());
    match parsed {
        Some(n) if n.is_finite() => Ok(n),
        _ => Err(format!("found `{}`, expected a finite number (of at most 3.4e38)", shown(word))),
    }
}

fn integer(word: &[u8]) -> Result<i64, String> {
    let parsed = std::str::from_utf8(word).ok().and_then(|w| w.parse::<i64>().ok());
    parsed.ok_or_else(|| format!("found the index `{}`, expected an integer", shown(word)))
}

/// An index from 1. A negative one counts back from the last of the `so_far` elements above the
/// face; a positive one may refer to a later element.
fn index(word: &[u8], so_far: u64, total: u64, what: &str) -> Result<u64, String> {
    let found = integer(word)?;
    let resolved = if found < 0 { found.saturating_add_unsigned(so_far).saturating_add(1) } else { found };
    match u64::try_from(resolved) {
        Ok(i) if i >= 1 && i <= total => Ok(i),
        _ if found == 0 => Err(format!("found index 0, expected 1 to {total} (OBJ counts {what} from 1)")),
        _ if found < 0 => {
            Err(format!("found index {found}, but there are only {so_far} {what} above this line"))
        }
        _ => Err(format!("found index {found}, but the file has {total} {what}")),
    }
}

/// Parses the clean text by tobj and cuts its polygons into triangles.
fn mesh_of(clean: &Clean, file: &Path, count: &Count) -> Result<Mesh> {
    // Materials are never loaded; all faces are one model, since groups do not reach tobj.
    let options = tobj::LoadOptions { ignore_points: true, ignore_lines: true, ..Default::default() };
    let no_materials = |_: &Path| Err(tobj::LoadError::OpenFileFailed);
    let parsed = tobj::load_obj_buf(&mut clean.text.as_bytes(), &options, no_materials);
    let (models, _) = parsed.map_err(|e| Error::fault(file, format!("cannot be read as OBJ: {e}")))?;
    let Some(model) = models.into_iter().next() else { return Err(Error::fault(file, "found no faces")) };
    let source = model.mesh;
    let mut mesh = Mesh {
        positions: source.positions.chunks_exact(3).map(Vec3::from_slice).collect(),
        colors: source.vertex_color.chunks_exact(3).map(Vec3::from_slice).collect(),
        corner_uv: count.uv().then(Vec::new),
        ..Mesh::default()
    };
    let uv: Vec<Vec2> = source.texcoords.chunks_exact(2).map(Vec2::from_slice).collect();
    let arities = match source.face_arities.is_empty() {
        true => vec![3; source.indices.len() / 3],
        false => source.face_arities,
    };
    let (mut start, mut cuts) = (0, Vec::new());
    let (mut polygons, mut concave, mut guessed) = (0_u64, 0_u64, 0_u64);
    let mut seen: HashSet<[u32; 3]> = HashSet::new();
    for arity in arities {
        let end = start + arity as usize;
        let corners = &source.indices[start..end];
        let points: Vec<Vec3> = corners.iter().map(|i| mesh.positions[*i as usize]).collect();
        let cut = polygon::triangulate(&points, &mut cuts);
        if arity > 3 {
            polygons += 1;
            let mut is_new = |t: &[usize; 3]| {
                let mut key = t.map(|k| corners[k]);
                key.sort_unstable();
                seen.insert(key)
            };
            // Two quads may share two sides; cut between the same corners, both would contain the
            // same triangle.
            if !cuts.iter().all(&mut is_new) && arity == 4 && cut == polygon::Cut::Fan {
                cuts = vec![[1, 2, 3], [1, 3, 0]];
                cuts.iter().for_each(|t| {
                    is_new(t);
                });
            }
        }
        concave += u64::from(cut == polygon::Cut::Ears);
        guessed += u64::from(cut == polygon::Cut::Guess);
        mesh.triangles.extend(cuts.iter().map(|t| t.map(|k| corners[k])));
        if let Some(corner_uv) = &mut mesh.corner_uv {
            let indices = &source.texcoord_indices[start..end];
            corner_uv.extend(cuts.iter().map(|t| t.map(|k| uv[indices[k] as usize])));
        }
        start = end;
    }
    colors_from_bytes(&mut mesh);

    let unused = count.positions.saturating_sub(mesh.positions.len() as u64);
    let mut repair = |n: u64, what: &str| (n > 0).then(|| mesh.repairs.push(format!("{n} {what}")));
    repair(unused, "unused vertices dropped");
    repair(clean.short_faces, "faces with fewer than three corners dropped");
    repair(guessed, "polygons without a clear inside cut as fans");
    let mut note = |n: u64, what: &str| (n > 0).then(|| mesh.notes.push(format!("{n} {what}")));
    note(polygons, "polygons cut into triangles");
    note(concave, "of them concave, cut by ear clipping");
    note(clean.weighted, "vertices with a weight w other than 1, divided by it");
    note(clean.others, "points, lines, curves or surfaces left out");
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

/// Scales vertex colours that a program wrote as 0..255.
fn colors_from_bytes(mesh: &mut Mesh) {
    let largest = mesh.colors.iter().map(|c| c.max_element()).fold(0.0, f32::max);
    if largest > 1.0 {
        mesh.colors.iter_mut().for_each(|c| *c /= largest.max(255.0));
        mesh.notes.push(format!("vertex colours go up to {largest}: read as 0..{}", largest.max(255.0)));
    }
}
