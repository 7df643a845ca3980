//! Which kind of mesh a file holds: by its content first, by its extension where the content does
//! not say.

use std::io::Read;
use std::path::Path;

/// The kinds of mesh files that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeshKind {
    /// Wavefront OBJ.
    Obj,
    /// glTF 2.0: JSON with buffers in files or data URIs.
    Gltf,
    /// glTF 2.0 in one binary file.
    Glb,
    /// PLY, ASCII or binary.
    Ply,
    /// STL, ASCII or binary.
    Stl,
}

impl MeshKind {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Obj, Self::Gltf, Self::Glb, Self::Ply, Self::Stl];

    /// The name that messages use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Obj => "Wavefront OBJ",
            Self::Gltf => "glTF",
            Self::Glb => "binary glTF (GLB)",
            Self::Ply => "PLY",
            Self::Stl => "STL",
        }
    }

    /// As "a PLY mesh".
    pub fn mesh(self) -> String {
        format!("{} {} mesh", if self == Self::Stl { "an" } else { "a" }, self.name())
    }

    /// The usual extension, in lower case, without the dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Gltf => "gltf",
            Self::Glb => "glb",
            Self::Ply => "ply",
            Self::Stl => "stl",
        }
    }

    fn of_extension(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        Self::ALL.into_iter().find(|kind| kind.extension() == extension)
    }
}

/// Bytes from the beginning of a file that decide its kind.
const HEAD: u64 = 1 << 16;

/// The kind of mesh that the file at `path` holds; `None` if it is no mesh or cannot be read. A
/// scene file is never taken for a mesh, whatever its name.
pub fn kind_of(path: &Path) -> Option<MeshKind> {
    let (head, size) = head_of(path).ok()?;
    kind_of_head(&head, size, path)
}

/// The beginning of a file and its size, bytes.
pub(super) fn head_of(path: &Path) -> std::io::Result<(Vec<u8>, u64)> {
    let file = std::fs::File::open(path)?;
    let size = file.metadata()?.len();
    let mut head = Vec::new();
    file.take(HEAD).read_to_end(&mut head)?;
    Ok((head, size))
}

/// As [`kind_of`], for the beginning of a file of `size` bytes.
pub(crate) fn kind_of_head(head: &[u8], size: u64, path: &Path) -> Option<MeshKind> {
    kind_of_content(head, size).or_else(|| {
        let foreign = not_a_mesh(head).is_some() || is_toml(head);
        MeshKind::of_extension(path).filter(|_| !foreign)
    })
}

fn kind_of_content(head: &[u8], size: u64) -> Option<MeshKind> {
    if head.starts_with(b"glTF") {
        return Some(MeshKind::Glb);
    }
    if [&b"ply\n"[..], b"ply\r", b"ply "].iter().any(|start| head.starts_with(start)) {
        return Some(MeshKind::Ply);
    }
    // A text never passes for this: its count would be above half a billion.
    if let Some(count) = head.get(80..84).and_then(|n| n.try_into().ok()).map(u32::from_le_bytes)
        && count > 0
        && size == 84 + 50 * u64::from(count)
    {
        return Some(MeshKind::Stl);
    }
    let text = head.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(head).trim_ascii_start();
    if text.first() == Some(&b'{') {
        return contains(text, b"\"asset\"").then_some(MeshKind::Gltf);
    }
    let words = |line: &[u8]| -> Vec<String> {
        let words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()).take(5);
        words.map(|w| String::from_utf8_lossy(w).to_ascii_lowercase()).collect()
    };
    let first = words(text.split(|b| matches!(b, b'\n' | b'\r')).next().unwrap_or_default());
    if first.first().is_some_and(|w| w == "solid") && first.get(1).is_none_or(|w| !w.starts_with('=')) {
        let lower = text.to_ascii_lowercase();
        if contains(&lower, b"facet") || contains(&lower, b"endsolid") {
            return Some(MeshKind::Stl);
        }
    }
    is_obj(text).then_some(MeshKind::Obj)
}

/// Statements of OBJ files.
const OBJ_WORDS: [&[u8]; 21] = [
    b"v", b"vt", b"vn", b"vp", b"f", b"l", b"p", b"o", b"g", b"s", b"usemtl", b"mtllib", b"mg", b"usemap",
    b"maplib", b"cstype", b"deg", b"curv", b"surf", b"parm", b"end",
];

/// Whether all complete lines are statements of OBJ, at least one of them a vertex.
fn is_obj(text: &[u8]) -> bool {
    let mut vertices = 0;
    let mut lines: Vec<&[u8]> = text.split(|b| matches!(b, b'\n' | b'\r')).collect();
    if text.len() as u64 + 8 >= HEAD {
        // The last line may be cut short.
        lines.pop();
    }
    let mut continued = false;
    for line in lines {
        let line = line.trim_ascii();
        let starts = !std::mem::replace(&mut continued, line.ends_with(b"\\"));
        if !starts || line.is_empty() || line.starts_with(b"#") {
            continue;
        }
        let mut words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        let keyword = words.next().unwrap_or_default();
        if !OBJ_WORDS.contains(&keyword) || words.next().is_some_and(|w| w.starts_with(b"=")) {
            return false;
        }
        vertices += usize::from(keyword == b"v");
    }
    vertices > 0
}

/// Whether the first line that is no comment is a table's head or a key with a value.
fn is_toml(head: &[u8]) -> bool {
    let text = head.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(head);
    let lines = text.split(|b| matches!(b, b'\n' | b'\r')).map(<[u8]>::trim_ascii);
    let Some(line) = lines.into_iter().find(|l| !l.is_empty() && !l.starts_with(b"#")) else { return false };
    let key = |b: &u8| b.is_ascii_alphanumeric() || b"_-.\"' \t".contains(b);
    match line.iter().position(|b| *b == b'=') {
        Some(at) => line[..at].iter().all(key),
        None => line.starts_with(b"[") && (line.ends_with(b"]") || contains(line, b"] #")),
    }
}

/// What a file is that is no mesh that can be read, and what to do about it.
pub(super) fn not_a_mesh(head: &[u8]) -> Option<(&'static str, &'static str)> {
    const EXPORT: &str = "export it as glTF, OBJ, PLY or STL";
    const IMAGE: &str = "name a mesh; images are maps of the groom";
    let known: [(&[u8], &str, &str); 17] = [
        (b"Kaydara FBX Binary", "an FBX file", EXPORT),
        (b"; FBX", "an FBX file", EXPORT),
        (b"PXR-USDC", "a USD file", EXPORT),
        (b"#usda", "a USD file", EXPORT),
        (b"BLENDER", "a Blender file", EXPORT),
        (b"Ogawa", "an Alembic file", EXPORT),
        (b"#VRML", "a VRML file", EXPORT),
        (b"OFF\n", "an OFF mesh", EXPORT),
        (b"OFF\r", "an OFF mesh", EXPORT),
        (b"<?xml", "an XML file (COLLADA, X3D?)", EXPORT),
        (b"PK\x03\x04", "a ZIP archive (USDZ, 3MF?)", "unpack it, or export it as glTF, OBJ, PLY or STL"),
        (b"\x1F\x8B", "a gzip archive", "unpack it"),
        (b"\x89PNG", "a PNG image", IMAGE),
        (b"\xFF\xD8\xFF", "a JPEG image", IMAGE),
        (b"\x76\x2F\x31\x01", "an OpenEXR image", IMAGE),
        (b"#?RADIANCE", "a Radiance image", IMAGE),
        (b"HAIR", "a HAIR file", "name the mesh that carries the hair"),
    ];
    let found = known.into_iter().find(|(magic, ..)| head.starts_with(magic));
    found.map(|(_, what, help)| (what, help)).or_else(|| {
        is_toml(head).then_some((
            "a text in TOML (a scene file?)",
            "give the mesh itself: an OBJ, glTF, GLB, PLY or STL file",
        ))
    })
}

fn contains(text: &[u8], part: &[u8]) -> bool {
    text.windows(part.len()).any(|w| w == part)
}
