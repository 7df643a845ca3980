//! Meshes without fur.

use crate::assets::Assets;
use crate::maps::{VERTEX_COLOR, white_vertices};
use crate::scene::{Color, ObjectMaterial, Placement};
use crate::{Error, Result, Scene, Skin, mesh};
use glam::Vec3;

/// Length of a ground that is not given, in sides of the body: long shadows end on it.
const GROUND_SIDES: f32 = 8.0;

/// A mesh without fur, in world space.
#[derive(Debug, Clone)]
pub struct Object {
    /// Its name in the scene.
    pub name: String,
    /// Its surface, cm.
    pub surface: Skin,
    /// Its material.
    pub material: ObjectMaterial,
    /// Its translation, cm: maps without uv move with it.
    pub origin: [f32; 3],
    /// Whether only the shadow on it is seen.
    pub shadow_catcher: bool,
}

/// Loads the objects of a scene around its body. Notes on a surface begin with the object's name.
///
/// # Errors
/// [`Error::Scene`] for objects without a mesh, or whose mesh is missing or damaged, with the
/// object's name; all objects' faults come together. [`Error::Io`] where a file cannot be read.
pub fn load(scene: &Scene, body: &Skin, assets: &Assets) -> Result<Vec<Object>> {
    let mut faults = Vec::new();
    let mut objects = Vec::new();
    for spec in &scene.objects {
        let like = (spec.place == Placement::Body).then_some(body);
        let mut mesh = spec.mesh.clone();
        if spec.place == Placement::Under && mesh.shape.is_some() && mesh.scale.is_none() {
            let (low, high) = body.bounds();
            mesh.size = mesh.size.or(Some(GROUND_SIDES * (high - low).max_element()));
        }
        match mesh::load_like(&mesh, &|name| assets.find(name), like) {
            Ok(mut surface) => {
                let mut origin = spec.mesh.translate;
                if spec.place == Placement::Under {
                    let (low, high) = body.bounds();
                    let top = surface.bounds().1.y - mesh.translate[1];
                    let to = Vec3::new(0.5 * (low.x + high.x), low.y - top, 0.5 * (low.z + high.z));
                    surface.positions.iter_mut().for_each(|p| *p += to);
                    origin = (Vec3::from(origin) + to).into();
                    let [size, y] = [surface.bounds().1.x - surface.bounds().0.x, surface.bounds().1.y];
                    surface.notes.push(format!(
                        "{size:.0} cm wide and put under the body, at y = {y:.2} cm; mesh.size and mesh.translate \
                         change it"
                    ));
                }
                if !spec.mesh.faceted {
                    surface = surface.creased(spec.crease.to_radians());
                }
                let colored = matches!(&spec.material.color, Color::Mapped(m) if m.map == VERTEX_COLOR);
                if colored && !surface.colored {
                    surface.notes.push(white_vertices(&spec.mesh));
                }
                surface.notes.iter_mut().for_each(|note| *note = of_object(&spec.name, note));
                objects.push(Object {
                    name: spec.name.clone(),
                    surface,
                    material: spec.material.clone(),
                    origin,
                    shadow_catcher: spec.shadow_catcher,
                });
            }
            Err(Error::Scene(found)) => faults.extend(found.into_iter().map(|mut fault| {
                fault.message = format!("object \"{}\": {}", spec.name, fault.message);
                fault
            })),
            Err(other) => return Err(other),
        }
    }
    if faults.is_empty() { Ok(objects) } else { Err(Error::Scene(faults)) }
}

/// A note with the object's name behind the word that marks a warning.
fn of_object(name: &str, note: &str) -> String {
    match note.strip_prefix("warning: ") {
        Some(rest) => format!("warning: object \"{name}\": {rest}"),
        None => format!("object \"{name}\": {note}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::World;

    const CORNERS: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 1.0]];

    /// A tetrahedron, smaller by `shrink` around its first corner, as OBJ.
    fn tetrahedron(shrink: f32) -> String {
        let vertex = |p: [f32; 3]| format!("v {} {} {}\n", shrink * p[0], shrink * p[1], shrink * p[2]);
        CORNERS.map(vertex).concat() + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    }

    fn world(name: &str, scene: &str) -> Result<World> {
        let folder = std::env::temp_dir().join(format!("pelage-objects-{}-{name}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        for (file, shrink) in [("body.obj", 1.0), ("eye.obj", 0.5)] {
            std::fs::write(folder.join(file), tetrahedron(shrink)).expect("a file");
        }
        let path = folder.join("scene.toml");
        std::fs::write(&path, scene).expect("a file");
        let loaded = Scene::load(&path, &[]);
        let world = loaded.and_then(|(scene, assets)| World::load(scene, &assets));
        std::fs::remove_dir_all(&folder).expect("removed");
        world
    }

    /// What was modelled together stays together, however the body is placed.
    #[test]
    fn an_object_goes_with_its_body() {
        let scene = "[mesh]\npath = \"body.obj\"\nsize = 30\nup = \"z\"\ncenter = true\nrotate = [10, 20, 30]\n\
            translate = [1, 2, 3]\n[[objects]]\nname = \"eye\"\nplace = \"body\"\nmesh = { path = \"eye.obj\", translate = [0, 0, 5] }\n";
        let world = world("body", scene).expect("a world");
        let (body, eye) = (&world.skin, &world.objects[0].surface);
        // All vertices are kept in order: halfway between the first and each.
        for v in 0..4 {
            let halfway = 0.5 * (body.positions[0] + body.positions[v]) + Vec3::Z * 5.0;
            assert!(eye.positions[v].distance(halfway) < 1e-4, "{v}: {} {halfway}", eye.positions[v]);
        }
        let outwards = |skin: &Skin| {
            let middle = skin.positions[..4].iter().sum::<Vec3>() / 4.0;
            skin.positions.iter().zip(&skin.normals).all(|(p, n)| n.dot(*p - middle) > 0.0)
        };
        assert!(outwards(body) && outwards(eye));
    }

    #[test]
    fn a_ground_lies_under_the_body() {
        let scene = "[mesh]\npath = \"body.obj\"\nsize = 20\ntranslate = [7, 0, -4]\n[[objects]]\nname = \"ground\"\n\
            place = \"under\"\nmesh = { shape = \"plane\" }\n[[objects]]\nname = \"lower\"\nplace = \"under\"\n\
            mesh = { shape = \"cube\", size = 3, translate = [1, -2, 0] }\n";
        let world = world("under", scene).expect("a world");
        let (low, high) = world.skin.bounds();
        let (ground_low, ground_high) = world.objects[0].surface.bounds();
        assert!((ground_high.y - low.y).abs() < 1e-4 && (ground_low.y - low.y).abs() < 1e-4);
        assert!(((ground_high.x - ground_low.x) - 8.0 * 20.0).abs() < 1e-2);
        let middle = |low: Vec3, high: Vec3| 0.5 * (low + high);
        let aside = middle(ground_low, ground_high) - middle(low, high);
        assert!(aside.x.abs() < 1e-3 && aside.z.abs() < 1e-3, "{aside}");
        let (cube_low, cube_high) = world.objects[1].surface.bounds();
        assert!((cube_high.y - (low.y - 2.0)).abs() < 1e-4, "{cube_high}");
        assert!((middle(cube_low, cube_high).x - middle(low, high).x - 1.0).abs() < 1e-3);
        assert!(
            world.notes.iter().any(|n| n.starts_with("object \"ground\": 160 cm wide")),
            "{:?}",
            world.notes
        );
    }

    #[test]
    fn a_place_on_the_body_is_refused_with_keys_of_its_own() {
        let scene = "[mesh]\npath = \"body.obj\"\n[[objects]]\nname = \"eye\"\nplace = \"body\"\n\
            mesh = { path = \"eye.obj\", size = 3 }\n";
        let message = world("keys", scene).expect_err("a fault").to_string();
        assert!(message.contains("objects.0.mesh.size") && message.contains("scene.toml:6"), "{message}");
    }
}
