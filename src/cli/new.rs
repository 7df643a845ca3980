//! `pelage new`: a scene file for a mesh, to begin from.

use super::args::SceneArgs;
use super::{Global, output};
use clap::Args;
use pelage::scene;
use pelage::{Error, Result, World};
use pelage_core::files;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(super) struct NewArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Scene file to write; stdout by default
    #[arg(long = "outfile", short = 'o', value_name = "SCENE.toml")]
    outfile: Option<PathBuf>,
    /// Overwrite the file if it exists
    #[arg(long)]
    force: bool,
}

/// Writes the scene with everything that was chosen for it, so that it renders as the mesh does.
pub(super) fn run(args: &NewArgs, global: &Global) -> Result<()> {
    if let Some(path) = args.outfile.as_ref().filter(|path| path.exists() && !args.force) {
        let message = "the file exists already; give another name, or --force to overwrite it";
        return Err(Error::io(path, message));
    }
    let (scene, assets) = args.scene.load()?;
    let mut world = World::load(scene, &assets)?;
    output::print_notes(&world.notes, global.quiet);
    let source = args.scene.scene.display();
    let skin = &world.skin;
    let mesh = &mut world.scene.mesh;
    if let Some(name) = mesh.path.clone() {
        let folder = args.outfile.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
        mesh.path = Some(relative(&assets.find(&name)?, folder)?);
        // What loading chose; a rotated body's sides are not those of its file.
        if mesh.size.is_none() && mesh.scale.is_none() && mesh.units.is_none() && mesh.rotate == [0.0; 3] {
            let (low, high) = skin.bounds();
            mesh.size = Some((high - low).max_element());
        }
    }
    let file = args.outfile.as_ref().map_or_else(|| "SCENE.toml".into(), |path| path.display().to_string());
    let about = format!(
        "A scene of {source}. What it does not give has its default: docs/scene.md lists all keys.\n\n  \
         pelage check {file}                  size, counts, memory, warnings\n  \
         pelage render {file} -o picture.png"
    );
    let text = scene::template(&world.scene, &about)?;
    match &args.outfile {
        Some(path) => {
            files::write_buffered(path, |out| Ok(std::io::Write::write_all(out, text.as_bytes())?))?;
            if global.quiet { Ok(()) } else { output::print(&format!("{file}\n")) }
        }
        None => output::print(&text),
    }
}

/// `path` as a scene file in `folder` names it: relative if it lies there, otherwise absolute.
fn relative(path: &Path, folder: &Path) -> Result<String> {
    let absolute = |path: &Path| {
        let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
        path.canonicalize().map_err(|e| Error::io(path, e))
    };
    let (path, folder) = (absolute(path)?, absolute(folder)?);
    let name = path.strip_prefix(&folder).unwrap_or(&path);
    let text =
        name.to_str().ok_or_else(|| Error::io(name, "the name is not UTF-8, which scene files need"))?;
    // Slashes work everywhere; in TOML a backslash begins an escape.
    Ok(if cfg!(windows) { text.replace('\\', "/") } else { text.to_owned() })
}
