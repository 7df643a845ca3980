//! A scene written as a commented file to begin from.

use super::{ObjectSpec, Scene, schema};
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
        table.insert("environment".into(), value_of(super::Environment::default())?);
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
                let usual = match name.as_str() {
                    "objects" => Some(value_of(ObjectSpec::default())?),
                    _ => None,
                };
                for item in items {
                    let item = usual.as_ref().map_or_else(|| item.clone(), |usual| unusual(item, usual));
                    text += &format!("\n[[{name}]]\n");
                    text += &lines(&[name, "0"], &item, None, "");
                }
            }
            Value::Table(_) if base.get(name) != Some(value) || name == "environment" => {
                text += &format!("\n[{name}]\n");
                text += &lines(&[name], value, base.get(name), "");
                text += &suggested(name, value, base.get(name), true);
            }
            _ => {}
        }
    }
    text += "\n# The coat, with the values above; take away the # of a line and of its table to change it.\n";
    for (name, _) in FIRST {
        // A table that is written above has these lines there.
        if let Some(value) = scene.get(name).filter(|value| base.get(name) == Some(*value)) {
            text += &format!("\n# [{name}]\n{}", suggested(name, value, None, false));
        }
    }
    Ok(text)
}

/// What of a table differs from `usual`, in the tables within it too.
fn unusual(table: &Value, usual: &Value) -> Value {
    let (Some(table), Some(usual)) = (table.as_table(), usual.as_table()) else { return table.clone() };
    let kept = table.iter().filter(|(key, value)| usual.get(*key) != Some(*value));
    let less = |(key, value): (&String, &Value)| {
        let value = usual.get(key).map_or_else(|| value.clone(), |usual| unusual(value, usual));
        (key.clone(), value)
    };
    Value::Table(kept.map(less).collect())
}

/// The keys of table `name` that a person changes first, as comments; without those that differ
/// from `base` if they are `written` already.
fn suggested(name: &str, table: &Value, base: Option<&Value>, written: bool) -> String {
    let Some((_, keys)) = FIRST.iter().find(|(first, _)| *first == name) else { return String::new() };
    let same = |key: &str, value: &Value| base.and_then(|base| base.get(key)) == Some(value);
    let chosen = table.as_table().into_iter().flatten();
    let chosen = chosen.filter(|(key, value)| keys.contains(&key.as_str()) && (!written || same(key, value)));
    let chosen = Value::Table(chosen.map(|(k, v)| (k.clone(), v.clone())).collect());
    lines(&[name], &chosen, None, "# ")
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
    // A capital follows the end of a sentence, but not an abbreviation.
    let ends = line.match_indices(". ").map(|(at, _)| at);
    let end = ends.into_iter().find(|at| line[at + 2..].starts_with(char::is_uppercase));
    line[..end.unwrap_or(line.len())].trim_end_matches('.').to_owned()
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
            [[objects]]\nname = \"eye\"\nmesh = { shape = \"sphere\", translate = [0, 1, 0] }\nmaterial = { roughness = 0.3 }\n\
            [guard.fibre]\nmodel = \"chiang\"\n[film]\nspp = 7\n[render.multiple]\nmodel = \"none\"\n";
        let scene = Scene::parse(text, "a", &[]).unwrap();
        let written = template(&scene, "A body.\n\nTwo.").unwrap();
        assert_eq!(Scene::parse(&written, "b", &[]).unwrap(), scene, "{written}");
        assert!(written.starts_with("# A body.\n#\n# Two.\n"), "{written}");
        assert!(written.contains("# [undercoat]\n# color_root"), "{written}");
        // Without the marks of all suggestions it is a scene still.
        let bare: String =
            written.lines().skip(3).map(|l| l.strip_prefix("# ").unwrap_or(l).to_owned() + "\n").collect();
        let bare = bare.replace("The coat, with the values above", "# The coat");
        assert_eq!(Scene::parse(&bare, "c", &[]).unwrap(), scene, "{bare}");
        assert!(written.contains("spp = 7"), "{written}");
        assert!(written.contains("material = { roughness = 0.3 }"), "{written}");
        assert!(!written.contains("et al\n") && !written.contains("rotate = 0 "), "{written}");
        assert!(!written.contains("aperture"), "defaults are left out: {written}");
    }
}
