//! The scan of an OBJ text: checks each statement and rewrites it for tobj.

use super::super::Sections;
use super::{Count, Statements, words};
use crate::{Error, Result, SceneFault};
use glam::Vec3;
use std::fmt::Write as _;
use std::path::Path;

/// The clean text for tobj, and what the scan noticed.
#[derive(Default)]
pub(super) struct Clean {
    /// With vertex colours, each vertex has its number in place of a colour: tobj drops vertices
    /// without faces, and knows no alpha.
    pub text: String,
    /// Colours as the file has them and alphas, one for each `v`; empty if the file has no colours.
    pub colors: Vec<Vec3>,
    pub alphas: Vec<f32>,
    pub sections: Sections,
    /// The section of each face in `text`.
    pub section_of: Vec<u32>,
    /// Material libraries.
    pub libraries: Vec<String>,
    pub weighted: u64,
    pub short_faces: u64,
    pub others: u64,
    /// Vertices with a colour from ZBrush.
    pub polypaint: u64,
}

/// Largest number of faults that are reported for a file; further ones are counted.
const MAX_FAULTS: usize = 10;

/// The scan: checks each statement and rewrites it for tobj, with absolute indices and without what
/// is not used.
pub(super) struct Scan<'a> {
    file: &'a Path,
    count: &'a Count,
    positions: u64,
    texcoords: u64,
    group: String,
    material: String,
    mrgb: Vec<[u8; 4]>,
    clean: Clean,
    faults: Vec<SceneFault>,
    more_faults: u64,
}

impl<'a> Scan<'a> {
    /// `mrgb`: mask and colour of vertices from ZBrush's lines, in the order of vertices.
    pub fn run(text: &[u8], file: &'a Path, count: &'a Count, mrgb: Vec<[u8; 4]>) -> Result<Clean> {
        let mut scan = Self {
            file,
            count,
            positions: 0,
            texcoords: 0,
            group: String::new(),
            material: String::new(),
            mrgb,
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
                Some(b"g" | b"o") => {
                    scan.group = rest(statement);
                    Ok(())
                }
                Some(b"usemtl") => {
                    scan.material = rest(statement);
                    Ok(())
                }
                Some(b"mtllib") => {
                    scan.clean.libraries.push(rest(statement));
                    Ok(())
                }
                // Normals are computed anew; smoothing groups and the rest do not matter for fur.
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
            [x, y, z] => ([x, y, z], [1.0; 4]),
            [x, y, z, r, g, b] => ([x, y, z], [r, g, b, 1.0]),
            [x, y, z, r, g, b, a] => ([x, y, z], [r, g, b, a]),
            [x, y, z, w] => {
                self.clean.weighted += u64::from(w != 1.0);
                let position = [x / w, y / w, z / w];
                if position.iter().any(|p| !p.is_finite()) {
                    return Err(format!(
                        "found w = {w}, expected a number by which the position can be divided"
                    ));
                }
                (position, [1.0; 4])
            }
            _ => {
                return Err(format!(
                    "found `v` with {} numbers, expected x y z, x y z w, x y z r g b or x y z r g b a",
                    v.len()
                ));
            }
        };
        if let Some(c) = color.iter().find(|c| **c < 0.0) {
            return Err(format!("found a vertex colour of {c}, expected 0 or more"));
        }
        let ([x, y, z], [r, g, b, a]) = (position, color);
        // An f32 is written as the shortest text that reads back as the same number.
        let written = if self.count.colored > 0 || !self.mrgb.is_empty() {
            let number = self.clean.colors.len();
            let (color, alpha) = match self.mrgb.get(number) {
                Some([mask, r, g, b]) => {
                    self.clean.polypaint += 1;
                    let unit = |byte: u8| f32::from(byte) / 255.0;
                    (Vec3::new(unit(*r), unit(*g), unit(*b)), unit(*mask))
                }
                None => (Vec3::new(r, g, b), a),
            };
            self.clean.colors.push(color);
            self.clean.alphas.push(alpha);
            writeln!(self.clean.text, "v {x} {y} {z} {} {} 0", number & 0xFFFF, number >> 16)
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
        } else {
            let section = self.clean.sections.index(&self.group, &self.material);
            self.clean.section_of.push(section);
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

/// What follows the keyword of a statement.
fn rest(statement: &[u8]) -> String {
    let statement = statement.trim_ascii();
    let end = statement.iter().position(u8::is_ascii_whitespace).unwrap_or(statement.len());
    String::from_utf8_lossy(statement[end..].trim_ascii()).into_owned()
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
