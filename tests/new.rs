//! A mesh without a scene: what is chosen for it, and the scene file that `pelage new` writes.

use crate::common::{Folder, command, pelage, run};
use pelage::assets::Assets;
use pelage::scene::Framing;
use pelage::{Scene, World};
use pelage_core::mesh::{shapes, write_obj};
use pelage_core::scene::Shape;
use serde_json::Value;

/// A long body, far from the origin, in units of its own, as an OBJ file.
fn body(folder: &Folder) -> String {
    let mut mesh = shapes::shape(Shape::Torus);
    for p in &mut mesh.positions {
        *p = *p * glam::Vec3::new(0.3, 0.1, 0.1) + glam::Vec3::new(500.0, -80.0, 33.0);
    }
    let written = folder.at("in_cm.obj");
    write_obj(&mesh.into(), written.as_ref()).unwrap();
    // Without the comment that names the unit.
    let text = std::fs::read_to_string(&written).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('#')).map(|line| format!("{line}\n"));
    folder.write("my body.obj", lines.collect::<String>())
}

fn json(args: &[&str]) -> Value {
    serde_json::from_str(&pelage(args).expect(0, &[]).out).unwrap()
}

#[test]
fn new_writes_the_scene_that_the_mesh_renders_as() {
    let folder = Folder::new();
    let mesh = body(&folder);
    let flags = ["--preset", "red_fox", "--body-size", "0.4m", "-D", "guard.density=12"];
    let direct = json(&[&["check", "--json", &mesh][..], &flags].concat());
    let scene = folder.at("scene.toml");
    let run = pelage(&[&["new", &mesh, "-o", &scene][..], &flags].concat()).expect(0, &[]);
    assert!(run.out.contains("scene.toml"), "{run:?}");
    let written = json(&["check", "--json", &scene]);
    assert_eq!(direct["scene"], written["scene"]);
    assert_eq!(direct["counts"], written["counts"]);
    let text = std::fs::read_to_string(&scene).unwrap();
    for part in ["path = \"my body.obj\"", "size = 40", "# Largest side", "[[lights]]", "# [undercoat]"] {
        assert!(text.contains(part), "no {part} in\n{text}");
    }
}

#[test]
fn new_does_not_overwrite_a_scene() {
    let folder = Folder::new();
    let (mesh, scene) = (body(&folder), folder.write("scene.toml", "precious"));
    pelage(&["new", &mesh, "-o", &scene]).expect(1, &["exists already", "--force"]);
    assert_eq!(std::fs::read_to_string(&scene).unwrap(), "precious");
    pelage(&["new", &mesh, "-o", &scene, "--force", "--quiet"]).expect(0, &[]);
}

/// In another folder than the mesh, the scene still finds it.
#[test]
fn the_new_scene_may_lie_in_another_folder() {
    let (folder, other) = (Folder::new(), Folder::new());
    let mesh = body(&folder);
    let scene = other.at("scene.toml");
    pelage(&["new", &mesh, "-o", &scene]).expect(0, &[]);
    run(command().current_dir(folder.path()).args(["check", &scene])).expect(0, &[]);
}

#[test]
fn a_mesh_is_rendered_as_it_comes() {
    let folder = Folder::new();
    let (mesh, picture) = (body(&folder), folder.at("a.png"));
    let run = pelage(&[
        "render",
        &mesh,
        "-o",
        &picture,
        "--size",
        "60x40",
        "--spp",
        "1",
        "-D",
        "film.background=\"transparent\"",
    ]);
    let run = run.expect(0, &[]);
    for note in ["camera:", "light:", "30 cm"] {
        assert!(run.err.contains(note), "no {note} in {}", run.err);
    }
    let image = image::open(&picture).unwrap().into_rgba8();
    let covered: Vec<_> = image.enumerate_pixels().filter(|(.., p)| p[3] > 127).collect();
    assert!(covered.len() > 60 * 40 / 10, "{} pixels are covered", covered.len());
    let border = |x: u32, y: u32| x == 0 || y == 0 || x == 59 || y == 39;
    assert!(covered.iter().all(|(x, y, _)| !border(*x, *y)), "the fur is cut off");
    let mean = covered.iter().map(|(.., p)| f64::from(p[1])).sum::<f64>() / covered.len() as f64;
    assert!((30.0..200.0).contains(&mean), "green is {mean} on average");
}

#[test]
fn a_camera_is_framed_unless_it_is_given() {
    let frame = |camera: &str| {
        let scene = Scene::parse(&format!("[mesh]\nshape = \"torus\"\n{camera}"), "a", &[]).unwrap();
        (scene.camera.frame, scene.camera.fov)
    };
    assert_eq!(frame(""), (Framing::Auto, 20.0));
    assert_eq!(frame("[camera]\nfov = 50"), (Framing::Auto, 50.0));
    assert_eq!(frame("[camera]\neye = [0, 0, 9]"), (Framing::Given, 30.0));
    assert_eq!(frame("[camera]\nframe = \"given\""), (Framing::Given, 30.0));
    for (camera, what) in [
        ("frame = \"auto\"\neye = [0, 0, 9]", "chooses eye and target"),
        ("view = [3, 4]\neye = [0, 0, 9]", "camera.view"),
        ("view = [3, 95]", "elevation"),
    ] {
        let text = format!("[mesh]\nshape = \"torus\"\n[camera]\n{camera}\n");
        let fault = Scene::parse(&text, "a.toml", &[]).unwrap_err().to_string();
        assert!(fault.contains(what), "{fault}");
    }
}

/// Light is chosen only where there is none at all, and the note says so.
#[test]
fn a_scene_without_light_is_lit() {
    let world = |light: &str| {
        let scene = Scene::parse(&format!("[mesh]\nshape = \"torus\"\n{light}"), "a", &[]).unwrap();
        World::load(scene, &Assets::default()).unwrap()
    };
    let lit = world("");
    assert!(lit.lights.len() > 3 && lit.scene.lights.len() == 3 && lit.scene.environment.is_some());
    assert!(lit.notes.iter().any(|n| n.starts_with("light:")), "{:?}", lit.notes);
    let given = world("[[lights]]\ndirection = [0, 1, 0]\n");
    assert_eq!(given.lights.len(), 1);
    assert!(!given.notes.iter().any(|n| n.starts_with("light:")), "{:?}", given.notes);
}
