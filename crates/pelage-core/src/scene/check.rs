//! Checks a tree against the JSON schema: unknown keys, types, words, ranges. All faults are
//! collected. Faulty values are left out of the tree, so that later checks still see the rest.

use super::{
    schema,
    tree::{Node, Sources, Table, Value},
};
use crate::SceneFault;
use serde_json::Value as Json;

/// The tree without its faulty values, and the faults, each with its dotted path.
pub(super) fn check(sources: &Sources, tree: Node) -> (Node, Vec<(String, SceneFault)>) {
    let mut checker = Checker { sources, faults: Vec::new() };
    let empty = Node::empty(tree.origin.clone());
    let tree = checker.value("", tree, schema::json_schema(), Bounds::default()).unwrap_or(empty);
    (tree, checker.faults)
}

/// The limits of a number. The schema may have them beside a `$ref`, so they are collected on the
/// way down.
#[derive(Clone, Copy, Default)]
struct Bounds {
    minimum: Option<f64>,
    maximum: Option<f64>,
    above: Option<f64>,
    below: Option<f64>,
}

impl Bounds {
    fn and(self, schema: &Json) -> Self {
        let number = |key| schema.get(key).and_then(Json::as_f64);
        Self {
            minimum: number("minimum").or(self.minimum),
            maximum: number("maximum").or(self.maximum),
            above: number("exclusiveMinimum").or(self.above),
            below: number("exclusiveMaximum").or(self.below),
        }
    }

    fn contains(&self, x: f64) -> bool {
        self.minimum.is_none_or(|min| x >= min)
            && self.maximum.is_none_or(|max| x <= max)
            && self.above.is_none_or(|above| x > above)
            && self.below.is_none_or(|below| x < below)
    }
}

impl std::fmt::Display for Bounds {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let parts = [
            (self.minimum, "at least"),
            (self.above, "greater than"),
            (self.maximum, "at most"),
            (self.below, "less than"),
        ];
        let words: Vec<_> =
            parts.iter().filter_map(|(bound, word)| bound.map(|b| format!("{word} {b}"))).collect();
        f.write_str(&words.join(" and "))
    }
}

struct Checker<'a> {
    sources: &'a Sources,
    faults: Vec<(String, SceneFault)>,
}

impl Checker<'_> {
    fn fault(&mut self, path: &str, node: &Node, message: String, help: Option<String>) {
        let message = if path.is_empty() { message } else { format!("{path}: {message}") };
        self.faults.push((path.to_owned(), self.sources.fault(&node.origin, message, help)));
    }

    /// The valid part of the node; `None` if it has the wrong type or is out of range.
    fn value(&mut self, path: &str, node: Node, schema: &'static Json, bounds: Bounds) -> Option<Node> {
        let bounds = bounds.and(schema);
        if let Some(target) = schema::reference(schema) {
            return self.value(path, node, target, bounds);
        }
        match schema::variants(schema)[..] {
            [] => self.plain(path, node, schema, bounds),
            [only] => self.value(path, node, only, bounds),
            ref several => match several.iter().find(|s| fits(&node, schema::resolve(s))) {
                Some(variant) => self.value(path, node, variant, bounds),
                None => self.wrong_kind(path, &node, schema),
            },
        }
    }

    fn wrong_kind(&mut self, path: &str, node: &Node, schema: &'static Json) -> Option<Node> {
        let message = format!("expected {}, found {}", schema::describe(schema), node.describe());
        self.fault(path, node, message, None);
        None
    }

    fn plain(&mut self, path: &str, node: Node, schema: &'static Json, bounds: Bounds) -> Option<Node> {
        if !fits(&node, schema) {
            return self.wrong_kind(path, &node, schema);
        }
        let Node { origin, value } = node;
        match value {
            Value::Table(table) => {
                let table = self.table(path, &origin, table, schema)?;
                Some(Node { origin, value: Value::Table(table) })
            }
            Value::Array(items) => {
                let length = items.len() as u64;
                let wrong = |key, bad: fn(u64, u64) -> bool| {
                    schema.get(key).and_then(Json::as_u64).is_some_and(|limit| bad(length, limit))
                };
                let (short, long) =
                    (wrong("minItems", |n, min| n < min), wrong("maxItems", |n, max| n > max));
                let node = Node { origin, value: Value::Array(items) };
                if short || long {
                    return self.wrong_kind(path, &node, schema);
                }
                let (Value::Array(items), Some(item)) = (node.value, schema.get("items")) else {
                    return None;
                };
                let checked: Vec<_> = items
                    .into_iter()
                    .enumerate()
                    .map(|(i, node)| self.value(&join(path, &i.to_string()), node, item, Bounds::default()))
                    .collect();
                let items = checked.into_iter().collect::<Option<_>>()?;
                Some(Node { origin: node.origin, value: Value::Array(items) })
            }
            Value::String(s) => {
                let words = schema::words(schema);
                let node = Node { origin, value: Value::String(s.clone()) };
                if words.is_empty() || words.contains(&s.as_str()) {
                    return Some(node);
                }
                let help = schema::nearest(&s, words.iter().copied());
                let message = format!("expected one of {}, found \"{s}\"", schema::list(&words));
                self.fault(path, &node, message, help.map(|w| format!("did you mean \"{w}\"?")));
                None
            }
            Value::Integer(i) if schema::kind(schema) == Some("integer") => {
                let node = Node { origin, value: Value::Integer(i) };
                self.number(path, node, i as f64, schema, bounds)
            }
            Value::Integer(i) => {
                let node = Node { origin, value: Value::Float(i as f64) };
                self.number(path, node, i as f64, schema, bounds)
            }
            Value::Float(x) => {
                let node = Node { origin, value: Value::Float(x) };
                self.number(path, node, x, schema, bounds)
            }
            value => Some(Node { origin, value }),
        }
    }

    fn number(
        &mut self,
        path: &str,
        node: Node,
        x: f64,
        schema: &'static Json,
        bounds: Bounds,
    ) -> Option<Node> {
        if !x.is_finite() || x.abs() > f64::from(f32::MAX) {
            self.fault(path, &node, format!("expected a finite number, found {x}"), None);
            return None;
        }
        // The schema gives unsigned 32-bit integers no upper limit of their own.
        let width = match schema.get("format").and_then(Json::as_str) {
            Some("uint32") => Bounds { maximum: Some(f64::from(u32::MAX)), ..Bounds::default() },
            _ => Bounds::default(),
        };
        let bounds = Bounds { maximum: bounds.maximum.or(width.maximum), ..bounds };
        if !bounds.contains(x) {
            self.fault(path, &node, format!("must be {bounds}, found {x}"), None);
            return None;
        }
        Some(node)
    }

    fn table(
        &mut self,
        path: &str,
        origin: &super::tree::Origin,
        table: Table,
        schema: &'static Json,
    ) -> Option<Table> {
        let mut valid = Table::new();
        let mut whole = true;
        for required in schema.get("required").and_then(Json::as_array).into_iter().flatten() {
            let key = required.as_str().unwrap_or_default();
            if !table.contains_key(key) {
                let node = Node::empty(origin.clone());
                self.fault(path, &node, format!("the key \"{key}\" is missing"), None);
                whole = false;
            }
        }
        for (key, entry) in table {
            let inner = join(path, &key);
            match schema::property(schema, &key) {
                Some(schema) => {
                    if let Some(node) = self.value(&inner, entry.node, schema, Bounds::default()) {
                        valid.insert(key, super::tree::Entry { key: entry.key, node });
                    }
                }
                None => {
                    let known: Vec<_> = properties(schema);
                    let help = match schema::nearest(&key, known.iter().copied()) {
                        Some(near) => format!("did you mean \"{near}\"?"),
                        None => {
                            elsewhere(&key, path).unwrap_or_else(|| format!("known: {}", known.join(", ")))
                        }
                    };
                    let place = if path.is_empty() { "the scene".into() } else { format!("[{path}]") };
                    let fault = self.sources.fault(
                        &entry.key,
                        format!("unknown key \"{key}\" in {place}"),
                        Some(help),
                    );
                    self.faults.push((inner, fault));
                }
            }
        }
        whole.then_some(valid)
    }
}

/// Whether a value has the type that a schema without alternatives expects.
fn fits(node: &Node, schema: &'static Json) -> bool {
    let string = !schema::words(schema).is_empty() || schema::kind(schema) == Some("string");
    match (&node.value, schema::kind(schema)) {
        (Value::String(_), _) => string,
        (Value::Integer(_), Some("integer" | "number")) => true,
        (Value::Float(_), Some("number")) => true,
        (Value::Boolean(_), Some("boolean")) => true,
        (Value::Array(_), Some("array")) => true,
        (Value::Table(_), Some("object")) => true,
        _ => false,
    }
}

fn properties(schema: &'static Json) -> Vec<&'static str> {
    schema::properties(schema).map(|(key, _)| key).collect()
}

/// Help for a key in the wrong table: where it belongs.
fn elsewhere(key: &str, path: &str) -> Option<String> {
    let root = schema::json_schema();
    if !path.is_empty() && schema::property(root, key).is_some() {
        return Some(format!("\"{key}\" belongs to the top of the file, before the first [table]"));
    }
    schema::properties(root)
        .find(|(_, table)| schema::property(schema::resolve(table), key).is_some())
        .map(|(table, _)| format!("did you mean \"{table}.{key}\"?"))
}

/// The dotted path of `key` in the table at `path`.
pub(super) fn join(path: &str, key: &str) -> String {
    if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") }
}
