//! Exports the fur as glTF 2.0: the skin as an ordinary mesh, what shells and fins need in
//! addition, and the objects.
//!
//! `fur.gltf` and `fur.bin` hold the skin as first mesh, in centimetres, under a node that scales
//! to glTF's metres. Its attributes:
//!
//! | attribute | contents |
//! |---|---|
//! | `POSITION`, `NORMAL` | the skin |
//! | `TEXCOORD_0` | the skin's own uv, if it has one; v downwards, as in glTF |
//! | `TEXCOORD_1` (or `_0` for a skin without uv) | place in the fur's textures, one unit per repeat; v upwards, as in the textures |
//! | `COLOR_0` | colour of the bare skin, linear |
//! | `_FUR` | from the skin to the tip of the longest hair, cm |
//! | `_FUR_1`, `_FUR_2` | inner control points of the hair's Bézier curve, relative to the skin, cm |
//! | `_FUR_NORMAL` | direction of upright hair |
//! | `_FUR_COLOR` | factor on the textures' colour |
//!
//! The scene's objects follow as ordinary meshes under nodes of their own, with glTF's materials.
//!
//! The root's `extras.pelage` is an [`Extras`]: metadata of the textures, edges for fins, settings,
//! view and lights.
// [GLTF2]

mod objects;
mod points;

pub use objects::notes;
pub use points::{Clothed, FinEdge, clothe, fin_edges};

use super::{FurTextures, Manifest, Texture};
use crate::shellfin::{FIN_TEXELS, fin_depth, stray_variance};
use glam::Vec3;
use pelage_core::scene::{Background, BakeSource, Camera, FinFade, LightingTable, Tonemap};
use pelage_core::{Error, Result, World, files};
use pelage_fur::groom;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The document.
pub const GLTF_FILE: &str = "fur.gltf";
/// Its buffer.
pub const BIN_FILE: &str = "fur.bin";
/// The array texture of the layers, in the same folder as the document.
pub const LAYERS_FILE: &str = "layers.ktx2";
/// The texture of the fins, in the same folder as the document.
pub const FIN_FILE: &str = "fin.ktx2";

/// `extras.pelage` of the document.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Extras {
    /// Version of this format: 1.
    pub version: u32,
    /// Metadata of the textures.
    pub manifest: Manifest,
    /// File of the layers: KTX2 array texture, sRGB, premultiplied in linear light.
    pub layers_texture: String,
    /// File of the fin: KTX2 texture, encoded as the layers; v runs from the skin to the tips.
    pub fin_texture: String,
    /// Index of the `TEXCOORD` that holds the place in the layers.
    pub fur_texcoord: u32,
    /// Directions of the hairs in each layer, innermost first; means of coverage and colour are in
    /// the manifest's `summary`.
    pub strays: Vec<Stray>,
    /// Variance per axis of the guard hairs' direction around that of the hair.
    pub guard_variance: f32,
    /// The edges that may carry fins.
    pub fins: FinAccessors,
    /// Settings.
    pub shells: ShellSettings,
    /// The scene's view.
    pub view: View,
}

/// Directions of the hairs in a layer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Stray {
    /// Fraction of the coverage that is guard hair, which follows the direction of the hair.
    pub guard: f32,
    /// All other hair follows the sum of the upright direction and this vector, world space; if
    /// absent, it follows the direction of the hair too.
    pub lean: Option<[f32; 3]>,
    /// Variance per axis of the other hair's direction.
    pub variance: f32,
}

/// Accessors of the fins, one element per edge.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FinAccessors {
    /// VEC4 of unsigned integers: the two vertices of the edge, the third vertex of the face in
    /// whose direction it runs, and that of the neighbour; 4294967295 if there is no neighbour.
    pub edges: u32,
    /// VEC2: u of the fin texture at both ends of the edge.
    pub u: u32,
    /// Depth of fur that a fin represents, relative to that of its texture: transmittances of
    /// texels are raised to this power before mips are made.
    pub depth: f32,
    /// Rows of texels in the coarsest mip of the fin, because light varies from skin to tip.
    pub rows: u32,
}

/// Settings for drawing: the part of the scene's `[shells]` that a client needs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ShellSettings {
    /// Draw the shells.
    pub shells: bool,
    /// Draw the fins.
    pub fins: bool,
    /// How fins fade in towards the silhouette.
    pub fade: FinFade,
    /// Cosine below which an edge counts as near the silhouette.
    pub fin_threshold: f32,
    /// Shells write depth where they are not transparent.
    pub depth_write: bool,
    /// Coverage increases with the path length through a layer; with fins, shells fade where they
    /// are seen edge-on.
    pub slanted: bool,
    /// Number of shells drawn, from the skin outwards; layer l is at height (l + 0.5) /
    /// `manifest.layers` of the hair.
    pub layers: u32,
    /// The lighting table.
    pub table: LightingTable,
}

/// A view in the units of scene files: lengths in cm, angles in degrees, colours in linear RGB.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// Background colour; absent if the scene has a background image.
    pub background: Option<[f32; 3]>,
    /// Exposure, stops.
    pub exposure: f32,
    /// Tone mapping.
    pub tonemap: Tonemap,
    /// All lights, including those derived from an environment map.
    pub lights: Vec<ViewLight>,
}

/// A directional light.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ViewLight {
    /// Unit vector towards the light.
    pub direction: [f32; 3],
    /// Irradiance on a surface that faces the light.
    pub irradiance: [f32; 3],
}

/// Writes [`GLTF_FILE`], [`BIN_FILE`] and the images of objects into the folder `dir` and returns
/// their paths. The textures to which the document refers ([`LAYERS_FILE`], [`FIN_FILE`]) are not
/// written here.
///
/// # Errors
/// [`Error::Unsupported`] if `lapped` belongs to another skin, if sizes of the textures are not
/// positive, if the scene maps by uv and the skin has none, or if a map of `[shells]` is not
/// loaded; [`Error::Io`].
pub fn write(
    world: &World,
    lapped: &crate::lapped::Lapped,
    textures: &FurTextures,
    dir: &Path,
) -> Result<Vec<PathBuf>> {
    let clothed = clothe(world, lapped, &textures.manifest)?;
    let edges = fin_edges(world, &clothed, textures.manifest.fin_length);
    let (document, bin) = document(world, &clothed, &edges, textures)?;
    let (gltf, buffer) = (dir.join(GLTF_FILE), dir.join(BIN_FILE));
    // The document is written last: when it exists, so do its buffer and its images.
    let images = objects::write_images(world, dir)?;
    files::write_buffered(&buffer, |out| Ok(out.write_all(&bin)?))?;
    files::write_buffered(&gltf, |out| Ok(writeln!(out, "{document:#}")?))?;
    Ok([gltf, buffer].into_iter().chain(images).collect())
}

/// The settings and the view of a world.
fn settings(world: &World, manifest: &Manifest) -> (ShellSettings, View) {
    let (shells, film) = (&world.scene.shells, &world.scene.film);
    let settings = ShellSettings {
        shells: shells.shells,
        fins: shells.fins,
        fade: shells.fade,
        fin_threshold: shells.fin_threshold,
        depth_write: shells.depth_write,
        slanted: shells.slanted,
        layers: shells.layers.unwrap_or(manifest.layers).min(manifest.layers),
        table: shells.table.clone(),
    };
    let lights = world
        .lights
        .iter()
        .map(|l| ViewLight { direction: l.direction.into(), irradiance: l.irradiance.into() });
    let view = View {
        camera: world.scene.camera.clone(),
        width: film.width,
        height: film.height,
        background: (film.background == Background::Color).then_some(film.background_color),
        exposure: film.exposure,
        tonemap: film.tonemap,
        lights: lights.collect(),
    };
    (settings, view)
}

/// Directions of the hairs in each layer, as `pelage render` draws the shells.
fn strays(world: &World, textures: &FurTextures) -> Result<Vec<Stray>> {
    let manifest = &textures.manifest;
    let (undercoat, fur) = (&world.scene.undercoat, groom::pack(world)?.undercoat);
    let covered = |texture: &Texture| texture.texels.iter().map(|t| f64::from(t[3])).sum::<f64>();
    let of_layer = |(l, layer): (usize, &Texture)| {
        let guard = textures.guard.get(l).map_or(0.0, |guard| covered(guard) / covered(layer).max(1e-12));
        let guard = guard.clamp(0.0, 1.0) as f32;
        let height = (l as f32 + 0.5) * world.scene.shells.spacing.unwrap_or(manifest.spacing);
        let variance = stray_variance(world, manifest.source, height);
        // The lean grows up to the undercoat's height.
        let lean = Vec3::from(fur.lean) * (height / undercoat.height.max().max(1e-6)).min(1.0);
        Stray { guard, lean: (manifest.source == BakeSource::Hybrid).then(|| lean.into()), variance }
    };
    Ok(textures.layers.iter().enumerate().map(of_layer).collect())
}

fn document(
    world: &World,
    clothed: &Clothed,
    edges: &[FinEdge],
    textures: &FurTextures,
) -> Result<(Value, Vec<u8>)> {
    let manifest = &textures.manifest;
    let mut bin = Bin::default();
    let (low, high) = clothed
        .positions
        .iter()
        .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
    let position = bin.floats(clothed.positions.iter().map(Vec3::to_array));
    bin.bound(position, json!(low.to_array()), json!(high.to_array()));
    let mut attributes = json!({
        "POSITION": position,
        "NORMAL": bin.floats(clothed.normals.iter().map(Vec3::to_array)),
        "COLOR_0": bin.floats(clothed.skin_colors.iter().map(Vec3::to_array)),
        "_FUR": bin.floats(clothed.hairs.iter().map(|h| h[2].to_array())),
        "_FUR_1": bin.floats(clothed.hairs.iter().map(|h| h[0].to_array())),
        "_FUR_2": bin.floats(clothed.hairs.iter().map(|h| h[1].to_array())),
        "_FUR_NORMAL": bin.floats(clothed.upright.iter().map(Vec3::to_array)),
        "_FUR_COLOR": bin.floats(clothed.fur_colors.iter().map(Vec3::to_array)),
    });
    let fur_texcoord = u32::from(clothed.skin_uv.is_some());
    if let Some(uv) = &clothed.skin_uv {
        attributes["TEXCOORD_0"] = bin.floats(uv.iter().map(|uv| [uv.x, 1.0 - uv.y])).into();
    }
    attributes[format!("TEXCOORD_{fur_texcoord}")] =
        bin.floats(clothed.fur_uv.iter().map(glam::Vec2::to_array)).into();
    let indices = bin.integers(clothed.triangles.as_flattened().iter().map(|i| [*i]));
    bin.target(indices, ELEMENT_ARRAY_BUFFER);
    let length = |e: &FinEdge| {
        let [a, b] = e.ends.map(|i| clothed.positions[i as usize]);
        a.distance(b)
    };
    let fins = FinAccessors {
        edges: bin.integers(edges.iter().map(|e| [e.ends[0], e.ends[1], e.opposite[0], e.opposite[1]])),
        u: bin.floats(edges.iter().map(|e| e.u)),
        depth: fin_depth(&world.scene.shells, manifest, edges.iter().map(length)),
        rows: FIN_TEXELS,
    };
    // Only vertex attributes and indices are uploaded to a GPU unchanged.
    for accessor in attributes.as_object().into_iter().flatten().filter_map(|(_, a)| a.as_u64()) {
        bin.target(accessor as u32, ARRAY_BUFFER);
    }
    let (shells, view) = settings(world, manifest);
    let extras = Extras {
        version: 1,
        manifest: manifest.clone(),
        layers_texture: LAYERS_FILE.into(),
        fin_texture: FIN_FILE.into(),
        fur_texcoord,
        strays: strays(world, textures)?,
        guard_variance: world.scene.guard.spread.to_radians().tan().powi(2),
        fins,
        shells,
        view,
    };
    let extras = serde_json::to_value(extras)
        .map_err(|e| Error::Encoding(format!("{GLTF_FILE}: the settings cannot be encoded as JSON: {e}")))?;
    let objects = objects::parts(world, &mut bin);
    let mut meshes = vec![json!({
        "name": "skin",
        "primitives": [{ "attributes": attributes, "indices": indices, "material": 0 }],
    })];
    meshes.extend(objects.iter().map(|o| o.mesh.clone()));
    let mut materials = vec![json!({
        "name": "skin",
        "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 1.0 },
    })];
    materials.extend(objects.iter().map(|o| o.material.clone()));
    // Centimetres to metres.
    let node = |name: &Value, mesh: usize| json!({ "name": name, "mesh": mesh, "scale": [0.01, 0.01, 0.01] });
    let mut nodes = vec![node(&json!("fur"), 0)];
    nodes.extend((1..).zip(&objects).map(|(i, o)| node(&o.mesh["name"], i)));
    let mut document = json!({
        "asset": { "version": "2.0", "generator": concat!("pelage ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": (0..nodes.len()).collect::<Vec<_>>() }],
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
        "buffers": [{ "uri": BIN_FILE, "byteLength": bin.bytes.len() }],
        "bufferViews": bin.views,
        "accessors": bin.accessors,
        "extras": { "pelage": extras },
    });
    objects::extend(&mut document, &objects);
    Ok((document, bin.bytes))
}

const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const UNSIGNED_INT: u32 = 5125;
const FLOAT: u32 = 5126;

/// A glTF buffer with one view and one accessor per array. All components have 4 bytes, so that
/// everything is aligned.
#[derive(Default)]
struct Bin {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Bin {
    fn floats<const N: usize>(&mut self, elements: impl Iterator<Item = [f32; N]>) -> u32 {
        self.add(elements.map(|e| e.map(f32::to_le_bytes)), FLOAT)
    }

    fn integers<const N: usize>(&mut self, elements: impl Iterator<Item = [u32; N]>) -> u32 {
        self.add(elements.map(|e| e.map(u32::to_le_bytes)), UNSIGNED_INT)
    }

    fn add<const N: usize>(&mut self, elements: impl Iterator<Item = [[u8; 4]; N]>, component: u32) -> u32 {
        let start = self.bytes.len();
        self.bytes.extend(elements.flat_map(|e| e.into_iter().flatten()));
        let length = self.bytes.len() - start;
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][(N - 1).min(3)];
        self.views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": length }));
        self.accessors.push(json!({
            "bufferView": self.views.len() - 1,
            "componentType": component,
            "count": length / (4 * N),
            "type": kind,
        }));
        self.accessors.len() as u32 - 1
    }

    fn bound(&mut self, accessor: u32, low: Value, high: Value) {
        if let Some(a) = self.accessors.get_mut(accessor as usize) {
            a["min"] = low;
            a["max"] = high;
        }
    }

    /// Sets the target of an accessor's view; each accessor has its own view.
    fn target(&mut self, accessor: u32, target: u32) {
        if let Some(view) = self.views.get_mut(accessor as usize) {
            view["target"] = target.into();
        }
    }
}
