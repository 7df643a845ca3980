//! The reference of scene files (`docs/scene.md`), made from the JSON schema.
//!
//! Units stand in the doc comments of the keys as `, UNIT` and get a column of their own; so do
//! ranges, which the schema has, and which are left out of the text (`, 0..1`).

use super::schema;
use serde_json::Value as Json;
use std::fmt::Write;

/// Units that doc comments may give; a longer one stands before its own beginning.
const UNITS: [&str; 17] = [
    "hairs/cm²",
    "1/cm²",
    "1/cm",
    "1/s²",
    "1/s",
    "1/radius",
    "cm/s²",
    "cm",
    "µm",
    "degrees",
    "pixels",
    "texels",
    "samples",
    "stops",
    "bytes",
    "mean free paths",
    "linear RGB",
];

/// Tables in the order in which one writes a scene; all others follow.
const ORDER: [&str; 13] = [
    "mesh",
    "camera",
    "lights",
    "environment",
    "base",
    "guard",
    "undercoat",
    "film",
    "render",
    "shells",
    "bake",
    "lapped",
    "animation",
];

const HEAD: &str = "# Scene files

All keys of a scene file. This page is made by `pelage schema --markdown > docs/scene.md`.

A scene is a TOML file. Every key may be left out; then its default holds. Values of the file
override those of its `preset`, which override the defaults; `-D table.key=value` on the command
line overrides all of them. `[[table]]` may be repeated.

- **number or map**: a number, or `{ map = \"FILE\", ... }` with the keys of [maps](#maps): the value
  is read from an image where the hair grows. **colour or map**: `[red, green, blue]`, or a map.
- **N numbers**: an array, `[1, 2, 3]`.
- **Range**: of the value, or of every number of an array.
- **Default** `–`: the key is not set, and the text says what holds then.
";

/// A table of a scene file: its headings (a type may be at several places), and its schema.
struct Section {
    headings: Vec<String>,
    about: String,
    schema: &'static Json,
}

/// The reference of scene files as Markdown.
pub fn markdown() -> String {
    let root = schema::json_schema();
    let mut sections = Vec::new();
    collect("", root, &mut sections);
    let mut text = HEAD.to_owned();
    text += "\n## Top of the file\n\nThese keys stand before the first table.\n\n";
    table(&mut text, root, "");
    for section in &sections {
        let headings: Vec<_> = section.headings.iter().map(|h| format!("`{h}`")).collect();
        let _ = write!(text, "\n## {}\n\n{}\n\n", headings.join(", "), section.about);
        table(&mut text, section.schema, section.headings[0].trim_matches(['[', ']']));
    }
    text += "\n## Maps\n\nThe keys of a map, in place of a constant.\n";
    for (name, what) in [("ScalarMap", "In place of a number"), ("ColorMap", "In place of a colour")] {
        if let Some(map) = root.pointer(&format!("/$defs/{name}")) {
            let _ = write!(text, "\n{what}:\n\n");
            table(&mut text, map, "");
        }
    }
    text
}

/// Adds the tables below `schema`, each after the one that holds it.
fn collect(path: &str, parent: &'static Json, sections: &mut Vec<Section>) {
    let mut keys: Vec<_> = schema::properties(parent).collect();
    if path.is_empty() {
        keys.sort_by_key(|(key, _)| ORDER.iter().position(|k| k == key).unwrap_or(ORDER.len()));
    }
    for (key, value) in keys {
        let Some((inner, repeated)) = as_table(value) else { continue };
        let path = super::check::join(path, key);
        let heading = if repeated { format!("[[{path}]]") } else { format!("[{path}]") };
        if let Some(known) = sections.iter_mut().find(|s| std::ptr::eq(s.schema, inner)) {
            known.headings.push(heading);
        } else {
            let about = description(inner).unwrap_or_default();
            sections.push(Section { headings: vec![heading], about, schema: inner });
        }
        collect(&path, inner, sections);
    }
}

/// The schema of a table, or of the tables of an array, and whether it is an array.
fn as_table(value: &'static Json) -> Option<(&'static Json, bool)> {
    let schema = schema::resolve(value);
    match schema::kind(schema)? {
        "object" => Some((schema, false)),
        "array" => {
            let item = schema::resolve(schema.get("items")?);
            (schema::kind(item) == Some("object")).then_some((item, true))
        }
        _ => None,
    }
}

/// The keys of a table, one row each, then the choices of its keys.
fn table(text: &mut String, parent: &'static Json, path: &str) {
    let required: Vec<_> = parent
        .get("required")
        .and_then(Json::as_array)
        .into_iter()
        .flatten()
        .filter_map(Json::as_str)
        .collect();
    *text += "| key | type | unit | default | range | what it does |\n|---|---|---|---|---|---|\n";
    let mut choices = String::new();
    for (key, value) in schema::properties(parent).filter(|(_, value)| as_table(value).is_none()) {
        let inner = schema::resolve(value);
        let said = description(value).or_else(|| description(inner)).unwrap_or_default();
        let (said, unit) = without_unit(&said);
        let unit = unit.or_else(|| without_unit(&description(inner)?).1).unwrap_or("–");
        let default = match value.get("default") {
            _ if required.contains(&key) => "required".into(),
            None | Some(Json::Null) => "–".into(),
            Some(default) => format!("`{}`", toml(default)),
        };
        let range = range(value, inner);
        let said = without_range(&said).replace('|', "\\|");
        let _ = writeln!(text, "| `{key}` | {} | {unit} | {default} | {range} | {said} |", kind(inner));
        let words = variants(inner);
        if !words.is_empty() {
            let _ = write!(choices, "\n`{}`:\n\n", super::check::join(path, key));
            for (word, said) in words {
                let _ = writeln!(choices, "- `{word}`: {said}");
            }
        }
    }
    *text += &choices;
}

fn description(schema: &Json) -> Option<String> {
    let text = schema.get("description")?.as_str()?;
    Some(text.split_whitespace().collect::<Vec<_>>().join(" "))
}

/// The text without the first `, UNIT` that ends a clause, and that unit.
fn without_unit(text: &str) -> (String, Option<&'static str>) {
    let ends =
        |rest: &str| rest.is_empty() || rest.starts_with(['.', ';', ',', ':']) || rest.starts_with(" (");
    for (at, _) in text.match_indices(", ") {
        let rest = &text[at + 2..];
        let unit = UNITS.into_iter().find(|unit| rest.strip_prefix(unit).is_some_and(ends));
        if let Some(unit) = unit {
            return (format!("{}{}", &text[..at], &rest[unit.len()..]), Some(unit));
        }
    }
    (text.to_owned(), None)
}

/// The text without ranges such as `, 0..1`.
fn without_range(text: &str) -> String {
    let mut kept = String::new();
    for (i, part) in text.split(", ").enumerate() {
        let of_range = |c: &char| c.is_ascii_digit() || matches!(c, '.' | '=');
        let token: String = part.chars().take_while(of_range).collect();
        let token = token.trim_end_matches('.');
        if i > 0 && token.contains("..") {
            kept += &part[token.len()..];
        } else {
            if i > 0 {
                kept += ", ";
            }
            kept += part;
        }
    }
    kept
}

/// The type of a value in words.
fn kind(schema: &'static Json) -> String {
    let alternatives = schema::variants(schema);
    if !alternatives.is_empty() {
        let kinds: Vec<_> = alternatives.into_iter().map(|s| kind(schema::resolve(s))).collect();
        return kinds.join(" or ").replace("3 numbers or map", "colour or map");
    }
    if !schema::words(schema).is_empty() {
        return "a word".into();
    }
    match schema::kind(schema) {
        Some("number") => "number".into(),
        Some("integer") => "integer".into(),
        Some("string") => "text".into(),
        Some("boolean") => "`true`, `false`".into(),
        Some("object") => "map".into(),
        Some("array") => {
            let item = schema.get("items").map_or_else(String::new, |item| kind(schema::resolve(item)));
            let plural = if item == "text" { "texts".into() } else { format!("{item}s") };
            match schema.get("minItems").and_then(Json::as_u64) {
                Some(n) if item.starts_with(|c: char| c.is_ascii_digit()) => format!("{n} times {item}"),
                Some(n) => format!("{n} {plural}"),
                None => plural,
            }
        }
        _ => "value".into(),
    }
}

/// The words that a value may be, with their descriptions.
fn variants(schema: &'static Json) -> Vec<(&'static str, String)> {
    let described = schema.get("oneOf").and_then(Json::as_array).into_iter().flatten();
    let text = |word: &&'static str| {
        let variant = described.clone().find(|s| s.get("const").and_then(Json::as_str) == Some(word));
        variant.and_then(description).unwrap_or_default()
    };
    schema::words(schema).into_iter().map(|word| (word, text(&word))).collect()
}

/// The limits of a value, or of the numbers of an array or of the constant of a groom parameter.
fn range(value: &'static Json, inner: &'static Json) -> String {
    let mut places = vec![value, inner];
    places.extend(schema::variants(inner).first());
    let mut items = inner;
    while let Some(next) = items.get("items").or_else(|| schema::variants(items).first()?.get("items")) {
        items = next;
        places.push(items);
    }
    let limit = |key| places.iter().find_map(|s| s.get(key).and_then(Json::as_f64)).map(number);
    let (low, above) = (limit("minimum"), limit("exclusiveMinimum"));
    let (high, below) = (limit("maximum"), limit("exclusiveMaximum"));
    if let (Some(low), Some(high)) = (&low, &high) {
        return format!("{low} to {high}");
    }
    let parts = [(above, ">"), (low, "≥"), (below, "<"), (high, "≤")];
    let words: Vec<_> =
        parts.iter().filter_map(|(x, sign)| Some(format!("{sign} {}", x.as_ref()?))).collect();
    if words.is_empty() { "–".into() } else { words.join(", ") }
}

/// A number as its 32-bit value is written.
fn number(x: f64) -> String {
    if x.fract() == 0.0 && x.abs() < 1e15 { format!("{x:.0}") } else { format!("{}", x as f32) }
}

/// A default value as TOML.
fn toml(value: &Json) -> String {
    match value {
        Json::Number(n) => n.as_f64().map_or_else(|| n.to_string(), number),
        Json::Array(items) => format!("[{}]", items.iter().map(toml).collect::<Vec<_>>().join(", ")),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_and_ranges_get_columns_of_their_own() {
        let split = |text| without_unit(text);
        assert_eq!(split("Length, cm."), ("Length.".into(), Some("cm")));
        assert_eq!(split("Pull, cm/s², world space."), ("Pull, world space.".into(), Some("cm/s²")));
        assert_eq!(
            split("Step, mean free paths (of all)."),
            ("Step (of all).".into(), Some("mean free paths"))
        );
        assert_eq!(split("Lean, cmx."), ("Lean, cmx.".into(), None));
        assert_eq!(without_range("Spread, 0..1 (down)."), "Spread (down).");
        assert_eq!(without_range("Share, 0..1. 0: none, 1..=64."), "Share. 0: none.");
        assert_eq!(without_range("Radius, 2 or 3..4."), "Radius, 2 or 3..4.");
    }

    #[test]
    fn every_key_is_there() {
        let text = markdown();
        fn keys(schema: &Json, found: &mut Vec<String>) {
            for (name, inner) in schema["$defs"].as_object().into_iter().flatten() {
                for key in inner["properties"].as_object().into_iter().flatten() {
                    found.push(format!("{name}.{}", key.0));
                }
            }
        }
        let mut all = Vec::new();
        keys(schema::json_schema(), &mut all);
        assert!(all.len() > 100);
        for key in all {
            let name = key.rsplit_once('.').map_or("", |(_, name)| name);
            let row = format!("| `{name}` |");
            let heading = format!("{name}]");
            assert!(text.contains(&row) || text.contains(&heading), "{key}");
        }
        for row in [
            "| `length` | number or map | cm | `2` | ≥ 0 | Length. |",
            "| `color_tip` | colour or map | linear RGB | `[0.42, 0.3, 0.2]` | 0 to 1 | Colour at the tip. |",
            "## `[guard.fibre]`, `[undercoat.fibre]`",
            "| `at` | 3 numbers | cm | required |",
            "- `hat`: Brimmed fur hat",
        ] {
            assert!(text.contains(row), "no {row} in\n{text}");
        }
    }
}
