//! Loads a [`Scene`] from files and flags.
//!
//! In order of precedence: flags of the command line, the scene file, its includes (a later one
//! before an earlier one), the preset, the defaults. Tables are merged key by key; arrays and groom
//! parameters are replaced as a whole.

use super::{
    Scene, check, overrides, parts, preset, rules, schema,
    tree::{Entry, Node, Sources, Table, Value},
};
use crate::assets::Assets;
use crate::{Error, Result, SceneFault, mesh};
use serde::Deserialize;
use serde_json::Value as Json;
use std::path::{Path, PathBuf};

/// Largest number of included files: a bound on chains that double at each step.
const MAX_FILES: usize = 64;

/// Vertical field of view of a camera that frames the fur by itself, degrees: about that of an 85
/// mm lens on 35 mm film.
const PORTRAIT_FOV: f64 = 20.0;

/// The preset of a mesh that comes without a scene.
pub const DEFAULT_PRESET: &str = "brown_mink";

/// The ground of a mesh that is rendered as it comes.
const GROUND: &str = "place = \"under\"\nmesh = { shape = \"disc\" }\nshadow_catcher = true\n";

/// A value from the command line that overrides the scene file.
#[derive(Debug, Clone, PartialEq)]
pub struct Override {
    /// What the user typed, for messages: `-D camera.fov=30` or `--spp 16`.
    pub flag: String,
    /// Dotted path: `camera.fov`, `lights.0.irradiance`.
    pub path: String,
    /// TOML value; text that is no TOML value is taken as a string.
    pub value: String,
}

impl Override {
    /// An override from `key.path=value`, the argument of `-D`.
    ///
    /// # Errors
    /// [`Error::Scene`] if `=` or the key is missing.
    pub fn parse(argument: &str) -> Result<Self> {
        let flag = format!("-D {argument}");
        match argument.split_once('=') {
            Some((path, value)) if !path.trim().is_empty() => {
                Ok(Self { flag, path: path.trim().to_owned(), value: value.trim().to_owned() })
            }
            _ => Err(Error::fault(flag, "expected key.path=value, for example camera.fov=30")),
        }
    }
}

impl Scene {
    /// Loads a scene file, its includes and its preset, applies `overrides` (`key.path=value`), and
    /// checks that every file that the scene names exists. A mesh file stands for the scene of that
    /// mesh in [`DEFAULT_PRESET`].
    ///
    /// # Errors
    /// [`Error::Scene`] with all faults of all files, each with its position.
    pub fn load(path: &Path, overrides: &[String]) -> Result<(Self, Assets)> {
        Self::load_with(path, &parse_all(overrides)?)
    }

    /// As [`Scene::load`], with overrides that know the flag they came from.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn load_with(path: &Path, overrides: &[Override]) -> Result<(Self, Assets)> {
        let text = match mesh::kind_of(path) {
            Some(_) => scene_of_mesh(path),
            None => read_text(path)?,
        };
        let mut loader = Loader::default();
        let (scene, tree, mut faults) = loader.scene(path, &text, overrides)?;
        let mut assets = Assets::of_folder(folder_of(path));
        for file in &loader.included {
            let folder = folder_of(file).to_owned();
            if !assets.folders.contains(&folder) {
                assets.folders.insert(1, folder);
            }
        }
        if !overrides.is_empty() {
            // File names on the command line are relative to the working directory.
            assets.folders.push(PathBuf::from("."));
        }
        faults.extend(rules::missing_files(&tree, &loader.sources, &assets));
        loader.finish(scene, faults).map(|scene| (scene, assets))
    }

    /// Parses the text of a scene file. Messages show `name`, and includes are relative to it.
    /// Whether the files that the scene names exist is not checked.
    ///
    /// # Errors
    /// As [`Scene::load`].
    pub fn parse(text: &str, name: &str, overrides: &[String]) -> Result<Self> {
        let mut loader = Loader::default();
        let (scene, _, faults) = loader.scene(Path::new(name), text, &parse_all(overrides)?)?;
        loader.finish(scene, faults)
    }
}

fn read_text(path: &Path) -> Result<String> {
    let text = std::fs::read(path).map_err(|e| {
        let why = match e.kind() {
            std::io::ErrorKind::NotFound => "the file is not there".to_owned(),
            _ => format!("cannot be read: {e}"),
        };
        Error::fault(path, format!("{why}; expected a scene or a mesh (example scenes are in scenes/)"))
    })?;
    String::from_utf8(text).map_err(|e| {
        let line = e.as_bytes()[..e.utf8_error().valid_up_to()].iter().filter(|b| **b == b'\n').count() + 1;
        Error::fault_at(path, line, "not UTF-8 text, expected a scene file in TOML")
    })
}

/// The scene of a mesh alone.
fn scene_of_mesh(path: &Path) -> String {
    let name = toml::Value::String(short(path));
    // Each object has a name of its own, and the body has that of its file.
    let ground = if path.file_stem().is_some_and(|stem| stem == "ground") { "floor" } else { "ground" };
    format!(
        "preset = \"{DEFAULT_PRESET}\"\n[mesh]\npath = {name}\nfront = \"auto\"\n[[objects]]\nname = \"{ground}\"\n{GROUND}"
    )
}

fn parse_all(overrides: &[String]) -> Result<Vec<Override>> {
    let (mut parsed, mut faults) = (Vec::new(), Vec::new());
    for argument in overrides {
        match Override::parse(argument) {
            Ok(o) => parsed.push(o),
            Err(Error::Scene(f)) => faults.extend(f),
            Err(other) => return Err(other),
        }
    }
    if faults.is_empty() { Ok(parsed) } else { Err(Error::Scene(faults)) }
}

#[derive(Default)]
struct Loader {
    sources: Sources,
    faults: Vec<SceneFault>,
    /// Included files, in the order of reading.
    included: Vec<PathBuf>,
}

impl Loader {
    /// The valid part of the scene, its tree, and all faults.
    fn scene(
        &mut self,
        path: &Path,
        text: &str,
        overrides: &[Override],
    ) -> Result<(Scene, Node, Vec<SceneFault>)> {
        let Some(mut tree) = self.file(path, text, &mut Vec::new()) else {
            return Err(Error::Scene(sorted(std::mem::take(&mut self.faults))));
        };
        // The preset is chosen first, so that other overrides can change its values.
        let (chosen, others): (Vec<_>, Vec<_>) = overrides.iter().partition(|o| o.path == "preset");
        for o in chosen {
            self.faults.extend(overrides::set(&mut tree, &mut self.sources, o));
        }
        self.preset("", &mut tree, schema::json_schema());
        for o in others {
            self.faults.extend(overrides::set(&mut tree, &mut self.sources, o));
        }
        self.parts(&mut tree);
        self.frame(&mut tree);
        let (tree, found) = check::check(&self.sources, tree);
        let found = parts::once(found);
        let mut faults = std::mem::take(&mut self.faults);
        let mut scene = Scene::deserialize(tree.to_toml()).map_err(|e| {
            Error::fault(path, format!("{} (which the schema does not exclude)", e.message()))
        })?;
        parts::locate(&mut scene, &tree, &self.sources);
        faults.extend(rules::broken(&scene, &tree, &self.sources, &found));
        faults.extend(found.into_iter().map(|(_, fault)| fault));
        scene.schema = None;
        scene.scale_groom();
        Ok((scene, tree, faults))
    }

    fn finish(&self, scene: Scene, faults: Vec<SceneFault>) -> Result<Scene> {
        if faults.is_empty() { Ok(scene) } else { Err(Error::Scene(sorted(faults))) }
    }

    /// Parses a file and merges its includes under it. `None` if it is no TOML; the faults are
    /// collected.
    fn file(&mut self, path: &Path, text: &str, stack: &mut Vec<PathBuf>) -> Option<Node> {
        let mut tree = match self.sources.parse(path, text) {
            Ok(tree) => tree,
            Err(faults) => {
                self.faults.extend(faults);
                return None;
            }
        };
        let Some(Value::Array(items)) = tree.get("include").map(|n| n.value.clone()) else {
            return Some(tree);
        };
        if !items.iter().all(|i| matches!(i.value, Value::String(_))) {
            return Some(tree); // The schema check reports the wrong type.
        }
        if let Some(table) = tree.as_table_mut() {
            table.remove("include");
        }
        stack.push(identity(path));
        for item in items.iter().rev() {
            if let Some(under) = self.include(path, item, stack) {
                merge(&mut tree, under, schema::json_schema());
            }
        }
        stack.pop();
        Some(tree)
    }

    fn include(&mut self, from: &Path, item: &Node, stack: &mut Vec<PathBuf>) -> Option<Node> {
        let Value::String(name) = &item.value else { return None };
        let path = folder_of(from).join(name);
        let fault = |message: String, help: Option<String>| self.sources.fault(&item.origin, message, help);
        let id = identity(&path);
        if let Some(start) = stack.iter().position(|file| *file == id) {
            let chain: Vec<_> = stack[start..].iter().chain([&id]).map(|p| short(p)).collect();
            let fault = fault(
                format!("include cycle: {}", chain.join(" -> ")),
                Some("remove one of these includes".into()),
            );
            self.faults.push(fault);
            return None;
        }
        if self.included.len() >= MAX_FILES {
            let fault = fault(format!("more than {MAX_FILES} included files"), None);
            self.faults.push(fault);
            return None;
        }
        match std::fs::read_to_string(&path) {
            Ok(text) => {
                self.included.push(path.clone());
                self.file(&path, &text, stack)
            }
            Err(e) => {
                let help = "includes are relative to the file that names them".to_owned();
                let fault = fault(format!("cannot include \"{name}\" ({}): {e}", path.display()), Some(help));
                self.faults.push(fault);
                None
            }
        }
    }

    /// A camera without position and target frames the fur, through a portrait lens unless `fov` is
    /// given.
    fn frame(&mut self, tree: &mut Node) {
        let origin = self.sources.add("camera", None);
        let chosen = |value| Entry { key: origin.clone(), node: Node { origin: origin.clone(), value } };
        let Some(root) = tree.as_table_mut() else { return };
        let camera = root.entry("camera".into()).or_insert_with(|| chosen(Value::Table(Table::new())));
        // The schema check reports a camera that is no table.
        let Some(camera) = camera.node.as_table_mut() else { return };
        let frame =
            if camera.contains_key("eye") || camera.contains_key("target") { "given" } else { "auto" };
        let frame = camera.entry("frame".into()).or_insert_with(|| chosen(Value::String(frame.into())));
        if matches!(&frame.node.value, Value::String(frame) if frame == "auto") {
            camera.entry("fov".into()).or_insert_with(|| chosen(Value::Float(PORTRAIT_FOV)));
        }
    }

    /// Merges the preset that the table at `path` names under it.
    fn preset(&mut self, path: &str, tree: &mut Node, schema: &'static Json) {
        let Some(node) = tree.get("preset") else { return };
        let Value::String(name) = &node.value else { return };
        let Some(text) = preset::text(name) else {
            let names: Vec<_> = preset::names().collect();
            let help = match schema::nearest(name, names.iter().copied()) {
                Some(near) => format!("did you mean \"{near}\"?"),
                None => format!("there are {}", schema::list(&names)),
            };
            self.faults.push(self.sources.fault(
                &node.origin,
                format!("{}: no preset is called \"{name}\"", check::join(path, "preset")),
                Some(help),
            ));
            return;
        };
        match self.sources.parse(Path::new(&format!("presets/{name}.toml")), text) {
            Ok(under) => merge(tree, under, schema),
            Err(faults) => self.faults.extend(faults),
        }
    }

    /// Gives each part its coat: its own keys over those of its preset over those of the scene's
    /// own coat.
    fn parts(&mut self, tree: &mut Node) {
        let Some(schema) = parts::schema() else { return };
        let own = parts::own_coat(tree);
        let Some(items) = parts::items(tree) else { return };
        for (i, part) in items.iter_mut().enumerate() {
            let path = format!("parts.{i}");
            if parts::is_bare(part) {
                self.faults.extend(parts::hairs_of_bare_skin(&path, part, &self.sources));
                continue;
            }
            self.preset(&path, part, schema);
            merge(part, own.clone(), schema);
        }
    }
}

/// Adds to `over` what only `under` has.
fn merge(over: &mut Node, under: Node, schema: &'static Json) {
    let schema = schema::resolve(schema);
    if schema::kind(schema) != Some("object") {
        return;
    }
    let (Some(table), Value::Table(below)) = (over.as_table_mut(), under.value) else { return };
    // A mesh comes from a path or a shape: the one of higher precedence hides the other.
    let hides = |a: &str, b: &str, key: &str| key == b && table.contains_key(a) && is_mesh(schema);
    let hidden: Vec<_> =
        below.keys().filter(|k| hides("path", "shape", k) || hides("shape", "path", k)).cloned().collect();
    for (key, entry) in below {
        if hidden.contains(&key) {
            continue;
        }
        match table.get_mut(&key) {
            Some(own) => {
                if let Some(inner) = schema::property(schema, &key) {
                    merge(&mut own.node, entry.node, inner);
                }
            }
            None => {
                table.insert(key, entry);
            }
        }
    }
}

fn is_mesh(schema: &'static Json) -> bool {
    schema::property(schema, "path").is_some() && schema::property(schema, "shape").is_some()
}

/// Sorted by file, then by line.
fn sorted(mut faults: Vec<SceneFault>) -> Vec<SceneFault> {
    faults.sort_by(|a, b| (&a.file, a.line, a.column).cmp(&(&b.file, b.line, b.column)));
    faults
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

fn identity(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

fn short(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}
