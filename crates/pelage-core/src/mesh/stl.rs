//! Reads STL files, ASCII and binary. stl_io reads only the first solid of a text, wants lower case
//! and a name, and gives no lines; the format is small enough to be read here.

use super::Mesh;
use super::read::Limits;
use crate::{Error, Result};
use glam::Vec3;
use std::path::Path;

/// Bytes before the triangles of a binary file, and of each triangle.
const HEADER: usize = 84;
const RECORD: usize = 50;

/// Reads an STL file's content; `file` is the name in messages. Normals are left out: they follow
/// from the corners. All solids are one section.
///
/// # Errors
/// [`Error::Scene`] with line or number of the triangle for a file that is damaged, without
/// triangles or beyond `limits`.
pub fn parse(bytes: &[u8], file: &Path, limits: &Limits) -> Result<Mesh> {
    let count = bytes.get(80..84).and_then(|n| n.try_into().ok()).map(u32::from_le_bytes);
    let exact = count.is_some_and(|n| bytes.len() as u64 == HEADER as u64 + RECORD as u64 * u64::from(n));
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes).trim_ascii_start();
    let is_text = text.len() >= 5
        && text[..5].eq_ignore_ascii_case(b"solid")
        && !bytes.iter().take(1 << 10).any(|b| *b == 0);
    let mesh = match count {
        _ if is_text && !exact => ascii(bytes, file, limits)?,
        Some(count) => binary(bytes, count, file, limits)?,
        None => return Err(Error::fault(file, format!("found {} bytes, expected an STL file", bytes.len()))),
    };
    if mesh.triangles.is_empty() {
        return Err(Error::fault(file, "found an STL file without triangles, expected one or more"));
    }
    Ok(mesh)
}

fn binary(bytes: &[u8], count: u32, file: &Path, limits: &Limits) -> Result<Mesh> {
    let wanted = HEADER as u64 + RECORD as u64 * u64::from(count);
    if (bytes.len() as u64) < wanted {
        return Err(Error::fault(
            file,
            format!(
                "found {} bytes, expected {wanted} for the {count} triangles of a binary STL file: \
                 it is cut short or its count is wrong",
                bytes.len()
            ),
        ));
    }
    limits.check(file, 3 * u64::from(count), u64::from(count))?;
    let mut mesh = Mesh::default();
    let number = |at: &[u8]| f32::from_le_bytes([at[0], at[1], at[2], at[3]]);
    for (t, record) in bytes[HEADER..wanted as usize].chunks_exact(RECORD).enumerate() {
        for corner in record[12..48].chunks_exact(12) {
            let p = Vec3::new(number(corner), number(&corner[4..]), number(&corner[8..]));
            if !p.is_finite() {
                let message = format!("triangle {} has a corner at {p}, expected finite numbers", t + 1);
                return Err(Error::fault(file, message));
            }
            mesh.positions.push(p);
        }
        add_triangle(&mut mesh);
    }
    let rest = bytes.len() as u64 - wanted;
    if rest > 0 {
        mesh.notes.push(format!("{rest} bytes after the triangles left out"));
    }
    Ok(mesh)
}

/// The last three vertices become a triangle.
fn add_triangle(mesh: &mut Mesh) {
    let n = mesh.positions.len() as u32;
    mesh.triangles.push([n - 3, n - 2, n - 1]);
}

fn ascii(bytes: &[u8], file: &Path, limits: &Limits) -> Result<Mesh> {
    let mut mesh = Mesh::default();
    let (mut line, mut in_loop, mut open) = (0, None, false);
    for text in lines(bytes) {
        line += 1;
        let mut words = text.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        let keyword = words.next().unwrap_or_default().to_ascii_lowercase();
        let fault = |message: String| Error::fault_at(file, line, message);
        match &keyword[..] {
            b"vertex" => {
                let numbers: Vec<&[u8]> = words.collect();
                let [x, y, z] = numbers[..] else {
                    let found = format!("found `vertex` with {} numbers, expected x y z", numbers.len());
                    return Err(fault(found));
                };
                let p = Vec3::new(
                    number(x).map_err(fault)?,
                    number(y).map_err(fault)?,
                    number(z).map_err(fault)?,
                );
                let Some(corners) = in_loop.as_mut() else {
                    return Err(fault("found `vertex` outside of `outer loop`".into()));
                };
                *corners += 1;
                mesh.positions.push(p);
            }
            b"outer" => in_loop = Some(0),
            b"endloop" => {
                let corners = in_loop.take().unwrap_or(0);
                if corners != 3 {
                    return Err(fault(format!("found a loop of {corners} vertices, expected 3")));
                }
                add_triangle(&mut mesh);
                limits.check(file, 0, mesh.triangles.len() as u64)?;
            }
            b"solid" => open = true,
            b"endsolid" => open = false,
            b"" | b"facet" | b"endfacet" => {}
            other => {
                let shown: String = String::from_utf8_lossy(other).chars().take(40).collect();
                return Err(fault(format!("found `{shown}`, expected a statement of STL")));
            }
        }
    }
    if in_loop.is_some() || open {
        return Err(Error::fault_at(file, line, "the file ends early, expected `endsolid`"));
    }
    Ok(mesh)
}

fn lines(bytes: &[u8]) -> impl Iterator<Item = &[u8]> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    // CR alone also ends a line; CR LF is one end, and its CR is trimmed as white space.
    let only_cr = !bytes.contains(&b'\n');
    bytes.split(move |b| if only_cr { *b == b'\r' } else { *b == b'\n' })
}

fn number(word: &[u8]) -> Result<f32, String> {
    let parsed = std::str::from_utf8(word).ok().and_then(|w| w.parse::<f32>().ok());
    parsed.filter(|n| n.is_finite()).ok_or_else(|| {
        let shown: String = String::from_utf8_lossy(word).chars().take(40).collect();
        format!("found `{shown}`, expected a finite number (of at most 3.4e38)")
    })
}
