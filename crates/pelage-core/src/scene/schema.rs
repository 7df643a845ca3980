//! The JSON schema of a scene file, derived from the types, and the loader's queries to it.

use serde_json::Value as Json;
use std::sync::LazyLock;

static SCHEMA: LazyLock<Json> = LazyLock::new(|| {
    let mut schema = schemars::schema_for!(super::Scene).to_value();
    if let Some(object) = schema.as_object_mut() {
        object.insert("title".into(), "pelage scene".into());
    }
    schema
});

/// The JSON schema (draft 2020-12) of a scene file, its ranges included.
pub fn json_schema() -> &'static Json {
    &SCHEMA
}

/// Follows `$ref` and `anyOf [X, null]` to the schema that describes a value.
pub(super) fn resolve(mut schema: &'static Json) -> &'static Json {
    loop {
        if let Some(target) = reference(schema) {
            schema = target;
        } else if let [only] = variants(schema)[..] {
            schema = only;
        } else {
            return schema;
        }
    }
}

/// The target of `$ref`, if the schema is one.
pub(super) fn reference(schema: &'static Json) -> Option<&'static Json> {
    SCHEMA.pointer(schema.get("$ref")?.as_str()?.strip_prefix('#')?)
}

/// The alternatives of `anyOf`, without `null`; empty where there is no `anyOf`.
pub(super) fn variants(schema: &'static Json) -> Vec<&'static Json> {
    let all = schema.get("anyOf").and_then(Json::as_array).map(Vec::as_slice).unwrap_or_default();
    all.iter().filter(|s| kind(s) != Some("null")).collect()
}

/// The JSON type of a schema; `null` beside another type is ignored.
pub(super) fn kind(schema: &Json) -> Option<&str> {
    match schema.get("type")? {
        Json::String(kind) => Some(kind),
        Json::Array(kinds) => kinds.iter().filter_map(Json::as_str).find(|k| *k != "null"),
        _ => None,
    }
}

/// The properties of a table; empty if the schema is no table.
pub(super) fn properties(schema: &'static Json) -> impl Iterator<Item = (&'static str, &'static Json)> {
    schema
        .get("properties")
        .and_then(Json::as_object)
        .into_iter()
        .flatten()
        .map(|(key, schema)| (key.as_str(), schema))
}

/// The schema of a key of a table.
pub(super) fn property(schema: &'static Json, key: &str) -> Option<&'static Json> {
    schema.get("properties")?.get(key)
}

/// The values that a string may have; empty if any string will do.
pub(super) fn words(schema: &'static Json) -> Vec<&'static str> {
    let listed = schema.get("enum").and_then(Json::as_array).into_iter().flatten();
    let constants = schema.get("oneOf").and_then(Json::as_array).into_iter().flatten();
    listed.chain(constants.filter_map(|s| s.get("const"))).filter_map(Json::as_str).collect()
}

/// What a schema expects, for messages.
pub(super) fn describe(schema: &'static Json) -> String {
    let schema = resolve(schema);
    let alternatives = variants(schema);
    if !alternatives.is_empty() {
        return alternatives.into_iter().map(describe).collect::<Vec<_>>().join(" or ");
    }
    let words = words(schema);
    if !words.is_empty() {
        return format!("one of {}", list(&words));
    }
    match kind(schema) {
        Some("number") => "a number".into(),
        Some("integer") => "an integer".into(),
        Some("string") => "a string".into(),
        Some("boolean") => "true or false".into(),
        Some("array") => {
            let item = schema.get("items").map_or_else(|| "values".into(), |items| plural(resolve(items)));
            match schema.get("minItems").and_then(Json::as_u64) {
                Some(n) => format!("an array of {n} {item}"),
                None => match schema.get("maxItems").and_then(Json::as_u64) {
                    Some(most) => format!("an array of at most {most} {item}"),
                    None => format!("an array of {item}"),
                },
            }
        }
        Some("object") => {
            let keys: Vec<_> = properties(schema).map(|(key, _)| key).collect();
            if keys.len() > 4 { "a table".into() } else { format!("a table of {}", keys.join(", ")) }
        }
        _ => "a value".into(),
    }
}

fn plural(schema: &Json) -> String {
    match kind(schema) {
        Some("number") => "numbers",
        Some("integer") => "integers",
        Some("string") => "strings",
        Some("object") => "tables",
        _ => "values",
    }
    .into()
}

/// Words in quotes, with commas.
pub(super) fn list(words: &[&str]) -> String {
    words.iter().map(|w| format!("\"{w}\"")).collect::<Vec<_>>().join(", ")
}

/// The candidate that `word` was probably meant to be.
pub(super) fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = word.to_lowercase();
    candidates
        .into_iter()
        .map(|c| (strsim::damerau_levenshtein(&lower, &c.to_lowercase()), c))
        .min_by_key(|(distance, _)| *distance)
        .filter(|(distance, c)| *distance <= 1.max(c.len() / 3).max(word.len() / 4))
        .map(|(_, c)| c)
}
