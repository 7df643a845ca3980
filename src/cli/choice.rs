//! Command-line values of the library's enumerations. Their names and help come from the JSON
//! schema of each, so that the library does not depend on clap.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use schemars::JsonSchema;
use serde::{Serialize, de::DeserializeOwned};
use serde_json::Value;

/// A parser of the values of `T`, with the names that scene files use.
pub(super) fn choice<T>() -> impl TypedValueParser<Value = T>
where
    T: DeserializeOwned + JsonSchema + Clone + Send + Sync + 'static,
{
    PossibleValuesParser::new(values::<T>()).try_map(|name| serde_json::from_value::<T>(Value::String(name)))
}

/// The names of the values of `T`, with their descriptions.
fn values<T: JsonSchema>() -> Vec<PossibleValue> {
    let schema = schemars::schema_for!(T);
    let text = |value: &Value, key: &str| value.get(key).and_then(Value::as_str).map(str::to_owned);
    // The schema has an entry for each variant with a description, and a list of all others.
    let variants = schema.get("oneOf").and_then(Value::as_array).cloned();
    variants
        .unwrap_or_else(|| vec![schema.to_value()])
        .iter()
        .flat_map(|variant| match variant.get("enum").and_then(Value::as_array) {
            Some(list) => {
                list.iter().filter_map(Value::as_str).map(|w| PossibleValue::new(w.to_owned())).collect()
            }
            None => Vec::from_iter(text(variant, "const").map(|name| {
                let value = PossibleValue::new(name);
                match text(variant, "description") {
                    // The first paragraph as one line, without its full stop.
                    Some(help) => {
                        let line = help.split("\n\n").next().unwrap_or_default().replace('\n', " ");
                        value.help(line.trim_end_matches('.').to_owned())
                    }
                    None => value,
                }
            })),
        })
        .collect()
}

/// The name of a value.
pub(super) fn name<T: Serialize>(value: &T) -> Option<String> {
    Some(serde_json::to_value(value).ok()?.as_str()?.to_owned())
}
