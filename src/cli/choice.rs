//! Command-line values of the library's enumerations. Words and help come from the JSON schema of each, so that the library
//! needs no clap.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use schemars::JsonSchema;
use serde::{Serialize, de::DeserializeOwned};
use serde_json::Value;

/// Parses the words of `T` as scene files spell them.
pub(super) fn choice<T>() -> impl TypedValueParser<Value = T>
where
    T: DeserializeOwned + JsonSchema + Clone + Send + Sync + 'static,
{
    PossibleValuesParser::new(words::<T>()).try_map(|word| serde_json::from_value::<T>(Value::String(word)))
}

/// The words of `T` with their descriptions.
fn words<T: JsonSchema>() -> Vec<PossibleValue> {
    let schema = schemars::schema_for!(T);
    let text = |value: &Value, key: &str| value.get(key).and_then(Value::as_str).map(str::to_owned);
    // Variants with a description stand one by one, all others in a list.
    let variants = schema.get("oneOf").and_then(Value::as_array).cloned();
    variants
        .unwrap_or_else(|| vec![schema.to_value()])
        .iter()
        .flat_map(|variant| match variant.get("enum").and_then(Value::as_array) {
            Some(list) => {
                list.iter().filter_map(Value::as_str).map(|w| PossibleValue::new(w.to_owned())).collect()
            }
            None => Vec::from_iter(text(variant, "const").map(|word| {
                let value = PossibleValue::new(word);
                match text(variant, "description") {
                    // Of longer descriptions the first paragraph, as one line and without its full stop.
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

/// The word of a value.
pub(super) fn word<T: Serialize>(value: &T) -> Option<String> {
    Some(serde_json::to_value(value).ok()?.as_str()?.to_owned())
}
