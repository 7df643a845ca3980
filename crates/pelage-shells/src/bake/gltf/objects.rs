//! Objects as ordinary meshes of the document.
// [GLTF2], KHR_materials_clearcoat

use super::{ARRAY_BUFFER, Bin, ELEMENT_ARRAY_BUFFER};
use glam::Vec3;
use pelage_core::World;
use pelage_core::objects::Object;
use pelage_core::scene::Color;
use pelage_fur::groom;
use pelage_fur::parameters::{Maps, MeshPlace, SkinPoint};
use pelage_fur::surface::vertex_uv;
use serde_json::{Value, json};

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
    let mapped = names(&|o| !o.shadow_catcher && matches!(o.material.color, Color::Mapped(_)));
    if !mapped.is_empty() {
        notes.push(format!("mapped colours of objects are those at the vertices in the glTF file: {mapped}"));
    }
    notes
}

/// An object in the document.
pub(super) struct Part {
    /// Its mesh, whose material has the mesh's number.
    pub mesh: Value,
    /// Its material.
    pub material: Value,
}

/// The objects, whose meshes have numbers from 1 on; their arrays go into `bin`.
pub(super) fn parts(world: &World, bin: &mut Bin) -> Vec<Part> {
    if shown(world).next().is_none() {
        return Vec::new();
    }
    let (groom, texels, materials) = groom::pack_parameters(world, None);
    let maps = Maps { groom: &groom, texels: &texels };
    let part = |(number, (i, object)): (usize, (usize, &Object))| {
        let surface = &object.surface;
        let positions = bin.floats(surface.positions.iter().map(Vec3::to_array));
        let (low, high) = surface.bounds();
        bin.bound(positions, json!(low.to_array()), json!(high.to_array()));
        let normals = bin.floats(surface.normals.iter().map(Vec3::to_array));
        let mut attributes = json!({ "POSITION": positions, "NORMAL": normals });
        let mut factor = [1.0; 4];
        match object.material.color {
            Color::Constant([r, g, b]) => factor = [r, g, b, 1.0],
            Color::Mapped(_) => {
                let uv = vertex_uv(surface);
                let color = |v: usize| {
                    let at = SkinPoint {
                        position: surface.positions[v],
                        normal: surface.normals[v],
                        uv: uv[v].into(),
                        color: surface.vertex_color(v),
                        place: MeshPlace::Vertex(v as u32),
                    };
                    maps.color_of(&materials[i].color, &at, object.origin).clamp(Vec3::ZERO, Vec3::ONE)
                };
                let colors = (0..surface.positions.len()).map(|v| color(v).to_array());
                attributes["COLOR_0"] = bin.floats(colors).into();
            }
        }
        for accessor in attributes.as_object().into_iter().flatten().filter_map(|(_, a)| a.as_u64()) {
            bin.target(accessor as u32, ARRAY_BUFFER);
        }
        let indices = bin.integers(surface.triangles.as_flattened().iter().map(|i| [*i]));
        bin.target(indices, ELEMENT_ARRAY_BUFFER);
        let of = &object.material;
        let mut material = json!({
            "name": object.name,
            "doubleSided": true,
            "pbrMetallicRoughness": {
                "baseColorFactor": factor,
                "metallicFactor": of.metallic,
                "roughnessFactor": of.roughness,
            },
        });
        if of.clearcoat > 0.0 {
            material["extensions"] = json!({ CLEARCOAT: {
                "clearcoatFactor": of.clearcoat,
                "clearcoatRoughnessFactor": of.clearcoat_roughness,
            }});
        }
        let primitive = json!({ "attributes": attributes, "indices": indices, "material": number });
        Part { mesh: json!({ "name": object.name, "primitives": [primitive] }), material }
    };
    (1..).zip(shown(world)).map(part).collect()
}

/// The extension for clear coats.
const CLEARCOAT: &str = "KHR_materials_clearcoat";

/// The extensions that the materials of `parts` use.
pub(super) fn extensions(parts: &[Part]) -> Vec<&'static str> {
    let coated = parts.iter().any(|part| part.material.get("extensions").is_some());
    if coated { vec![CLEARCOAT] } else { Vec::new() }
}
