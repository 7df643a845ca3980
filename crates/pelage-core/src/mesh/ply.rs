//! Reads PLY files, ASCII and binary, by ply-rs-bw.

use super::read::Limits;
use super::{Mesh, colors, polygon};
use crate::{Error, Result};
use glam::{DVec3, Vec2, Vec3};
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType, ScalarType,
};
use std::io::Read;
use std::path::Path;

/// Reads a PLY file's content; `file` is the name in messages.
///
/// Colours of bytes or 16-bit integers are taken as sRGB, floating-point ones as linear. uv come
/// from the faces (`texcoord`) or the vertices (`s t`, `u v`, `texture_u texture_v`). All faces are
/// one section.
///
/// # Errors
/// [`Error::Scene`], with the line in ASCII files, for a file that is damaged, has no faces or is
/// beyond `limits`.
pub fn parse(bytes: &[u8], file: &Path, limits: &Limits) -> Result<Mesh> {
    let (head, body) = split(bytes)
        .ok_or_else(|| Error::fault(file, "the header of the PLY file has no line `end_header`"))?;
    let fault = |e: ParseError| {
        let text = e.to_string();
        // The library's messages have several lines, the first of which says what is wrong.
        let first = text.lines().next().unwrap_or_default();
        let message = first.strip_prefix("Line ").and_then(|t| t.split_once(": ")).map_or(first, |(_, m)| m);
        let detail = |start: &str| {
            let line = text.lines().skip(1).find_map(|l| l.trim().strip_prefix(start));
            line.map(|l| l.chars().take(80).collect::<String>())
        };
        let message = match (message, detail("String: "), detail("Error: ")) {
            ("Couldn't parse line.", Some(line), _) => {
                format!("found the line {line} in the header of a PLY file")
            }
            (_, Some(line), Some(error)) if message.starts_with("Couldn't") => {
                format!("found the line {line}: {error}")
            }
            _ => format!("cannot be read as PLY: {message}"),
        };
        Error::fault_at(file, e.line().unwrap_or(0), message)
    };
    let mut reader = Reader::new(std::io::BufReader::new(head.as_slice().chain(body)));
    let header = Parser::<Skipped>::new().read_header(&mut reader).map_err(fault)?;
    check_counts(&header, body.len() as u64, file, limits)?;
    let (mut vertices, mut faces, mut strips) = (None, Vec::new(), Vec::new());
    let mut left_out = Vec::new();
    for element in header.elements.values() {
        match element.name.as_str() {
            "vertex" => {
                let parser = Parser::<Vertex>::new();
                vertices =
                    Some(parser.read_payload_for_element(&mut reader, element, &header).map_err(fault)?);
            }
            "face" => {
                let parser = Parser::<Face>::new();
                faces = parser.read_payload_for_element(&mut reader, element, &header).map_err(fault)?;
            }
            "tristrips" => {
                let parser = Parser::<Face>::new();
                strips = parser.read_payload_for_element(&mut reader, element, &header).map_err(fault)?;
            }
            name => {
                let parser = Parser::<Skipped>::new();
                parser.read_payload_for_element(&mut reader, element, &header).map_err(fault)?;
                left_out.push(format!("{} elements \"{name}\" left out", element.count));
            }
        }
    }
    let vertices = vertices.ok_or_else(|| Error::fault(file, "found no element `vertex`"))?;
    faces.extend(strips.iter().flat_map(|strip| triangles_of(&strip.corners)));
    if faces.is_empty() {
        let found =
            format!("found {} vertices and no faces, expected a mesh and no point cloud", vertices.len());
        return Err(Error::fault(file, found));
    }
    let mut mesh = Mesh { notes: left_out, ..Mesh::default() };
    add_vertices(&mut mesh, &vertices, header.elements.get("vertex"), file)?;
    add_faces(&mut mesh, &faces, &vertices, file, limits)?;
    Ok(mesh)
}

/// The header, cleaned of what the library does not read, and the rest.
fn split(bytes: &[u8]) -> Option<(Vec<u8>, &[u8])> {
    const END: &[u8] = b"end_header";
    let mut at = 0;
    loop {
        let end = at + bytes[at..].iter().take(1 << 20).position(|b| matches!(b, b'\n' | b'\r'))?;
        let is_last = bytes[at..end].trim_ascii() == END;
        at = if bytes[end..].starts_with(b"\r\n") { end + 2 } else { end + 1 };
        if is_last {
            break;
        }
    }
    // Comments in any encoding, lines that end with CR.
    let mut head = Vec::with_capacity(at);
    for (i, byte) in bytes[..at].iter().enumerate() {
        match byte {
            b'\r' if bytes.get(i + 1) == Some(&b'\n') => {}
            b'\r' => head.push(b'\n'),
            0x80.. => head.push(b'?'),
            byte => head.push(*byte),
        }
    }
    Some((head, &bytes[at..]))
}

/// Refuses counts that the file is too short for, so that no loop runs and no memory is taken for
/// them.
fn check_counts(header: &Header, body: u64, file: &Path, limits: &Limits) -> Result<()> {
    let size = |t: &ScalarType| match t {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    };
    let least = |element: &ElementDef| -> u64 {
        let properties = element.properties.values().map(|p| match &p.data_type {
            PropertyType::Scalar(t) | PropertyType::List(t, _) => match header.encoding {
                // A digit and a space.
                Encoding::Ascii => 2,
                _ => size(t),
            },
        });
        properties.sum()
    };
    let mut needed = 0_u64;
    for element in header.elements.values() {
        let least = least(element);
        if least == 0 && element.count > 0 {
            let message = format!("found {} elements \"{}\" without properties", element.count, element.name);
            return Err(Error::fault(file, message));
        }
        needed = needed.saturating_add(least.saturating_mul(element.count as u64));
        match element.name.as_str() {
            "vertex" => limits.check(file, element.count as u64, 0)?,
            "face" => limits.check(file, 0, element.count as u64)?,
            _ => {}
        }
    }
    // The last line of a text needs no end.
    if needed > body + 1 {
        return Err(Error::fault(
            file,
            format!(
                "found {body} bytes after the header, expected at least {needed} for the counts that it gives: \
                 the file is cut short or a count is wrong"
            ),
        ));
    }
    Ok(())
}

fn add_vertices(
    mesh: &mut Mesh,
    vertices: &[Vertex],
    element: Option<&ElementDef>,
    file: &Path,
) -> Result<()> {
    let has =
        |names: &[&str]| names.iter().all(|name| element.is_some_and(|e| e.properties.contains_key(*name)));
    if !has(&["x", "y", "z"]) {
        return Err(Error::fault(file, "found vertices without x, y and z"));
    }
    for (i, v) in vertices.iter().enumerate() {
        let p = DVec3::from_array(v.position).as_vec3();
        if !p.is_finite() {
            let message =
                format!("vertex {i} is at {:?}, expected finite numbers of at most 3.4e38", v.position);
            return Err(Error::fault(file, message));
        }
        mesh.positions.push(p);
    }
    let colored = has(&["red", "green", "blue"]) || has(&["r", "g", "b"]) || has(&["diffuse_red"]);
    if colored {
        let color = |v: &Vertex| Vec3::new(v.color[0], v.color[1], v.color[2]);
        mesh.colors = vertices.iter().map(color).collect();
        mesh.srgb = vertices.iter().any(|v| v.integer_color);
        let notes = colors::to_unit_range(&mut mesh.colors);
        mesh.notes.extend(notes);
        if vertices.iter().any(|v| v.color[3] < 1.0) {
            let alpha = |v: &Vertex| if v.color[3].is_finite() { v.color[3].clamp(0.0, 1.0) } else { 1.0 };
            mesh.alphas = vertices.iter().map(alpha).collect();
        }
    }
    Ok(())
}

fn add_faces(
    mesh: &mut Mesh,
    faces: &[Face],
    vertices: &[Vertex],
    file: &Path,
    limits: &Limits,
) -> Result<()> {
    let count = vertices.len();
    let of_faces = faces.iter().all(|f| f.uv.len() == 2 * f.corners.len());
    let of_vertices = vertices.iter().all(|v| v.uv.iter().all(|c| c.is_some()));
    let some_uv = faces.iter().any(|f| !f.uv.is_empty());
    mesh.corner_uv = (of_faces || of_vertices).then(Vec::new);
    if some_uv && !of_faces && !of_vertices {
        mesh.notes.push("some faces have no uv: the mesh is read without uv".into());
    }
    let mut cutter = polygon::Cutter::new(&mesh.positions);
    let mut short = 0;
    for (i, face) in faces.iter().enumerate() {
        if let Some(bad) = face.corners.iter().find(|c| **c < 0 || **c >= count as i64) {
            let message = format!("face {i} has the corner {bad}, expected 0 to {}", count as i64 - 1);
            return Err(Error::fault(file, message));
        }
        short += usize::from(face.corners.len() < 3);
        let corners: Vec<u32> = face.corners.iter().map(|c| *c as u32).collect();
        let cuts = cutter.cut(&mesh.positions, &corners);
        mesh.triangles.extend(cuts.iter().map(|t| t.map(|k| corners[k])));
        limits.check(file, 0, mesh.triangles.len() as u64)?;
        if let Some(corner_uv) = &mut mesh.corner_uv {
            let uv = |k: usize| match of_faces {
                true => Vec2::new(face.uv[2 * k], face.uv[2 * k + 1]),
                false => Vec2::from_array(vertices[corners[k] as usize].uv.map(|c| c.unwrap_or(0.0))),
            };
            let finite = |uv: Vec2| if uv.is_finite() { uv } else { Vec2::ZERO };
            corner_uv.extend(cuts.iter().map(|t| t.map(|k| finite(uv(k)))));
        }
    }
    if short > 0 {
        mesh.repairs.push(format!("{short} faces with fewer than three corners dropped"));
    }
    cutter.report(mesh);
    Ok(())
}

/// The triangles of a strip; -1 begins a new one.
fn triangles_of(strip: &[i64]) -> Vec<Face> {
    let triangles = strip.split(|c| *c == -1).flat_map(|part| {
        part.windows(3).enumerate().map(|(k, t)| match k % 2 {
            0 => vec![t[0], t[1], t[2]],
            _ => vec![t[1], t[0], t[2]],
        })
    });
    triangles.map(|corners| Face { corners, uv: Vec::new() }).collect()
}

/// An element that is not used.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

struct Vertex {
    position: [f64; 3],
    color: [f32; 4],
    integer_color: bool,
    uv: [Option<f32>; 2],
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self { position: [0.0; 3], color: [1.0; 4], integer_color: false, uv: [None; 2] }
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some((value, largest)) = scalar(&property) else { return PropertyAccessResult::Ignored };
        match name {
            "x" => self.position[0] = value,
            "y" => self.position[1] = value,
            "z" => self.position[2] = value,
            "s" | "u" | "texture_u" | "texture_s" => self.uv[0] = Some(value as f32),
            "t" | "v" | "texture_v" | "texture_t" => self.uv[1] = Some(value as f32),
            _ => {
                let channel = match name.strip_prefix("diffuse_").unwrap_or(name) {
                    "red" | "r" => 0,
                    "green" | "g" => 1,
                    "blue" | "b" => 2,
                    "alpha" | "a" => 3,
                    _ => return PropertyAccessResult::Ignored,
                };
                self.integer_color |= largest.is_some() && channel < 3;
                self.color[channel] = (value / largest.unwrap_or(1.0)) as f32;
            }
        }
        PropertyAccessResult::Set
    }
}

#[derive(Default)]
struct Face {
    corners: Vec<i64>,
    /// u and v of each corner, or nothing.
    uv: Vec<f32>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self::default()
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        match name {
            "vertex_indices" | "vertex_index" => self.corners = integers(property).unwrap_or_default(),
            "texcoord" => match property {
                Property::ListFloat(list) => self.uv = list,
                Property::ListDouble(list) => self.uv = list.iter().map(|v| *v as f32).collect(),
                _ => return PropertyAccessResult::UnsupportedType,
            },
            _ => return PropertyAccessResult::Ignored,
        }
        PropertyAccessResult::Set
    }
}

/// A number, and for integers the largest one of their type.
fn scalar(property: &Property) -> Option<(f64, Option<f64>)> {
    Some(match *property {
        Property::Char(v) => (v.into(), Some(i8::MAX.into())),
        Property::UChar(v) => (v.into(), Some(u8::MAX.into())),
        Property::Short(v) => (v.into(), Some(i16::MAX.into())),
        Property::UShort(v) => (v.into(), Some(u16::MAX.into())),
        // A wider type holds bytes.
        Property::Int(v) => (v.into(), Some(255.0)),
        Property::UInt(v) => (v.into(), Some(255.0)),
        Property::Float(v) => (v.into(), None),
        Property::Double(v) => (v, None),
        _ => return None,
    })
}

fn integers(property: Property) -> Option<Vec<i64>> {
    Some(match property {
        Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
        Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
        Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
        Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
        Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
        Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
        _ => return None,
    })
}
