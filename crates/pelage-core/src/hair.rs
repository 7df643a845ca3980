//! Strands in Cem Yuksel's HAIR file format, read and written.
//!
//! Little endian. A header of 128 bytes: "HAIR", counts, which arrays follow, defaults for the
//! others, 88 bytes of text. Then the arrays: segments (u16 per strand), points (3 f32 each),
//! thickness and transparency (f32 per point), colours (3 f32 per point).
// [YukselHair]

use crate::files::write_buffered;
use crate::{Error, Result};
use glam::Vec3;
use std::io::{self, Write};
use std::path::Path;

const HEADER: usize = 128;
const INFO: usize = 88;
const SEGMENTS: u32 = 1;
const POINTS: u32 = 2;
const THICKNESS: u32 = 4;
const TRANSPARENCY: u32 = 8;
const COLORS: u32 = 16;

/// The content of a HAIR file.
#[derive(Debug, Clone, PartialEq)]
pub struct HairFile {
    /// Points of all strands, root first, strand after strand; in files written by this program cm,
    /// world space.
    pub points: Vec<Vec3>,
    /// Segments of each strand: one fewer than its points.
    pub segments: Vec<u16>,
    /// Diameter at each point, in the unit of the points; empty: `default_thickness` everywhere.
    pub thickness: Vec<f32>,
    /// Transparency (1 - opacity) at each point; empty: `default_transparency` everywhere.
    pub transparency: Vec<f32>,
    /// Linear RGB at each point; empty: `default_color` everywhere.
    pub colors: Vec<Vec3>,
    /// Diameter where there is no array.
    pub default_thickness: f32,
    /// Transparency where there is no array.
    pub default_transparency: f32,
    /// Colour where there is no array.
    pub default_color: Vec3,
    /// Text for readers; at most 88 bytes are written.
    pub info: String,
}

impl Default for HairFile {
    fn default() -> Self {
        Self {
            points: Vec::new(),
            segments: Vec::new(),
            thickness: Vec::new(),
            transparency: Vec::new(),
            colors: Vec::new(),
            default_thickness: 0.005,
            default_transparency: 0.0,
            default_color: Vec3::ONE,
            info: format!("pelage {}, cm", env!("CARGO_PKG_VERSION")),
        }
    }
}

impl HairFile {
    /// The points of each strand, with the number of its first point.
    pub fn strands(&self) -> impl Iterator<Item = (usize, &[Vec3])> {
        let mut first = 0;
        self.segments.iter().map(move |segments| {
            let start = first;
            first += usize::from(*segments) + 1;
            (start, self.points.get(start..first).unwrap_or_default())
        })
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`Error::Io`] where it cannot be read, [`Error::Scene`] where it is not a complete and
    /// consistent HAIR file.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).map_err(|e| Error::io(path, e))?;
        Self::from_bytes(&bytes).map_err(|message| Error::fault(path, message))
    }

    /// Writes a file atomically: it appears complete or not at all.
    ///
    /// # Errors
    /// [`Error::Unsupported`] where the arrays do not fit each other; [`Error::Io`] where it cannot
    /// be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        self.check().map_err(|m| Error::Unsupported(format!("{}: not written: {m}", path.display())))?;
        write_buffered(path, |out| Ok(self.to_writer(out)?))
    }

    /// Reads the bytes of a file; the error says what was found and what was expected.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        if !bytes.starts_with(b"HAIR") {
            return Err(
                "found other data, expected a HAIR file, which would begin with the letters HAIR".into()
            );
        }
        if bytes.len() < HEADER {
            return Err(format!("truncated: found {} bytes, expected a header of {HEADER}", bytes.len()));
        }
        let word = |at: usize| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        let float = |at: usize| f32::from_bits(word(at));
        let (strands, points, flags, default_segments) = (word(4), word(8), word(12), word(16));
        if flags & POINTS == 0 {
            return Err(format!(
                "found flags {flags:#x} without a point array, which every HAIR file must have"
            ));
        }
        // The size is checked before anything is allocated, so that forged counts cost nothing.
        let (n, p) = (u64::from(strands), u64::from(points));
        let array = |flag: u32, bytes: u64| if flags & flag != 0 { bytes } else { 0 };
        let expected = HEADER as u64
            + array(SEGMENTS, 2 * n)
            + 12 * p
            + array(THICKNESS, 4 * p)
            + array(TRANSPARENCY, 4 * p)
            + array(COLORS, 12 * p);
        if bytes.len() as u64 != expected {
            let how = if (bytes.len() as u64) < expected { "truncated or forged" } else { "too long" };
            return Err(format!(
                "{how}: found {} bytes, expected {expected} for {strands} strands and {points} points",
                bytes.len()
            ));
        }
        let mut rest = &bytes[HEADER..];
        let mut take = |present: u32, size: u64| -> &[u8] {
            let (head, tail) = rest.split_at(if flags & present != 0 { size as usize } else { 0 });
            rest = tail;
            head
        };
        let floats = |bytes: &[u8]| -> Vec<f32> {
            bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
        };
        let vectors = |bytes: &[u8]| floats(bytes).chunks_exact(3).map(Vec3::from_slice).collect::<Vec<_>>();
        let segments = take(SEGMENTS, 2 * n);
        let segments = if flags & SEGMENTS != 0 {
            segments.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect()
        } else {
            // Each strand has a point at least, so the number of strands cannot exceed that of the
            // points.
            let each = u16::try_from(default_segments).map_err(|_| {
                format!("found {default_segments} segments per strand, expected at most 65535")
            })?;
            if n * (u64::from(each) + 1) != p {
                return Err(format!("found {points} points, expected {strands} strands of {each} segments"));
            }
            vec![each; strands as usize]
        };
        let hair = Self {
            segments,
            points: vectors(take(POINTS, 12 * p)),
            thickness: floats(take(THICKNESS, 4 * p)),
            transparency: floats(take(TRANSPARENCY, 4 * p)),
            colors: vectors(take(COLORS, 12 * p)),
            default_thickness: float(20),
            default_transparency: float(24),
            default_color: Vec3::new(float(28), float(32), float(36)),
            info: String::from_utf8_lossy(&bytes[HEADER - INFO..HEADER]).trim_end_matches('\0').to_owned(),
        };
        hair.check()?;
        Ok(hair)
    }

    /// Whether the arrays fit each other and hold finite numbers.
    fn check(&self) -> Result<(), String> {
        let expected: u64 = self.segments.iter().map(|s| u64::from(*s) + 1).sum();
        let points = self.points.len();
        if expected != points as u64 {
            return Err(format!(
                "found {points} points, expected {expected} for the segments of all strands"
            ));
        }
        if u32::try_from(points).is_err() {
            return Err(format!("found {points} points, expected at most {}", u32::MAX));
        }
        for (name, len) in [
            ("thickness", self.thickness.len()),
            ("transparency", self.transparency.len()),
            ("colours", self.colors.len()),
        ] {
            if len != 0 && len != points {
                return Err(format!(
                    "found {len} values of {name}, expected none or one for each of {points} points"
                ));
            }
        }
        if let Some(i) = self.points.iter().position(|p| !p.is_finite()) {
            return Err(format!("found point {i} at {}, expected finite numbers", self.points[i]));
        }
        if let Some(i) = self.thickness.iter().position(|t| !(t.is_finite() && *t >= 0.0)) {
            return Err(format!(
                "found thickness {i} = {}, expected a finite number not below 0",
                self.thickness[i]
            ));
        }
        if let Some(i) = self.transparency.iter().position(|t| !t.is_finite()) {
            return Err(format!(
                "found transparency {i} = {}, expected a finite number",
                self.transparency[i]
            ));
        }
        if let Some(i) = self.colors.iter().position(|c| !c.is_finite()) {
            return Err(format!("found colour {i} = {}, expected finite numbers", self.colors[i]));
        }
        Ok(())
    }

    fn to_writer(&self, out: &mut dyn Write) -> io::Result<()> {
        let present = |there: bool, flag: u32| if there { flag } else { 0 };
        let uniform = self.segments.windows(2).all(|w| w[0] == w[1]);
        let flags = POINTS
            | present(!uniform, SEGMENTS)
            | present(!self.thickness.is_empty(), THICKNESS)
            | present(!self.transparency.is_empty(), TRANSPARENCY)
            | present(!self.colors.is_empty(), COLORS);
        out.write_all(b"HAIR")?;
        let default_segments = u32::from(self.segments.first().copied().unwrap_or(0));
        for word in [self.segments.len() as u32, self.points.len() as u32, flags, default_segments] {
            out.write_all(&word.to_le_bytes())?;
        }
        let color = self.default_color;
        let mut float = |f: f32| out.write_all(&f.to_le_bytes());
        for f in [self.default_thickness, self.default_transparency, color.x, color.y, color.z] {
            float(f)?;
        }
        let mut info = [0; INFO];
        // Cut between characters.
        let end = (0..=INFO.min(self.info.len())).rev().find(|i| self.info.is_char_boundary(*i)).unwrap_or(0);
        info[..end].copy_from_slice(&self.info.as_bytes()[..end]);
        out.write_all(&info)?;
        if !uniform {
            for s in &self.segments {
                out.write_all(&s.to_le_bytes())?;
            }
        }
        let vectors = |v: &Vec<Vec3>| v.iter().flat_map(|v| v.to_array()).collect::<Vec<f32>>();
        let arrays =
            [vectors(&self.points), self.thickness.clone(), self.transparency.clone(), vectors(&self.colors)];
        for f in arrays.iter().flatten() {
            out.write_all(&f.to_le_bytes())?;
        }
        Ok(())
    }
}
