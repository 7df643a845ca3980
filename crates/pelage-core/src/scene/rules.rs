//! Rules beyond types and ranges: values that depend on each other, and files that must exist.

use super::{
    Background, Camera, Framing, Scene, check,
    tree::{ESCAPE_HELP, Node, Sources, Value},
};
use crate::SceneFault;
use crate::assets::Assets;
use crate::light;
use glam::Vec3;

/// A broken rule: the keys that it concerns (the first gives the position), what is wrong, what to
/// do.
type Broken = (Vec<&'static str>, String, &'static str);

/// The faults of values that contradict each other. A rule is skipped if a table with one of its
/// keys already has a fault; `found` holds these with their paths.
pub(super) fn broken(
    scene: &Scene,
    tree: &Node,
    sources: &Sources,
    found: &[(String, SceneFault)],
) -> Vec<SceneFault> {
    let top = |path: &str| path.split('.').next().unwrap_or_default().to_owned();
    let known_bad: Vec<String> = found.iter().map(|(path, _)| top(path)).collect();
    let mut faults: Vec<_> = relations(scene)
        .into_iter()
        .filter(|(paths, ..)| !paths.iter().any(|p| known_bad.contains(&top(p))))
        .map(|(paths, message, help)| sources.fault(tree.origin_of(paths[0]), message, Some(help.to_owned())))
        .collect();
    if !known_bad.iter().any(|table| table == "parts") {
        faults.extend(super::parts::broken(scene, tree, sources));
    }
    for (i, light) in scene.lights.iter().enumerate() {
        if Vec3::from(light.direction).length_squared() < 1e-12 {
            let origin = tree.origin_of(&format!("lights.{i}.direction"));
            let message = format!("lights.{i}.direction: must not be zero");
            faults.push(sources.fault(
                origin,
                message,
                Some("give the direction from the scene to the light".into()),
            ));
        }
    }
    if !known_bad.iter().any(|table| table == "objects") {
        faults.extend(super::objects::broken(scene, tree, sources));
    }
    faults
}

fn relations(scene: &Scene) -> Vec<Broken> {
    let mut broken: Vec<Broken> = Vec::new();
    let mut rule = |holds: bool, paths: &[&'static str], message: &str, help: &'static str| {
        if !holds {
            broken.push((paths.to_vec(), message.to_owned(), help));
        }
    };
    let mesh = &scene.mesh;
    rule(
        mesh.path.is_some() || mesh.shape.is_some(),
        &["mesh"],
        "mesh: neither mesh.path nor mesh.shape is given",
        "name a mesh file (path = \"...\") or a built-in shape (shape = \"critter\")",
    );
    rule(
        mesh.path.is_none() || mesh.shape.is_none(),
        &["mesh.shape", "mesh.path"],
        "mesh: both mesh.path and mesh.shape are given",
        "keep one of them",
    );
    rule(
        mesh.path.as_deref() != Some(""),
        &["mesh.path"],
        "mesh.path: found an empty name",
        "name a mesh file",
    );
    let camera = &scene.camera;
    let view = Vec3::from(camera.target) - Vec3::from(camera.eye);
    let up = Vec3::from(camera.up);
    let auto = camera.frame == Framing::Auto;
    let defaults = Camera::default();
    rule(
        !auto || (camera.eye == defaults.eye && camera.target == defaults.target),
        &["camera.frame", "camera.eye", "camera.target"],
        "camera: frame = \"auto\" chooses eye and target, but one of them is given",
        "leave out either frame, or eye and target; camera.view chooses the side from which it looks",
    );
    rule(
        auto || camera.view.is_none(),
        &["camera.view"],
        "camera.view: found beside eye or target, expected frame = \"auto\"",
        "leave out eye and target, or view",
    );
    rule(
        !auto || camera.view.is_none_or(|v| v[1].abs() <= 89.0),
        &["camera.view"],
        "camera.view: the elevation is more than 89 degrees above or below the horizon",
        "give [azimuth, elevation] in degrees",
    );
    rule(
        view.length() > 0.0,
        &["camera.target", "camera.eye"],
        "camera: eye and target are the same",
        "move one of them",
    );
    rule(
        auto || view.length() == 0.0 || view.normalize().cross(up.normalize_or_zero()).length() > 1e-4,
        &["camera.up", "camera.eye", "camera.target"],
        "camera: up is zero or parallel to the viewing direction",
        "choose another up, e.g. [0, 0, 1]",
    );
    let film = &scene.film;
    rule(
        film.background != Background::Plate || !film.plate.is_empty(),
        &["film.background", "film.plate"],
        "film: background = \"plate\" but film.plate names no image",
        "set film.plate to an image file",
    );
    rule(
        film.background != Background::Environment || scene.environment.as_ref().is_none_or(|e| e.visible),
        &["environment.visible", "film.background"],
        "environment: visible = false but film.background is \"environment\"",
        "leave visible out, or choose another background",
    );
    rule(
        u64::from(film.width) * u64::from(film.height) <= 1 << 29,
        &["film.width", "film.height"],
        "film: found more than 536,870,912 pixels",
        "render parts of it with --cropwindow at a smaller size",
    );
    let (given, made) = light::asked(scene);
    let key = if given > light::MAX_LIGHTS { "lights" } else { "environment.lights" };
    rule(
        given.saturating_add(made) <= light::MAX_LIGHTS,
        &[key, "lights", "environment"],
        &light::too_many(given, made),
        "remove the weakest lights, or lower environment.lights",
    );
    let motion = &scene.animation.motion;
    rule(
        motion.amplitude == 0.0 || Vec3::from(motion.axis).length_squared() > 1e-12,
        &["animation.motion.axis"],
        "animation.motion.axis: must not be zero",
        "give the direction in which the object swings",
    );
    for (path, scalar) in scene.own_coat().scalars() {
        rule(scalar.max() >= 0.0, &[path], &format!("{path}: {NEGATIVE}"), MAPPED);
    }
    broken
}

/// What is wrong with a scalar parameter whose largest value is below 0.
pub(super) const NEGATIVE: &str = "value and offset make it negative everywhere";
/// How a mapped scalar is computed.
pub(super) const MAPPED: &str = "the parameter is value * texel + offset with texels in 0..1";

/// Faults for files that the scene names and that are in none of the folders.
pub(super) fn missing_files(tree: &Node, sources: &Sources, assets: &Assets) -> Vec<SceneFault> {
    let mut named = Vec::new();
    collect_files("", tree, &mut named);
    let missing = named.into_iter().filter(|(_, _, name)| assets.find(name).is_err());
    let faults = missing
        .map(|(path, node, name)| {
            let message = format!("{path}: the file {name:?} is not there");
            // "meshes\new.obj" is valid TOML, with a line break in the name.
            let escaped = name.chars().any(char::is_control);
            let help = if escaped { ESCAPE_HELP.to_owned() } else { assets.advice() };
            (path, sources.fault(&node.origin, message, Some(help)))
        })
        .collect();
    super::parts::once(faults).into_iter().map(|(_, fault)| fault).collect()
}

/// All strings that name a file: the meshes, the plate, and every key called `map`.
fn collect_files<'a>(path: &str, node: &'a Node, found: &mut Vec<(String, &'a Node, &'a str)>) {
    match &node.value {
        Value::Table(table) => {
            table.iter().for_each(|(key, e)| collect_files(&check::join(path, key), &e.node, found));
        }
        Value::Array(items) => {
            items
                .iter()
                .enumerate()
                .for_each(|(i, n)| collect_files(&check::join(path, &i.to_string()), n, found));
        }
        Value::String(name) => {
            let is_map = path.ends_with(".map") && name != "vertex_color";
            let is_mesh = path == "mesh.path" || path.starts_with("objects.") && path.ends_with(".mesh.path");
            if !name.is_empty() && (is_map || is_mesh || path == "film.plate") {
                found.push((path.to_owned(), node, name));
            }
        }
        _ => {}
    }
}
