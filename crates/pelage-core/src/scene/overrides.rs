//! Sets values from the command line in the tree before it is checked.

use super::{
    Override, Scene,
    tree::{Entry, Node, Origin, Sources, Table, Value},
};
use crate::SceneFault;

/// Sets `o` in `tree`. Missing tables on its path are created; an array that the files do not give
/// starts from its default.
pub(super) fn set(tree: &mut Node, sources: &mut Sources, o: &Override) -> Option<SceneFault> {
    let origin = sources.add(&o.flag, None);
    let fault = |message: String, help: &str| Some(sources.fault(&origin, message, Some(help.into())));
    if o.path == "include" {
        return fault(
            "found include, which cannot be set from the command line".into(),
            "write it into the scene file",
        );
    }
    let keys: Vec<&str> = o.path.split('.').collect();
    if keys.iter().any(|k| k.is_empty()) {
        return fault(
            format!("found \"{}\", expected a key path", o.path),
            "write key.path=value, e.g. camera.fov=30",
        );
    }
    let value = sources.parse_value(&origin, &o.value);
    match place(tree, &keys, &origin) {
        Ok(node) => {
            *node = value;
            node.origin = origin.clone();
            // A mesh comes from a file or from a shape: the flag decides.
            if let (["mesh", chosen @ ("path" | "shape")], Some(mesh)) = (&keys[..], mesh_of(tree)) {
                mesh.remove(if *chosen == "path" { "shape" } else { "path" });
            }
            None
        }
        Err(message) => fault(message, "pelage schema prints all keys; array items are numbered from 0"),
    }
}

fn mesh_of(tree: &mut Node) -> Option<&mut Table> {
    tree.as_table_mut()?.get_mut("mesh")?.node.as_table_mut()
}

/// The node at `keys`, created if it is missing.
fn place<'a>(tree: &'a mut Node, keys: &[&str], origin: &Origin) -> Result<&'a mut Node, String> {
    let mut node = tree;
    for (depth, key) in keys.iter().enumerate() {
        let path = || keys[..depth].join(".");
        let index = key.parse::<usize>().ok();
        if let (Some(_), Value::Table(table)) = (index, &node.value)
            && table.is_empty()
            && let Some(default) = default_array(&path(), origin)
        {
            *node = default;
        }
        if !matches!(node.value, Value::Table(_) | Value::Array(_)) {
            *node = Node::empty(origin.clone());
        }
        node = match &mut node.value {
            Value::Array(items) => {
                let length = items.len();
                match index {
                    Some(i) if i < length => &mut items[i],
                    Some(i) if i == length => {
                        items.push(Node::empty(origin.clone()));
                        &mut items[i]
                    }
                    Some(i) => return Err(format!("{} has length {length}, there is no item {i}", path())),
                    None => {
                        return Err(format!(
                            "found \"{key}\" after {}, expected an index of the array",
                            path()
                        ));
                    }
                }
            }
            Value::Table(table) => {
                let new = || Entry { key: origin.clone(), node: Node::empty(origin.clone()) };
                &mut table.entry((*key).to_owned()).or_insert_with(new).node
            }
            _ => return Err(format!("{} has no keys", path())),
        };
    }
    Ok(node)
}

/// The default of an array-valued key.
fn default_array(path: &str, origin: &Origin) -> Option<Node> {
    let defaults = toml::Value::try_from(Scene::default()).ok()?;
    let found = path.split('.').try_fold(&defaults, |value, key| value.get(key))?;
    found.is_array().then(|| Node::from_toml(origin, found.clone()))
}
