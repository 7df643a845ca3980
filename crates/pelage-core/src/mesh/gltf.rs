//! Reads glTF 2.0, as JSON with buffers in files or data URIs, and as one binary file. The gltf
//! crate parses and checks the document; buffers are read here, with every offset checked.

mod accessor;
mod buffers;

use super::read::{Limits, guarded};
use super::{Mesh, MeshKind, Sections, colors};
use crate::scene::Units;
use crate::{Error, Result, SceneFault};
use ::gltf::json::{self, validation::Validate};
use ::gltf::mesh::Mode;
use ::gltf::{Document, Node, Primitive, Semantic, image};
use accessor::Accessors;
use glam::{Mat4, Vec2, Vec3};
use std::collections::BTreeMap;
use std::path::Path;

/// Extensions that compress what a mesh is made of.
const COMPRESSED: [&str; 4] = [
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "MESHOPT_compression",
];

/// Reads a glTF or GLB file's content; `file` is its name in messages, and buffers lie relative to
/// it. The nodes of the default scene (the first, where none is the default) are read with their
/// transforms; a section is a node's name and a material. Vertex colours are linear, as glTF has
/// them. Morph targets and skinning are left out.
///
/// # Errors
/// [`Error::Scene`] for a file that is damaged, compressed, without triangles or beyond `limits`;
/// [`Error::Io`] where a buffer's file cannot be read.
pub fn parse(bytes: &[u8], file: &Path, limits: &Limits) -> Result<Mesh> {
    guarded(file, MeshKind::Gltf, || {
        let (root, blob) = document_of(bytes, file)?;
        let document = Document::from_json_without_validation(root);
        let buffers = buffers::load(&document, blob, file, limits)?;
        let mut scene = Reader {
            file,
            limits,
            accessors: Accessors { buffers: &buffers },
            mesh: Mesh { unit: Some(Units::M), ..Mesh::default() },
            sections: Sections::default(),
            corner_uv: Vec::new(),
            without_uv: 0,
            colored: false,
            skipped: BTreeMap::new(),
        };
        scene.document(&document)?;
        scene.finish()
    })
}

/// The checked document and the binary chunk.
fn document_of(bytes: &[u8], file: &Path) -> Result<(json::Root, Option<Vec<u8>>)> {
    let fault = |message: String| Error::fault(file, message);
    let (text, blob) = if bytes.starts_with(b"glTF") {
        let version = bytes.get(4..8).map_or(0, |v| u32::from_le_bytes([v[0], v[1], v[2], v[3]]));
        if version != 2 {
            return Err(fault(format!("found glTF version {version}, expected 2")));
        }
        let glb = ::gltf::binary::Glb::from_slice(bytes)
            .map_err(|e| fault(format!("cannot be read as GLB: {e}: the file is cut short or damaged")))?;
        (glb.json, glb.bin.map(|bin| bin.into_owned()))
    } else {
        (bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes).into(), None)
    };
    let mut root: json::Root = json::deserialize::from_slice(&text).map_err(|e| {
        Error::fault_at(
            file,
            if blob.is_none() { e.line() } else { 0 },
            format!("cannot be read as glTF: {e}"),
        )
    })?;
    for extension in &root.extensions_required {
        if COMPRESSED.contains(&extension.as_str()) {
            return Err(Error::Scene(vec![SceneFault {
                file: file.to_owned(),
                line: 0,
                column: 0,
                message: format!("the mesh is compressed by {extension}, expected a glTF file without it"),
                help: Some(
                    "export it without compression of geometry, or unpack it (gltf-transform, gltfpack)"
                        .into(),
                ),
            }]));
        }
    }
    // Other extensions concern materials, lights and textures, or the types of accessors.
    root.extensions_required.clear();
    // The crate's own check takes these for granted.
    let primitives = root.meshes.iter().flat_map(|m| &m.primitives);
    let mut accessors = primitives.flat_map(|p| p.attributes.values());
    if let Some(bad) = accessors.find(|a| a.value() >= root.accessors.len()) {
        let (found, count) = (bad.value(), root.accessors.len());
        return Err(fault(format!("a mesh names accessor {found}, expected less than {count}")));
    }
    let mut faults = Vec::new();
    root.validate(&root, json::Path::new, &mut |path, error| {
        let path = path().to_string();
        // Bounds of positions are computed anew.
        if !path.ends_with(".min") && !path.ends_with(".max") {
            faults.push(format!("{path}: {error}"));
        }
    });
    match faults.len() {
        0 => Ok((root, blob)),
        n => {
            faults.truncate(5);
            let more = if n > 5 { format!(" and {} more faults", n - 5) } else { String::new() };
            Err(fault(format!("is no valid glTF: {}{more}", faults.join("; "))))
        }
    }
}

struct Reader<'a> {
    file: &'a Path,
    limits: &'a Limits,
    accessors: Accessors<'a>,
    mesh: Mesh,
    sections: Sections,
    corner_uv: Vec<[Vec2; 3]>,
    /// Triangles without uv.
    without_uv: usize,
    colored: bool,
    /// What was left out, with its count.
    skipped: BTreeMap<&'static str, usize>,
}

impl Reader<'_> {
    fn document(&mut self, document: &Document) -> Result<()> {
        let Some(scene) = document.default_scene().or_else(|| document.scenes().next()) else {
            // A file without a scene is a library of meshes.
            for mesh in document.meshes() {
                for primitive in mesh.primitives() {
                    self.primitive(&primitive, Mat4::IDENTITY, mesh.name().unwrap_or_default())?;
                }
            }
            return Ok(());
        };
        let others = document.scenes().len().saturating_sub(1);
        if others > 0 {
            self.skipped.insert("other scenes", others);
        }
        // A node has one parent at most; damaged files have cycles.
        let mut seen = vec![false; document.nodes().len()];
        let mut stack: Vec<(Node<'_>, Mat4)> = scene.nodes().map(|n| (n, Mat4::IDENTITY)).collect();
        stack.reverse();
        while let Some((node, parent)) = stack.pop() {
            if std::mem::replace(&mut seen[node.index()], true) {
                let message = format!("node {} is the child of two nodes or of itself", node.index());
                return Err(Error::fault(self.file, message));
            }
            let world = parent * Mat4::from_cols_array_2d(&node.transform().matrix());
            if let Some(mesh) = node.mesh() {
                let name = node.name().or(mesh.name()).unwrap_or_default();
                for primitive in mesh.primitives() {
                    self.primitive(&primitive, world, name)?;
                }
                *self.skipped.entry("skinned meshes, in their rest pose").or_default() +=
                    usize::from(node.skin().is_some());
            }
            let children: Vec<_> = node.children().collect();
            stack.extend(children.into_iter().rev().map(|child| (child, world)));
        }
        Ok(())
    }

    fn primitive(&mut self, primitive: &Primitive<'_>, world: Mat4, group: &str) -> Result<()> {
        if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            *self.skipped.entry("primitives of points or lines left out").or_default() += 1;
            return Ok(());
        }
        let Some(accessor) = primitive.get(&Semantic::Positions) else {
            *self.skipped.entry("primitives without positions left out").or_default() += 1;
            return Ok(());
        };
        let damaged = |what: &str, message: String| {
            Error::fault(self.file, format!("{what} of \"{group}\": {message}"))
        };
        self.limits.check(self.file, (self.mesh.positions.len() + accessor.count()) as u64, 0)?;
        let positions = self.accessors.vectors::<3>(&accessor).map_err(|m| damaged("positions", m))?;
        let indices = match primitive.indices() {
            Some(accessor) => self.accessors.indices(&accessor).map_err(|m| damaged("indices", m))?,
            None => (0..positions.len() as u32).collect(),
        };
        if let Some(bad) = indices.iter().find(|i| **i as usize >= positions.len()) {
            let message = format!("found {bad}, expected 0 to {}", positions.len() as i64 - 1);
            return Err(damaged("indices", message));
        }
        let material = primitive.material();
        let base = material.pbr_metallic_roughness();
        let texture = base.base_color_texture();
        let set = texture.as_ref().map_or(0, |t| t.tex_coord());
        let uv = match primitive.get(&Semantic::TexCoords(set)) {
            Some(a) => Some(self.accessors.vectors::<2>(&a).map_err(|m| damaged("uv", m))?),
            None => None,
        };
        let given = match primitive.get(&Semantic::Colors(0)) {
            Some(a) => Some(self.accessors.colors(&a).map_err(|m| damaged("vertex colours", m))?),
            None => None,
        };
        let sizes = [uv.as_ref().map(Vec::len), given.as_ref().map(Vec::len)];
        if let Some(n) = sizes.into_iter().flatten().find(|n| *n != positions.len()) {
            let message = format!("found {n} values, expected {}, one for each vertex", positions.len());
            return Err(damaged("attributes", message));
        }

        let first = self.mesh.positions.len() as u32;
        for p in &positions {
            let at = world.transform_point3(Vec3::from_array(*p));
            if !at.is_finite() {
                return Err(damaged(
                    "positions",
                    format!("found {p:?}, which is {at}, expected finite numbers"),
                ));
            }
            self.mesh.positions.push(at);
        }
        let before = self.mesh.colors.len();
        match given {
            Some(given) => {
                self.colored = true;
                for [r, g, b, a] in given {
                    self.mesh.colors.push(Vec3::new(r, g, b));
                    self.mesh.alphas.push(a.clamp(0.0, 1.0));
                }
            }
            None => {
                self.mesh.colors.resize(before + positions.len(), Vec3::ONE);
                self.mesh.alphas.resize(before + positions.len(), 1.0);
            }
        }
        let mut triangles = triangles_of(primitive.mode(), &indices);
        self.limits.check(self.file, 0, (self.mesh.triangles.len() + triangles.len()) as u64)?;
        // A mirror turns triangles over.
        if world.determinant() < 0.0 {
            triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        self.corner_uv.extend(triangles.iter().map(|t| {
            // glTF's v goes down from the upper edge of an image.
            t.map(|i| {
                uv.as_ref().map_or(Vec2::ZERO, |uv| Vec2::new(uv[i as usize][0], 1.0 - uv[i as usize][1]))
            })
        }));
        self.without_uv += if uv.is_none() { triangles.len() } else { 0 };
        let section = self.sections.index(group, material.name().unwrap_or_default());
        self.mesh.section_of.resize(self.mesh.section_of.len() + triangles.len(), section);
        self.mesh.triangles.extend(triangles.iter().map(|t| t.map(|i| i + first)));
        if material.index().is_some() {
            let [r, g, b, _] = base.base_color_factor();
            let map = texture.and_then(|t| t.texture().source()).and_then(|i| self.map_of(&i));
            let section = &mut self.sections.list[section as usize];
            section.base_color = Some([r, g, b].map(|v| if v.is_finite() { v.clamp(0.0, 1.0) } else { 1.0 }));
            section.base_map = map;
        }
        Ok(())
    }

    /// The path of an image; `None` with a note where it lies within the file.
    fn map_of(&mut self, image: &image::Image<'_>) -> Option<String> {
        match image.source() {
            image::Source::Uri { uri, .. } if !uri.starts_with("data:") => {
                let path = buffers::beside(self.file, uri);
                Some(path.display().to_string())
            }
            _ => {
                let note = format!(
                    "the image \"{}\" lies within the file: save it as a file of its own to use it as a map",
                    image.name().unwrap_or("without a name")
                );
                if !self.mesh.notes.contains(&note) {
                    self.mesh.notes.push(note);
                }
                None
            }
        }
    }

    fn finish(mut self) -> Result<Mesh> {
        if self.mesh.triangles.is_empty() {
            let mut message = "found no triangles in the glTF file's scene, expected one or more".to_owned();
            for (what, n) in self.skipped.iter().filter(|(_, n)| **n > 0) {
                message += &format!("; {n} {what}");
            }
            return Err(Error::fault(self.file, message));
        }
        let mut mesh = self.mesh;
        mesh.sections = self.sections.list;
        if !self.colored {
            mesh.colors.clear();
        }
        let clamped = colors::clamped(&mut mesh.colors);
        mesh.notes.extend(clamped);
        if mesh.alphas.iter().all(|a| *a == 1.0) {
            mesh.alphas.clear();
        }
        let finite = self.corner_uv.as_flattened().iter().all(|uv| uv.is_finite());
        if self.without_uv == 0 && finite {
            mesh.corner_uv = Some(self.corner_uv);
        } else if self.without_uv < mesh.triangles.len() {
            let what = if finite { "have no uv" } else { "or others have no finite uv" };
            mesh.notes.push(format!("{} triangles {what}: the mesh is read without uv", self.without_uv));
        }
        for (what, n) in std::mem::take(&mut self.skipped).iter().filter(|(_, n)| **n > 0) {
            mesh.notes.push(format!("{n} {what}"));
        }
        Ok(mesh)
    }
}

fn triangles_of(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let turned =
                |(k, t): (usize, &[u32])| if k % 2 == 0 { [t[0], t[1], t[2]] } else { [t[1], t[0], t[2]] };
            indices.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => match indices {
            [centre, rest @ ..] => rest.windows(2).map(|t| [*centre, t[0], t[1]]).collect(),
            [] => Vec::new(),
        },
        _ => indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}
