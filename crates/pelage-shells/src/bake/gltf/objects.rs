//! Objects as ordinary meshes of the document.
// [GLTF2], KHR_materials_clearcoat

use super::{ARRAY_BUFFER, Bin, ELEMENT_ARRAY_BUFFER};
use crate::bake::{Texture, png};
use glam::{Vec2, Vec3};
use pelage_core::maps::{MapImage, VERTEX_COLOR};
use pelage_core::objects::Object;
use pelage_core::scene::Color;
use pelage_core::{Result, Skin, World, files};
use pelage_fur::groom;
use pelage_fur::parameters::{Maps, MeshPlace, SkinPoint};
use pelage_fur::surface::split_at_seams;
use serde_json::{Value, json};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The objects that the document holds: all but shadow catchers, which glTF does not know.
fn shown(world: &World) -> impl Iterator<Item = (usize, &Object)> {
    world.objects.iter().enumerate().filter(|(_, object)| !object.shadow_catcher)
}

/// How the document differs from the scene's objects.
pub fn notes(world: &World) -> Vec<String> {
    let names = |which: &dyn Fn(&Object) -> bool| {
        let found = world.objects.iter().filter(|o| which(o)).map(|o| format!("{:?}", o.name));
        found.collect::<Vec<_>>().join(", ")
    };
    let mut notes = Vec::new();
    let caught = names(&|o| o.shadow_catcher);
    if !caught.is_empty() {
        notes.push(format!(
            "shadow catchers are left out of the glTF file, which does not know them: {caught}"
        ));
    }
    let sampled = |o: &Object| matches!(&o.material.color, Color::Mapped(m) if m.map != VERTEX_COLOR);
    let without_uv = names(&|o| !o.shadow_catcher && sampled(o) && o.surface.corner_uv.is_none());
    if !without_uv.is_empty() {
        notes.push(format!(
            "colours of objects whose meshes have no uv are those at the vertices in the glTF file: {without_uv}"
        ));
    }
    notes
}

/// An object in the document.
pub(super) struct Part {
    /// Its mesh, whose material has the mesh's number.
    pub mesh: Value,
    /// Its material.
    pub material: Value,
    /// File of its base colour, if that is an image.
    pub image: Option<String>,
}

/// The image of an object's base colour and the factor on it, if there is one and its mesh has uv.
fn image_of<'a>(world: &'a World, object: &Object) -> Option<(&'a MapImage, Vec3)> {
    let Color::Mapped(map) = &object.material.color else { return None };
    let index = world.maps.index_of(&map.map, &map.layer, true)?;
    object.surface.corner_uv.as_ref().map(|_| (&world.maps.images[index], map.value.into()))
}

fn file_of(number: usize) -> String {
    format!("object{number}.png")
}

/// Writes the images of base colours with their factors into the folder `dir`: PNG of 8 bits.
pub(super) fn write_images(world: &World, dir: &Path) -> Result<Vec<PathBuf>> {
    let mut written = Vec::new();
    for (number, object) in (1..).zip(shown(world).map(|(_, object)| object)) {
        let Some((image, value)) = image_of(world, object) else { continue };
        let texel = |[r, g, b, _]: &[f32; 4]| (value * Vec3::new(*r, *g, *b)).extend(1.0).to_array();
        let texels = image.texels.iter().map(texel).collect();
        let texture = Texture { width: image.width, height: image.height, texels };
        let path = dir.join(file_of(number));
        files::write_buffered(&path, |out| Ok(out.write_all(&png::encode(&texture)?)?))?;
        written.push(path);
    }
    Ok(written)
}

/// The objects, whose meshes have numbers from 1 on; their arrays go into `bin`.
pub(super) fn parts(world: &World, bin: &mut Bin) -> Vec<Part> {
    if shown(world).next().is_none() {
        return Vec::new();
    }
    let (groom, texels, materials) = groom::pack_parameters(world, None);
    let maps = Maps { groom: &groom, texels: &texels };
    let mut images = 0;
    let part = |(number, (i, object)): (usize, (usize, &Object))| {
        let color = |at: &SkinPoint| maps.color_of(&materials[i].color, at, object.origin);
        let image = image_of(world, object).map(|_| file_of(number));
        let split = image.as_ref().and_then(|_| split_at_seams(&object.surface));
        let (surface, uv) =
            split.as_ref().map_or((&object.surface, None), |(s, uv)| (s, Some(uv.as_slice())));
        let colored = uv.is_none() && matches!(object.material.color, Color::Mapped(_));
        let primitive = primitive(surface, uv, colored.then_some(&color), bin);
        let mut base = json!({
            "metallicFactor": object.material.metallic,
            "roughnessFactor": object.material.roughness,
        });
        if let Color::Constant([r, g, b]) = object.material.color {
            base["baseColorFactor"] = json!([r, g, b, 1.0]);
        } else if image.is_some() {
            base["baseColorTexture"] = json!({ "index": images });
            images += 1;
        }
        let mut material = json!({ "name": object.name, "doubleSided": true, "pbrMetallicRoughness": base });
        if object.material.clearcoat > 0.0 {
            material["extensions"] = json!({ CLEARCOAT: {
                "clearcoatFactor": object.material.clearcoat,
                "clearcoatRoughnessFactor": object.material.clearcoat_roughness,
            }});
        }
        let mut mesh = json!({ "name": object.name, "primitives": [primitive] });
        mesh["primitives"][0]["material"] = number.into();
        Part { mesh, material, image }
    };
    (1..).zip(shown(world)).map(part).collect()
}

/// A primitive with the arrays of a surface: `color` gives the colours of its vertices.
fn primitive(
    surface: &Skin,
    uv: Option<&[Vec2]>,
    color: Option<&impl Fn(&SkinPoint) -> Vec3>,
    bin: &mut Bin,
) -> Value {
    let positions = bin.floats(surface.positions.iter().map(Vec3::to_array));
    let (low, high) = surface.bounds();
    bin.bound(positions, json!(low.to_array()), json!(high.to_array()));
    let normals = bin.floats(surface.normals.iter().map(Vec3::to_array));
    let mut attributes = json!({ "POSITION": positions, "NORMAL": normals });
    if let Some(uv) = uv {
        attributes["TEXCOORD_0"] = bin.floats(uv.iter().map(|uv| [uv.x, 1.0 - uv.y])).into();
    }
    if let Some(color) = color {
        let at = |v: usize| SkinPoint {
            position: surface.positions[v],
            normal: surface.normals[v],
            uv: Vec2::ZERO,
            color: surface.vertex_color(v),
            place: MeshPlace::Vertex(v as u32),
        };
        let colors = (0..surface.positions.len()).map(|v| color(&at(v)).clamp(Vec3::ZERO, Vec3::ONE));
        attributes["COLOR_0"] = bin.floats(colors.map(|c| c.to_array())).into();
    }
    for accessor in attributes.as_object().into_iter().flatten().filter_map(|(_, a)| a.as_u64()) {
        bin.target(accessor as u32, ARRAY_BUFFER);
    }
    let indices = bin.integers(surface.triangles.as_flattened().iter().map(|i| [*i]));
    bin.target(indices, ELEMENT_ARRAY_BUFFER);
    json!({ "attributes": attributes, "indices": indices })
}

/// Textures, images and extensions of `parts`, as they stand in the document.
pub(super) fn extend(document: &mut Value, parts: &[Part]) {
    let images: Vec<_> = parts.iter().filter_map(|part| part.image.as_ref()).collect();
    if !images.is_empty() {
        // Without a sampler, images are repeated.
        document["textures"] = (0..images.len()).map(|i| json!({ "source": i })).collect();
        document["images"] = images.into_iter().map(|file| json!({ "uri": file })).collect();
    }
    if parts.iter().any(|part| part.material.get("extensions").is_some()) {
        document["extensionsUsed"] = json!([CLEARCOAT]);
    }
}

/// The extension for clear coats.
const CLEARCOAT: &str = "KHR_materials_clearcoat";
