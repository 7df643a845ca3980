//! How parts are loaded: what they inherit, and rules beyond types and ranges.

use super::{
    Place, Scene, check,
    rules::{MAPPED, NEGATIVE},
    schema,
    tree::{Node, Sources, Table, Value},
};
use crate::SceneFault;
use serde_json::Value as Json;

/// The schema of a part.
pub(super) fn schema() -> Option<&'static Json> {
    let parts = schema::resolve(schema::property(schema::json_schema(), "parts")?);
    Some(schema::resolve(parts.get("items")?))
}

/// The tables of the scene that make its own coat.
pub(super) fn own_coat(tree: &Node) -> Node {
    let mut coat = Table::new();
    for key in ["guard", "undercoat", "base"] {
        if let Some(entry) = tree.as_table().and_then(|table| table.get(key)) {
            coat.insert(key.to_owned(), entry.clone());
        }
    }
    Node { origin: tree.origin.clone(), value: Value::Table(coat) }
}

/// The parts of a scene that are tables.
pub(super) fn items(tree: &mut Node) -> Option<&mut [Node]> {
    match &mut tree.as_table_mut()?.get_mut("parts")?.node.value {
        Value::Array(items) => Some(items),
        _ => None,
    }
}

/// Whether a part has no fur.
pub(super) fn is_bare(part: &Node) -> bool {
    part.get("fur").is_some_and(|node| matches!(node.value, Value::Boolean(false)))
}

/// Faults for keys that describe the hairs of bare skin.
pub(super) fn hairs_of_bare_skin(path: &str, part: &Node, sources: &Sources) -> Vec<SceneFault> {
    let fault = |key: &str, entry: &super::tree::Entry| {
        let message = format!("{path}.{key}: found hairs of a part with fur = false");
        sources.fault(&entry.key, message, Some("take one of the two away; base is allowed".into()))
    };
    let Some(table) = part.as_table() else { return Vec::new() };
    ["preset", "guard", "undercoat"].iter().filter_map(|key| Some(fault(key, table.get(*key)?))).collect()
}

/// Faults, each once: a part inherits the faults of the scene's own coat.
pub(super) fn once(mut found: Vec<(String, SceneFault)>) -> Vec<(String, SceneFault)> {
    let place = |fault: &SceneFault| (fault.file.clone(), fault.line, fault.column);
    let in_part = |path: &str| path.starts_with("parts.");
    found.sort_by_key(|(path, _)| in_part(path));
    let mut kept: Vec<(String, SceneFault)> = Vec::new();
    for (path, fault) in found {
        if !(in_part(&path) && kept.iter().any(|(_, known)| place(known) == place(&fault))) {
            kept.push((path, fault));
        }
    }
    kept
}

/// Records where parts choose a region, for the faults that only the mesh shows.
pub(super) fn locate(scene: &mut Scene, tree: &Node, sources: &Sources) {
    for (i, part) in scene.parts.iter_mut().enumerate() {
        part.places = ["group", "material", "balls"].map(|key| {
            let fault = sources.fault(tree.origin_of(&format!("parts.{i}.{key}")), "", None);
            Place { file: fault.file, line: fault.line, column: fault.column }
        });
    }
}

/// The faults of parts whose values contradict each other.
pub(super) fn broken(scene: &Scene, tree: &Node, sources: &Sources) -> Vec<SceneFault> {
    let mut faults = Vec::new();
    for (i, part) in scene.parts.iter().enumerate() {
        let path = format!("parts.{i}");
        let mut rule = |holds: bool, key: &str, message: &str, help: &str| {
            if !holds {
                let at = if key.is_empty() { path.clone() } else { check::join(&path, key) };
                let message = format!("{at}: {message}");
                faults.push((at.clone(), sources.fault(tree.origin_of(&at), message, Some(help.to_owned()))));
            }
        };
        rule(
            part.has_region() || part.mask.is_some(),
            "",
            "found none of group, material, balls and mask",
            "name groups or materials of the mesh, or give balls or a mask",
        );
        rule(
            part.edge.is_none() || part.has_region(),
            "edge",
            "found without group, material or balls",
            "a mask has its own transition: blur the image",
        );
        if let Some(mask) = &part.mask {
            rule((mask.value + mask.offset).max(mask.offset) > 0.0, "mask", NEGATIVE, MAPPED);
        }
        for (key, scalar) in scene.coat_of(part).iter().flat_map(|coat| coat.scalars()) {
            let own = scene.own_coat().scalars().into_iter().any(|(k, s)| k == key && s == scalar);
            rule(own || scalar.max() >= 0.0, key, NEGATIVE, MAPPED);
        }
    }
    once(faults).into_iter().map(|(_, fault)| fault).collect()
}
