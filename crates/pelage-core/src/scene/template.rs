//! A scene written as a commented file to begin from.

use super::{Scene, schema};
use crate::{Error, Result};
use toml::Value;

/// Tables in the order of the file; others follow.
const ORDER: [&str; 8] = ["mesh", "camera", "lights", "environment", "objects", "parts", "film", "render"];

/// What a person changes first; the rest of a preset is left to the reference.
const FIRST: [(&str, &[&str]); 3] = [
    ("guard", &["density", "length", "color_root", "color_tip", "comb", "comb_direction", "clump", "curl"]),
    ("undercoat", &["density", "height", "color_root", "color_tip"]),
    ("base", &["color"]),
];

/// A scene file of everything in `scene` that neither its preset nor a default gives, each key with
/// its description, followed by the coat's main parameters as comments. It loads to the same scene.
/// `about` is written at its head, a comment line for each of its lines.
///
/// # Errors
/// [`Error::Encoding`] if a value cannot be written as TOML.
pub fn template(scene: &Scene, about: &str) -> Result<String> {
    let bare = Scene { preset: scene.preset.clone(), mesh: scene.mesh.clone(), ..Scene::default() };
    let preset = match &scene.preset {
        Some(name) => Scene::parse(
            &format!("preset = {}\n[mesh]\nshape = \"sphere\"\n", Value::from(name.as_str())),
            "preset",
            &[],
        )?,
        None => Scene::default(),
    };
    let base = Scene { guard: preset.guard, undercoat: preset.undercoat, base: preset.base, ..bare };
    let (scene, mut base) = (value(scene)?, value(&base)?);
    if let Some(table) = base.as_table_mut() {
        table.insert("mesh".into(), value_of(super::MeshSpec::default())?);
    }
    let mut text: String =
        about.lines().map(|line| format!("# {line}").trim_end().to_owned() + "\n").collect();
    if let Some(preset) = scene.get("preset") {
        text += &format!("\npreset = {preset}\n");
    }
    let mut tables: Vec<(&String, &Value)> = scene.as_table().into_iter().flatten().collect();
    let place = |name: &str| ORDER.iter().position(|o| *o == name).unwrap_or(ORDER.len());
    tables.sort_by_key(|(name, _)| place(name));
    for (name, value) in tables {
        match value {
            Value::Array(items) if base.get(name) != Some(value) => {
                for item in items {
                    text += &format!("\n[[{name}]]\n");
                    text += &lines(&[name, "0"], item, None, "");
                }
            }
            Value::Table(_) if base.get(name) != Some(value) => {
                text += &format!("\n[{name}]\n");
                text += &lines(&[name], value, base.get(name), "");
            }
            _ => {}
        }
    }
    text += "\n# The coat, with the values above; take away the # of a line and of its table to change it.\n";
    for (name, keys) in FIRST {
        let Some(table) = scene.get(name).and_then(Value::as_table) else { continue };
        let chosen = table.iter().filter(|(key, _)| keys.contains(&key.as_str()));
        let chosen = Value::Table(chosen.map(|(k, v)| (k.clone(), v.clone())).collect());
        text += &format!("\n# [{name}]\n{}", lines(&[name], &chosen, None, "# "));
    }
    Ok(text)
}

fn value(scene: &Scene) -> Result<Value> {
    value_of(scene)
}

fn value_of(part: impl serde::Serialize) -> Result<Value> {
    Value::try_from(part).map_err(|e| Error::Encoding(format!("the scene cannot be written as TOML: {e}")))
}

/// The keys of `table` that differ from `base`, one line each, with descriptions from the schema.
fn lines(path: &[&str], table: &Value, base: Option<&Value>, prefix: &str) -> String {
    let keys: Vec<(String, String)> = table
        .as_table()
        .into_iter()
        .flatten()
        .filter(|(key, value)| base.and_then(|base| base.get(key.as_str())) != Some(*value))
        .map(|(key, value)| (format!("{prefix}{key} = {}", written(value)), about(path, key)))
        .collect();
    let width = keys.iter().map(|(line, _)| line.len()).filter(|w| *w < 44).max().unwrap_or(0);
    keys.iter()
        .map(|(line, about)| format!("{line:width$}  # {about}").trim_end().to_owned() + "\n")
        .collect()
}

/// A value with as many digits as an f32 needs.
fn written(value: &Value) -> String {
    match value {
        Value::Float(x) => format!("{}", *x as f32),
        Value::Array(items) => format!("[{}]", items.iter().map(written).collect::<Vec<_>>().join(", ")),
        Value::Table(table) => {
            let pairs: Vec<_> = table.iter().map(|(key, v)| format!("{key} = {}", written(v))).collect();
            format!("{{ {} }}", pairs.join(", "))
        }
        other => other.to_string(),
    }
}

/// The first sentence of a key's description.
fn about(path: &[&str], key: &str) -> String {
    let mut schema = schema::resolve(schema::json_schema());
    for step in path {
        let next =
            if step.parse::<usize>().is_ok() { schema.get("items") } else { schema::property(schema, step) };
        let Some(next) = next else { return String::new() };
        schema = schema::resolve(next);
    }
    let text = schema::property(schema, key)
        .and_then(|key| key.get("description"))
        .and_then(serde_json::Value::as_str)
        .unwrap_or_default();
    let line = text.split("\n\n").next().unwrap_or_default().replace('\n', " ");
    line.split_once(". ").map_or(line.as_str(), |(first, _)| first).trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values with long decimals, maps, lights and render settings come back exactly.
    #[test]
    fn the_template_of_a_scene_loads_to_it() {
        let text = "preset = \"red_fox\"\n[mesh]\npath = \"a \\\"b\\\".obj\"\nsize = 30.1\n[camera]\neye = [0.1, 7.3, 1e3]\n\
            [[lights]]\nirradiance = [0.1, 0.2, 0.3]\n[[lights]]\ndirection = [0, 1, 0]\n\
            [environment]\ntint = [0.1, 0.7, 0.9]\n[guard]\nlength = { map = \"m.png\", value = 1.7 }\n\
            [guard.fibre]\nmodel = \"chiang\"\n[film]\nspp = 7\n[render.multiple]\nmodel = \"none\"\n";
        let scene = Scene::parse(text, "a", &[]).unwrap();
        let written = template(&scene, "A body.\n\nTwo.").unwrap();
        assert_eq!(Scene::parse(&written, "b", &[]).unwrap(), scene, "{written}");
        assert!(written.starts_with("# A body.\n#\n# Two.\n"), "{written}");
        assert!(written.contains("# [undercoat]\n# color_root"), "{written}");
        assert!(written.contains("spp = 7"), "{written}");
        assert!(!written.contains("aperture"), "defaults are left out: {written}");
    }
}
