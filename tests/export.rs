//! Scenes for other renderers: the files are parsed by the tests and compared with what this
//! program renders.

use crate::common::{Folder, pelage};
use glam::{Mat3, Mat4, Quat, Vec2, Vec3, Vec4};
use pelage_core::assets::Assets;
use pelage_core::{Scene, World};
use pelage_export::{self as export, EnvironmentAs, Target, Written, curves};
use pelage_fur::{Layer, camera};
use pelage_pathtrace::strands::{Hair, Strands};
use std::path::Path;

pub(crate) const SCENE: &str = "
[mesh]
shape = 'plane'
[camera]
eye = [3, 4, 9]
target = [0.5, 0, 0]
up = [0.1, 1, 0]
fov = 35
lens = { aperture = 0.25, focus = 8 }
[[lights]]
direction = [1, 2, 0.5]
irradiance = [3, 2, 1]
[[lights]]
direction = [-1, 1, 0]
irradiance = [0.5, 0.5, 0.75]
[environment]
tint = [0.25, 0.5, 1]
intensity = 2
lights = 8
[guard]
opacity = 0.9
[film]
width = 96
height = 64
exposure = 1
";

fn world(more: &[String]) -> World {
    let scene = Scene::parse(SCENE, "scene.toml", more).expect("the scene is valid");
    World::load(scene, &Assets::default()).expect("the world loads")
}

/// Guard hairs, the second of which lacks its middle segment, and undercoat of one segment that all
/// has one colour.
pub(crate) fn strands() -> Vec<Strands> {
    let hair = |i: u32, present| Hair {
        color_root: Vec3::new(0.1, 0.2, 0.3) * (i + 1) as f32,
        color_tip: Vec3::new(0.3, 0.2, 0.1),
        glint_angle: 0.0,
        present,
    };
    let guard_points = (0..8).map(|i| {
        let (h, k) = ((i / 4) as f32, (i % 4) as f32);
        Vec4::new(h + 0.1 * k * k, 0.3 * k, 0.0, 0.01 + 0.002 * k)
    });
    let coat = Hair { color_tip: Vec3::splat(0.5), color_root: Vec3::splat(0.5), ..hair(0, 1) };
    let opacity = vec![0.9, 0.9, 0.9, 0.8];
    vec![
        Strands {
            layer: Layer::Guard,
            segments: 3,
            points: guard_points.collect(),
            hairs: vec![hair(0, 0b111), hair(1, 0b101)],
            opacity,
            color_transition: [0.5, 1.0],
            color_transitions: Vec::new(),
        },
        Strands {
            layer: Layer::Undercoat,
            segments: 1,
            points: vec![Vec4::new(0.0, 0.0, 1.0, 0.001), Vec4::new(0.0, 1e-7, 1.5, 0.0)],
            hairs: vec![coat],
            opacity: Vec::new(),
            color_transition: [0.5, 1.0],
            color_transitions: Vec::new(),
        },
    ]
}

fn export_with(folder: &Folder, target: Target, as_: EnvironmentAs, more: &[String]) -> Vec<Written> {
    let world = world(more);
    export::write(&world, &strands(), &Assets::default(), target, as_, folder.path())
        .expect("the scene is written")
}

fn export_to(folder: &Folder, target: Target) -> Vec<Written> {
    export_with(folder, target, EnvironmentAs::Map, &[])
}

pub(crate) fn text(folder: &Folder, name: &str) -> String {
    std::fs::read_to_string(folder.path().join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// All numbers of a text, in order.
pub(crate) fn numbers(text: &str) -> Vec<f32> {
    text.split(|c: char| !(c.is_ascii_digit() || "+-.e".contains(c)))
        .filter_map(|word| word.parse().ok())
        .collect()
}

/// The text between two marks, the first of each.
pub(crate) fn between<'a>(text: &'a str, start: &str, end: &str) -> &'a str {
    let (_, rest) = text.split_once(start).unwrap_or_else(|| panic!("no {start:?} in {text:.2000}"));
    rest.split_once(end).unwrap_or_else(|| panic!("no {end:?} after {start:?}")).0
}

/// Elements of an XML text as (name, attributes); panics where tags do not match or an attribute
/// has no quotes.
pub(crate) fn elements(xml: &str) -> Vec<(String, String)> {
    let mut rest = xml;
    let (mut open, mut found) = (Vec::new(), Vec::new());
    while let Some((before, tag)) = rest.split_once('<') {
        assert!(!before.contains('>'), "a stray > in {before:?}");
        if let Some(comment) = tag.strip_prefix("!--") {
            let (inside, after) = comment.split_once("-->").expect("the comment ends");
            assert!(!inside.contains("--"), "two hyphens in a comment");
            rest = after;
            continue;
        }
        let (tag, after) = tag.split_once('>').expect("the tag ends");
        rest = after;
        if tag.starts_with('?') {
            continue;
        }
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(name));
            continue;
        }
        let (name, attributes) = tag.trim_end_matches('/').split_once(' ').unwrap_or((tag, ""));
        assert_eq!(attributes.matches('"').count(), 2 * attributes.matches("=\"").count(), "{attributes}");
        found.push((name.to_owned(), attributes.to_owned()));
        if !tag.ends_with('/') {
            open.push(name.to_owned());
        }
    }
    assert!(open.is_empty(), "not closed: {open:?}");
    found
}

/// The camera's axes as the shaders have them: right, up, forward, position.
fn axes() -> [Vec3; 4] {
    let f = camera::frame(&world(&[]).scene.camera, [96, 64], Vec2::ZERO, Vec2::ZERO, 0);
    [f.right, f.up, f.forward, f.eye].map(Vec3::from)
}

pub(crate) fn close(a: Vec3, b: Vec3) {
    assert!(a.distance(b) < 1e-5 * (1.0 + b.length()), "found {a}, expected {b}");
}

#[test]
fn hairs_are_cut_where_segments_are_missing() {
    let strands = strands();
    let runs: Vec<_> = curves::runs(&strands[0]).map(|r| (r.hair, r.first, r.points.len())).collect();
    assert_eq!(runs, [(0, 0, 4), (1, 0, 2), (1, 2, 2)]);
    assert_eq!(curves::Counts::of(&strands[0]), curves::Counts { runs: 3, points: 8 });
    let segments: Vec<_> = curves::segments(&strands[0]).map(|s| (s.hair, s.number)).collect();
    assert_eq!(segments, [(0, 0), (0, 1), (0, 2), (1, 0), (1, 2)]);
}

#[test]
fn mitsuba_gets_the_scene() {
    let folder = Folder::new();
    let written = export_to(&folder, Target::Mitsuba);
    assert_eq!(written.last().unwrap().path, folder.path().join("scene.xml"), "the head comes last");
    let names = ["guard-0000.pfm", "guard-0000.txt", "scene.xml", "skin.ply", "undercoat-0000.txt"];
    assert_eq!(folder.names(), names);
    for file in &written {
        assert_eq!(file.bytes, std::fs::metadata(&file.path).unwrap().len());
    }

    // Four points on a line a segment, the inner two its ends.
    let curves_text = text(&folder, "guard-0000.txt");
    let curves: Vec<Vec<f32>> = curves_text.trim().split("\n\n").map(numbers).collect();
    let expected: Vec<_> = curves::segments(&strands()[0]).map(|s| s.ends).collect();
    assert_eq!(curves.len(), expected.len());
    for (curve, ends) in curves.iter().zip(expected) {
        assert_eq!(curve.len(), 16);
        let [a, b, c, d] = [0, 4, 8, 12].map(|i| Vec4::from_slice(&curve[i..]));
        assert_eq!([b, c], ends);
        assert!((a + c - 2.0 * b).abs().max_element() < 1e-5 && (b + d - 2.0 * c).abs().max_element() < 1e-5);
    }
    // One texel a quarter of a segment, the last on top of the file.
    let pfm = std::fs::read(folder.path().join("guard-0000.pfm")).unwrap();
    assert!(pfm.starts_with(b"PF\n1 20\n-1.0\n"));
    let floats: Vec<f32> =
        pfm[13..].chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
    assert_eq!(floats.len(), 60);
    let world = world(&[]);
    let material = export::material::of(&world.scene, Layer::Guard);
    let first = material.absorption(strands()[0].color(0, 0.125 / 3.0));
    close(Vec3::from_slice(&floats[57..]), first);
    let last = material.absorption(strands()[0].color(1, 2.875 / 3.0));
    close(Vec3::from_slice(&floats), last);

    let xml = text(&folder, "scene.xml");
    let elements = elements(&xml);
    let count =
        |name: &str, part: &str| elements.iter().filter(|(n, a)| n == name && a.contains(part)).count();
    assert_eq!(count("shape", "bsplinecurve"), 2);
    assert_eq!(count("emitter", "directional"), 2);
    assert_eq!(count("emitter", "constant"), 1);
    assert_eq!(count("rgb", "0.5 1 2"), 1, "the sky");
    assert_eq!(count("sensor", "thinlens"), 1);
    // A point on the optical axis and one to the left, as Mitsuba has it.
    let m = numbers(between(&xml, "<matrix value=\"", "\""));
    let to_world = Mat4::from_cols_slice(&m).transpose();
    let [right, up, forward, eye] = axes();
    close(to_world.transform_point3(Vec3::ZERO), eye);
    close(to_world.transform_vector3(Vec3::Z), forward);
    close(to_world.transform_vector3(Vec3::X), -right);
    close(to_world.transform_vector3(Vec3::Y), up);
    let emitter = between(&xml, "<emitter type=\"directional\">", "</emitter>");
    let n = numbers(emitter);
    close(Vec3::from_slice(&n), -Vec3::new(1.0, 2.0, 0.5).normalize());
    close(Vec3::from_slice(&n[3..]), Vec3::new(3.0, 2.0, 1.0));
}

#[test]
fn environment_lights_can_be_written_as_they_are_rendered() {
    let folder = Folder::new();
    export_with(&folder, Target::Mitsuba, EnvironmentAs::Lights, &[]);
    let xml = text(&folder, "scene.xml");
    assert_eq!(xml.matches("type=\"directional\"").count(), 10);
    assert_eq!(xml.matches("type=\"constant\"").count(), 0);
    let total: f32 = xml.split("name=\"irradiance\" value=\"").skip(1).map(|t| numbers(&t[..40])[2]).sum();
    let sky = 4.0 * std::f32::consts::PI * 2.0;
    assert!((total - 1.75 - sky).abs() < 1e-3 * sky, "{total}");
}

#[test]
fn pbrt_gets_the_scene() {
    let folder = Folder::new();
    export_to(&folder, Target::Pbrt);
    assert_eq!(folder.names(), ["guard.pbrt", "scene.pbrt", "skin.ply", "undercoat.pbrt"]);
    let guard = text(&folder, "guard.pbrt");
    let shapes: Vec<_> = guard.lines().filter(|l| l.starts_with("Shape \"curve\"")).collect();
    let expected: Vec<_> = curves::segments(&strands()[0]).map(|s| s.ends).collect();
    assert_eq!(shapes.len(), expected.len());
    for (shape, [a, b]) in shapes.iter().zip(expected) {
        let p = numbers(between(shape, "[", "]"));
        assert_eq!((Vec3::from_slice(&p), Vec3::from_slice(&p[9..])), (a.truncate(), b.truncate()));
        close(Vec3::from_slice(&p[3..]), a.lerp(b, 1.0 / 3.0).truncate());
        let widths = numbers(shape.split_once(']').unwrap().1);
        assert_eq!(widths, [0.0, 2.0 * a.w, 1.0, 2.0 * b.w], "width0 and width1: diameters");
    }
    // Each segment of these few has a material of its own colour.
    assert_eq!(guard.matches("MakeNamedMaterial").count(), 5);
    let named: Vec<&str> = guard.lines().filter_map(|l| l.strip_prefix("NamedMaterial ")).collect();
    assert!(named.iter().all(|n| guard.contains(&format!("MakeNamedMaterial {n}"))), "{named:?}");

    let scene = text(&folder, "scene.pbrt");
    let [right, up, forward, eye] = axes();
    let look = numbers(between(&scene, "LookAt", "\n"));
    let [e, t, u] = [0, 3, 6].map(|i| Vec3::from_slice(&look[i..]));
    close(e, eye);
    close(t - e, forward);
    close(u, up);
    // LookAt's x axis is up x forward; mirrored, it is the picture's right.
    assert!(scene.contains("Scale -1 1 1"));
    close(-u.cross(t - e), right);
    let light = numbers(between(&scene, "LightSource \"distant\"", "\n"));
    close(Vec3::from_slice(&light[1..]), Vec3::new(1.0, 2.0, 0.5).normalize());
    close(Vec3::from_slice(&light[8..]), Vec3::new(3.0, 2.0, 1.0));
    assert!(scene.contains("\"infinite\" \"rgb L\" [ 0.5 1 2 ]"));
    assert!(scene.contains("\"float lensradius\" 0.125 \"float focaldistance\" 8"));
    assert!(scene.contains("\"float screenwindow\" [ -1.5 1.5 -1 1 ]"));
}

#[test]
fn usd_gets_the_scene() {
    let folder = Folder::new();
    export_to(&folder, Target::Usd);
    let usd = text(&folder, "scene.usda");
    assert!(usd.starts_with("#usda 1.0\n") && usd.contains("metersPerUnit = 0.01"));
    assert_eq!(usd.matches('{').count(), usd.matches('}').count());
    let guard = between(&usd, "def BasisCurves \"Guard\"", "def BasisCurves");
    let array = |name: &str| numbers(between(guard, &format!("{name} = ["), "]"));
    assert_eq!(array("curveVertexCounts"), [4.0, 2.0, 2.0]);
    let strands = strands();
    let points: Vec<Vec4> = curves::runs(&strands[0]).flat_map(|r| r.points.to_vec()).collect();
    let flat: Vec<f32> = points.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
    assert_eq!(array("point3f[] points"), flat);
    assert_eq!(array("widths"), points.iter().map(|p| 2.0 * p.w).collect::<Vec<_>>());
    assert_eq!(array("displayColor").len(), 24);
    assert_eq!(array("displayOpacity"), [0.9, 0.9, 0.9, 0.8, 0.9, 0.9, 0.9, 0.8]);
    // Row vectors; the camera's view direction is -z.
    let m = numbers(between(&usd, "xformOp:transform = (", "\n"));
    let to_world = Mat4::from_cols_slice(&m);
    let [right, up, forward, eye] = axes();
    close(to_world.transform_point3(Vec3::ZERO), eye);
    close(to_world.transform_vector3(Vec3::NEG_Z), forward);
    close(to_world.transform_vector3(Vec3::X), right);
    close(to_world.transform_vector3(Vec3::Y), up);
    let number = |name: &str| numbers(between(&usd, name, "\n"))[0];
    let (aperture, focal) = (number("verticalAperture = "), number("focalLength = "));
    assert!((2.0 * (aperture / 2.0 / focal).atan().to_degrees() - 35.0).abs() < 1e-3);
    assert!((focal / 10.0 / number("fStop = ") - 0.25).abs() < 1e-5);
    // The light shines along its -z axis.
    let light = between(&usd, "def DistantLight \"Light0\"", "}");
    let m = Mat4::from_cols_slice(&numbers(between(light, "xformOp:transform = (", "\n")));
    close(m.transform_vector3(Vec3::Z), Vec3::new(1.0, 2.0, 0.5).normalize());
    assert!((Mat3::from_mat4(m).determinant() - 1.0).abs() < 1e-5);
    assert!(light.contains("intensity = 3") && light.contains("normalize = 1"));
}

#[test]
fn blender_gets_the_scene() {
    let folder = Folder::new();
    export_to(&folder, Target::Blender);
    assert_eq!(folder.names(), ["guard.hair", "scene.py", "skin.ply", "undercoat.hair"]);
    let script = text(&folder, "scene.py");
    let camera = numbers(between(&script, "CAMERA = (", "\n"));
    let [right, up, forward, eye] = axes();
    for (i, v) in [right, up, -forward, eye].into_iter().enumerate() {
        close(Vec3::from_slice(&camera[3 * i..]), v);
    }
    assert!(script.contains("SIZE = (96, 64)") && script.contains("SKY = (0.5, 1, 2)"));
    let light = numbers(between(&script, "LIGHTS = [\n", "\n"));
    close(Vec3::from_slice(&light), Vec3::new(1.0, 2.0, 0.5).normalize());
    close(Vec3::from_slice(&light[3..]), Vec3::new(3.0, 2.0, 1.0));
    // The layout of the skin's file, as the script expects it.
    let ply = std::fs::read(folder.path().join("skin.ply")).unwrap();
    let end = ply.windows(11).position(|w| w == b"end_header\n").unwrap() + 11;
    let skin = world(&[]).skin;
    assert_eq!(ply.len() - end, 24 * skin.positions.len() + 13 * skin.triangles.len());
}

#[test]
fn hair_files_hold_all_layers() {
    let folder = Folder::new();
    export_to(&folder, Target::Hair);
    assert_eq!(folder.names(), ["guard.hair", "skin.obj", "undercoat.hair"]);
    let hair = pelage_core::hair::HairFile::read(&folder.path().join("guard.hair")).unwrap();
    let strands = strands();
    let points: Vec<Vec4> = curves::runs(&strands[0]).flat_map(|r| r.points.to_vec()).collect();
    assert_eq!(hair.segments, [3, 1, 1]);
    assert_eq!(hair.points, points.iter().map(|p| p.truncate()).collect::<Vec<_>>());
    assert_eq!(hair.thickness, points.iter().map(|p| 2.0 * p.w).collect::<Vec<_>>());
    assert_eq!(hair.transparency[3], 1.0 - 0.8);
    assert_eq!(hair.colors[1], strands[0].color(0, 1.0 / 3.0));
    assert_eq!(hair.colors[6], strands[0].color(1, 2.0 / 3.0));
    assert_eq!(hair.info, format!("pelage {}, guard, cm", env!("CARGO_PKG_VERSION")));
}

/// Only the deviations that apply to the scene are listed.
#[test]
fn deviations_are_listed() {
    let heads = [Target::Mitsuba, Target::Pbrt, Target::Blender, Target::Usd];
    for target in heads {
        let folder = Folder::new();
        export_to(&folder, target);
        let head = text(&folder, target.head());
        let has = |part: &str| head.lines().any(|l| l.contains("Differs: ") && l.contains(part));
        assert!(has("exposure of 1 stops") && has("folded to 8 directional lights"), "{head:.3000}");
        assert_eq!(has("opacity down to 0.8"), target != Target::Usd, "{target:?}");
        assert_eq!(has("glints"), target != Target::Usd, "{target:?}");
        let folder = Folder::new();
        let more = ["film.exposure=0".into(), "guard.fibre.glint=[0,8]".into()];
        export_with(&folder, target, EnvironmentAs::Lights, &more);
        let head = text(&folder, target.head());
        assert!(!head.contains("exposure of") && !head.contains("glints"), "{target:?}");
        assert!(head.contains("8 directional lights that the scene is rendered with"));
    }
}

/// The centre of pbrt's map is +z, and each texel has the direction that it has in the scene's map.
#[test]
fn a_map_keeps_its_directions() {
    let folder = Folder::new();
    // Red where x > 0, green where y > 0, blue where z > 0.
    let map = image::RgbImage::from_fn(64, 32, |x, y| {
        let azimuth = ((x as f32 + 0.5) / 64.0 - 0.5) * std::f32::consts::TAU;
        let d = [azimuth.sin(), 15.5 - y as f32, -azimuth.cos()];
        image::Rgb(d.map(|c| if c > 0.0 { 255 } else { 0 }))
    });
    map.save(folder.path().join("map.png")).unwrap();
    let scene = SCENE.replace("tint = [0.25, 0.5, 1]", "map = 'map.png'\nrotate = 90");
    let path = folder.write("scene.toml", scene);
    let (scene, assets) = Scene::load(Path::new(&path), &[]).unwrap();
    let world = World::load(scene, &assets).unwrap();
    let out = Folder::new();
    export::write(&world, &[], &assets, Target::Pbrt, EnvironmentAs::Map, out.path()).unwrap();
    let sky = pelage_core::light::environment::Panorama::load(
        &out.path().join("sky.exr"),
        "",
        None,
        &mut Vec::new(),
    )
    .unwrap();
    let side = sky.width;
    let turn = Quat::from_rotation_y(-std::f32::consts::FRAC_PI_2);
    let mut seen = 0;
    for (i, pixel) in sky.texels.iter().enumerate() {
        let at = Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) / side as f32;
        let d = turn * export::sky::square_to_sphere(at);
        if d.abs().min_element() > 0.2 {
            seen += 1;
            let expected = d.to_array().map(|c| if c > 0.0 { 2.0 } else { 0.0 });
            assert!((0..3).all(|k| (pixel[k] - expected[k]).abs() < 1e-3), "{d} {pixel:?}");
        }
    }
    assert!(seen > 500, "{seen}");
}

#[test]
fn two_runs_give_the_same_bytes() {
    for target in [Target::Mitsuba, Target::Pbrt, Target::Blender, Target::Usd, Target::Hair] {
        let (one, two) = (Folder::new(), Folder::new());
        export_to(&one, target);
        export_to(&two, target);
        assert_eq!(one.names(), two.names());
        for name in one.names() {
            let read = |f: &Folder| std::fs::read(f.path().join(&name)).unwrap();
            assert_eq!(read(&one), read(&two), "{name}");
        }
    }
}

#[test]
fn errors_say_what_cannot_be_written() {
    let folder = Folder::new();
    let file = folder.write("file", "");
    for (place, code) in [(file.clone(), 1), (folder.at("none/deeper"), 1), (format!("{file}/under"), 1)] {
        let args = ["export", "tests/data/small.toml", "--to", "usd", "-o", &place];
        pelage(&args).expect(code, &[&place, "cannot be created"]);
    }
    pelage(&["export", "tests/data/small.toml", "--to", "usd"]).expect(2, &["--folder"]);
    pelage(&["export", "tests/data/small.toml", "--to", "pov", "-o", "x"]).expect(2, &["mitsuba", "blender"]);
    pelage(&["export", "tests/data/small.toml", "-o", "x"]).expect(2, &["--to"]);
    assert_eq!(folder.names(), ["file"]);
}

#[test]
fn the_command_prints_counts_and_sizes() {
    let folder = Folder::new();
    let place = folder.at("new");
    let run = pelage(&["export", "tests/data/small.toml", "--fur", "base", "--to", "mitsuba", "-o", &place]);
    let run = run.expect(0, &[]);
    assert!(
        run.out.contains("triangles") && run.out.contains("total ") && run.out.contains("KiB"),
        "{}",
        run.out
    );
    assert!(Path::new(&place).join("scene.xml").is_file());
}

/// Hairs of the model that the targets also have: its parameters, each hair's own absorption, and
/// the pieces of the undercoat that exist.
#[test]
fn hairs_of_chiangs_model_keep_their_material() {
    let model = "{ model = 'chiang', roughness = [0.25, 0.4], tilt = -3, ior = 1.45 }";
    let world = world(&[format!("guard.fibre={model}"), format!("undercoat.fibre={model}")]);
    let [mut guard, coat]: [Strands; 2] = strands().try_into().expect("two layers");
    // Black has no logarithm.
    guard.hairs[0] = Hair { color_root: Vec3::ZERO, color_tip: Vec3::ZERO, ..guard.hairs[0] };
    let points = (0..8).map(|i| Vec4::new((i / 4) as f32, 0.1 * (i % 4) as f32, 0.5, 0.001)).collect();
    let tips = [Vec3::new(0.9, 0.5, 0.1), Vec3::splat(0.3)];
    let hairs = tips.map(|color_tip| Hair { color_tip, present: 0b101, ..coat.hairs[0] }).to_vec();
    let all = [guard, Strands { segments: 3, points, hairs, ..coat }];
    let fibre = pelage_fur::fibre::Absorption::by_color(0.4);
    let write = |folder: &Folder, target| {
        export::write(&world, &all, &Assets::default(), target, EnvironmentAs::Map, folder.path()).unwrap();
        text(folder, target.head())
    };

    let folder = Folder::new();
    let xml = write(&folder, Target::Mitsuba);
    assert!(!xml.contains("hairs scatter") && xml.contains("tangent of Mitsuba's hair model"), "{xml:.3000}");
    for (name, value) in [
        ("longitudinal_roughness", "0.25"),
        ("azimuthal_roughness", "0.4"),
        ("scale_tilt", "-3"),
        ("int_ior", "1.45"),
    ] {
        let found = xml.matches(&format!("<float name=\"{name}\" value=\"{value}\"/>")).count();
        assert_eq!(found, 2, "{name}");
    }
    let curves_text = text(&folder, "undercoat-0000.txt");
    let starts: Vec<_> =
        curves_text.trim().split("\n\n").map(|c| Vec4::from_slice(&numbers(c)[4..])).collect();
    let expected = [0, 2, 4, 6].map(|i| all[1].points[i]);
    assert_eq!(starts, expected, "segments 0 and 2 of both hairs");
    // Texels from the last to the first: colours at the midpoint of each texel's part of a segment.
    let texels = |name: &str, from: usize| -> Vec<Vec3> {
        let bytes = std::fs::read(folder.path().join(name)).unwrap();
        let floats: Vec<f32> =
            bytes[from..].chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect();
        floats.chunks_exact(3).rev().map(Vec3::from_slice).collect()
    };
    let found = texels("undercoat-0000.pfm", 12);
    assert_eq!(found.len(), 4);
    for (texel, (hair, s)) in
        found.iter().zip([(0, 1.0 / 6.0), (0, 5.0 / 6.0), (1, 1.0 / 6.0), (1, 5.0 / 6.0)])
    {
        close(*texel, fibre.of(Vec3::splat(0.5).lerp(tips[hair], s)));
    }
    let found = texels("guard-0000.pfm", 13);
    assert_eq!(found.len(), 20);
    close(found[0], fibre.of(Vec3::ZERO));
    close(found[12], fibre.of(all[0].color(1, 0.125 / 3.0)));
    assert!(found[0].x > 1.1 * found[12].x, "black absorbs more");

    let folder = Folder::new();
    let pbrt = write(&folder, Target::Pbrt);
    let material = text(&folder, "guard.pbrt");
    let of_model = "\"float beta_m\" 0.25 \"float beta_n\" 0.4 \"float alpha\" -3 \"float eta\" 1.45";
    assert!(!pbrt.contains("hairs scatter") && material.contains(of_model), "{material:.1000}");
    let folder = Folder::new();
    let blender = write(&folder, Target::Blender);
    assert!(!blender.contains("hairs scatter") && blender.contains("\"beta_n\": 0.4"), "{blender:.3000}");
}
