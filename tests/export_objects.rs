//! Objects in scenes for other renderers: their surfaces and materials are found in the files.

use crate::common::Folder;
use crate::export::{SCENE, between, close, elements, numbers, strands, text};
use glam::Vec3;
use pelage_core::scene::{MeshSpec, Shape};
use pelage_core::{Scene, World};
use pelage_export::{self as export, EnvironmentAs, Target, Written};
use std::path::Path;

/// A ground with a mapped colour that catches shadows, a coated ball of half a metal, a metal.
const OBJECTS: &str = "
[[objects]]
name = 'the ground'
mesh = { path = 'ground.ply', scale = 1, up = 'y', vertex_colors = 'linear' }
material = { color = { map = 'vertex_color', value = [1, 0.5, 1] }, roughness = 0.75 }
shadow_catcher = true
[[objects]]
name = 'left \"eye\"'
mesh = { shape = 'sphere', scale = 0.1, translate = [0, 1, 0] }
[objects.material]
color = [0.25, 0.125, 0.5]
roughness = 0.5
metallic = 0.5
clearcoat = 0.25
clearcoat_roughness = 0.2
[[objects]]
name = 'bell'
mesh = { shape = 'sphere', scale = 0.05, translate = [2, 1, 0] }
material = { color = [0.75, 0.5, 0.25], metallic = 1, roughness = 0.4 }
[[objects]]
name = 'sign'
mesh = { shape = 'plane', scale = 0.1, translate = [0, 3, 0] }
material = { color = { map = 'sign.png', value = [1, 0.5, 1] } }
";

const GROUND: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    property float red\nproperty float green\nproperty float blue\nelement face 1\n\
    property list uchar int vertex_indices\nend_header\n0 0 0 1 0 0\n0 0 5 0 1 0\n5 0 0 0 0 1\n3 0 1 2\n";

fn export_objects(out: &Folder, target: Target) -> Vec<Written> {
    let folder = Folder::new();
    folder.write("ground.ply", GROUND);
    // Red and green above blue and white.
    let texels = [[255, 0, 0], [0, 255, 0], [0, 0, 255], [255; 3]];
    let map = image::RgbImage::from_fn(2, 2, |x, y| image::Rgb(texels[(2 * y + x) as usize]));
    map.save(folder.path().join("sign.png")).unwrap();
    let path = folder.write("scene.toml", format!("{SCENE}{OBJECTS}"));
    let (scene, assets) = Scene::load(Path::new(&path), &[]).expect("a scene");
    let world = World::load(scene, &assets).expect("a world");
    export::write(&world, &strands(), &assets, target, EnvironmentAs::Map, out.path()).expect("files")
}

/// Vertices of a PLY file that this program wrote, `columns` floats each.
fn ply_vertices(folder: &Folder, name: &str, columns: usize, count: usize) -> Vec<Vec<f32>> {
    let ply = std::fs::read(folder.path().join(name)).unwrap();
    let end = ply.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let floats = ply[end..].chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap()));
    floats.collect::<Vec<_>>().chunks(columns).take(count).map(<[f32]>::to_vec).collect()
}

#[test]
fn mitsuba_gets_the_objects() {
    let folder = Folder::new();
    export_objects(&folder, Target::Mitsuba);
    for name in ["the_ground.ply", "left__eye_.ply", "bell.ply"] {
        assert!(folder.names().contains(&name.to_owned()), "{:?}", folder.names());
    }
    // Position, normal, and the colour times its factor.
    let ground = ply_vertices(&folder, "the_ground.ply", 9, 3);
    assert_eq!(ground[1], [0.0, 0.0, 5.0, 0.0, 1.0, 0.0, 0.0, 0.5, 0.0]);
    let xml = text(&folder, "scene.xml");
    elements(&xml);
    let shape = between(&xml, "id=\"left__eye_\"", "</shape>");
    let has = |shape: &str, kind: &str, name: &str, value: &str| {
        assert!(shape.contains(&format!("<{kind} name=\"{name}\" value=\"{value}\"/>")), "{name}: {shape}");
    };
    has(shape, "string", "filename", "left__eye_.ply");
    has(shape, "rgb", "base_color", "0.25 0.125 0.5");
    let gloss = ((0.1f32 - 0.2f32 * 0.2) / 0.099).to_string();
    for (name, value) in [
        ("roughness", "0.5"),
        ("metallic", "0.5"),
        ("eta", "1.5"),
        ("clearcoat", "0.25"),
        ("clearcoat_gloss", gloss.as_str()),
    ] {
        has(shape, "float", name, value);
    }
    let ground = between(&xml, "id=\"the_ground\"", "</shape>");
    has(ground, "string", "name", "vertex_color");
    has(ground, "float", "roughness", "0.75");
    assert!(!ground.contains("clearcoat"), "{ground}");
}

#[test]
fn pbrt_gets_the_objects() {
    let folder = Folder::new();
    export_objects(&folder, Target::Pbrt);
    let scene = text(&folder, "scene.pbrt");
    let line = |name: &str| between(&scene, &format!("MakeNamedMaterial \"{name}\" "), "\n");
    let eye = line("left__eye_.dielectric");
    assert!(eye.contains("\"coateddiffuse\"") && eye.contains("remaproughness\" false"), "{eye}");
    assert_eq!(numbers(eye), [0.25, 0.125, 0.5, 0.25, 1.5]);
    let metal = line("left__eye_.metal");
    assert!(metal.contains("\"conductor\""), "{metal}");
    assert_eq!(numbers(metal), [0.25, 0.125, 0.5, 0.25]);
    let coated = line("left__eye_.coated");
    let coat = 0.2f32 * 0.2;
    let found: Vec<f32> = numbers(coated).into_iter().filter(|n| *n != 0.0).collect();
    assert_eq!(found, [0.25, 0.125, 0.5, 0.25, coat, 1.5], "{coated}");
    let mix =
        "\"mix\" \"string materials\" [ \"left__eye_.metal\" \"left__eye_.coated\" ] \"float amount\" 0.25";
    assert!(line("left__eye_.partly_coated").contains(mix), "{scene}");
    assert!(line("left__eye_.mixed").ends_with("\"float amount\" 0.5"));
    assert_eq!(scene.matches("bell").count(), 3, "one material");
    // What is defined is used, each before its shape.
    for (material, file) in [
        ("left__eye_.mixed", "left__eye_.ply"),
        ("bell.metal", "bell.ply"),
        ("the_ground.dielectric", "the_ground.ply"),
    ] {
        let used = format!("NamedMaterial \"{material}\"\nShape \"plymesh\" \"string filename\" \"{file}\"");
        assert!(scene.contains(&used), "{used}: {scene}");
    }
    // The mean of the vertices.
    let ground = numbers(line("the_ground.dielectric"));
    close(Vec3::from_slice(&ground), Vec3::new(1.0, 0.5, 1.0) / 3.0);
}

#[test]
fn usd_gets_the_objects() {
    let folder = Folder::new();
    export_objects(&folder, Target::Usd);
    let usd = text(&folder, "scene.usda");
    assert_eq!(usd.matches('{').count(), usd.matches('}').count());
    let mesh = between(&usd, "def Mesh \"the_ground\"", "\n    }");
    assert!(mesh.contains("displayName = \"the ground\"") && mesh.contains("</World/Looks/the_ground>"));
    let array = |name: &str| numbers(between(mesh, &format!("{name} = ["), "]"));
    assert_eq!(array("point3f[] points"), [0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 5.0, 0.0, 0.0]);
    assert_eq!(array("displayColor"), [1.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0]);
    assert!(usd.contains("displayName = \"left \\\"eye\\\"\""));
    let material = between(&usd, "def Material \"left__eye_\"", "\n        }");
    let number = |name: &str| numbers(between(material, &format!("inputs:{name} = "), "\n"));
    assert_eq!(number("diffuseColor"), [0.25, 0.125, 0.5]);
    for (name, value) in [
        ("roughness", 0.5),
        ("metallic", 0.5),
        ("clearcoat", 0.25),
        ("clearcoatRoughness", 0.2),
        ("ior", 1.5),
    ] {
        assert_eq!(number(name), [value], "{name}");
    }
    let ground = between(&usd, "def Material \"the_ground\"", "\n        }\n");
    assert!(ground.contains("diffuseColor.connect = </World/Looks/the_ground/Color.outputs:result>"));
    assert!(ground.contains("varname = \"displayColor\""));
}

#[test]
fn blender_gets_the_objects() {
    let folder = Folder::new();
    export_objects(&folder, Target::Blender);
    let script = text(&folder, "scene.py");
    let objects = between(&script, "OBJECTS = [\n", "\n]");
    let things: Vec<&str> = objects.split("    },").collect();
    let has = |thing: &str, part: &str| assert!(thing.contains(part), "no {part} in {thing}");
    has(things[0], "\"name\": \"the ground\",\n        \"file\": \"the_ground.ply\"");
    has(things[0], "\"color\": None");
    has(things[0], "\"shadow_catcher\": True");
    for part in [
        "\"name\": \"left \\\"eye\\\"\"",
        "\"color\": (0.25, 0.125, 0.5)",
        "\"roughness\": 0.5",
        "\"metallic\": 0.5",
        "\"clearcoat\": 0.25",
        "\"clearcoat_roughness\": 0.2",
        "\"shadow_catcher\": False",
    ] {
        has(things[1], part);
    }
    assert_eq!(ply_vertices(&folder, "the_ground.ply", 9, 3)[2][6..], [0.0, 0.0, 1.0]);
}

/// What a target does not know of objects is listed, under their names; HAIR files leave them out.
#[test]
fn deviations_of_objects_are_listed() {
    for target in [Target::Mitsuba, Target::Pbrt, Target::Blender, Target::Usd] {
        let folder = Folder::new();
        export_objects(&folder, target);
        let head = text(&folder, target.head());
        let has = |part: &str| head.lines().any(|l| l.contains("Differs: ") && l.contains(part));
        let knows = target == Target::Blender;
        assert!(has("shadow catcher \"the ground\" blocks light") == knows, "{target:?}");
        assert!(has("\"the ground\" only catches shadows") != knows, "{target:?}");
        assert_eq!(has("the colour of \"the ground\" is the mean"), target == Target::Pbrt, "{target:?}");
        assert!(!has("mapped colour of"), "{target:?}");
        let coat = has("the clear coat of \"left \\\"eye\\\"\"");
        assert_eq!(coat, matches!(target, Target::Mitsuba | Target::Pbrt), "{target:?}: {head:.4000}");
    }
    let folder = Folder::new();
    let written = export_objects(&folder, Target::Hair);
    let obj = written.last().unwrap();
    assert!(obj.holds.contains("left out are the objects \"the ground\""), "{}", obj.holds);
}

/// An image goes with its factor to a file beside the scene, with the uv that the target looks it
/// up by.
#[test]
fn images_of_objects_are_kept() {
    let sign = pelage_core::mesh::load(
        &MeshSpec {
            shape: Some(Shape::Plane),
            scale: Some(0.1),
            translate: [0.0, 3.0, 0.0],
            ..MeshSpec::default()
        },
        &|_| unreachable!(),
    )
    .unwrap();
    for (target, part) in [
        (Target::Mitsuba, "<string name=\"filename\" value=\"sign.exr\"/>"),
        (
            Target::Pbrt,
            "\"sign.dielectric\" \"string type\" \"coateddiffuse\" \"texture reflectance\" \"sign.color\"",
        ),
        (Target::Blender, "\"color\": \"sign.exr\""),
        (Target::Usd, "asset inputs:file = @./sign.exr@"),
    ] {
        let folder = Folder::new();
        export_objects(&folder, target);
        assert!(text(&folder, target.head()).contains(part), "{target:?}");
        let image = pelage_core::film::io::read(folder.path().join("sign.exr")).unwrap();
        assert_eq!([image.width, image.height], [2, 2]);
        let planes = ["R", "G", "B"].map(|name| image.plane(name).unwrap());
        assert_eq!(planes, [[1.0, 0.0, 0.0, 1.0], [0.0, 0.5, 0.0, 0.5], [0.0, 0.0, 1.0, 1.0]]);
        if target == Target::Usd {
            let usd = text(&folder, "scene.usda");
            let mesh = between(&usd, "def Mesh \"sign\"", "\n    }");
            let st = numbers(between(mesh, "primvars:st = [", "]"));
            let wanted: Vec<f32> =
                sign.corner_uv.iter().flatten().flatten().flat_map(|uv| uv.to_array()).collect();
            assert_eq!(st, wanted);
            continue;
        }
        let corner = |(v, uv): (u32, glam::Vec2)| {
            let v_of = if target == Target::Mitsuba { 1.0 - uv.y } else { uv.y };
            let [p, n] = [sign.positions[v as usize], sign.normals[v as usize]];
            [p.x, p.y, p.z, n.x, n.y, n.z, uv.x, v_of].to_vec()
        };
        let corners = sign.triangles.iter().zip(sign.corner_uv.iter().flatten());
        let corners: Vec<_> = corners.flat_map(|(t, uv)| [0, 1, 2].map(|k| corner((t[k], uv[k])))).collect();
        let found = ply_vertices(&folder, "sign.ply", 8, sign.positions.len());
        assert_eq!(found.len(), sign.positions.len(), "a plane has no seams");
        assert!(found.iter().all(|vertex| corners.contains(vertex)), "{target:?}: {:?}", found[0]);
    }
}
