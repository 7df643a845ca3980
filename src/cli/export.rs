//! `pelage export`: strands, mesh, or the whole scene for other renderers.

use super::Global;
use super::args::SceneArgs;
use super::choice::choice;
use super::output::{self, count, human_bytes};
use clap::Args;
use pelage::export::{self, EnvironmentAs, Target};
use pelage::reference::{GrowOptions, estimate, grow};
use pelage::render::strands;
use pelage::{Result, World};
use pelage_core::files;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("what").required(true).multiple(true).args(["strands", "mesh", "to"]))]
#[command(after_long_help = "Examples:
  pelage export scenes/default.toml --to blender -o blender/
  pelage export scenes/default.toml --strands guard.hair --mesh skin.obj")]
pub(super) struct ExportArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Write the guard hairs in Cem Yuksel's HAIR format
    #[arg(long, value_name = "FILE.hair")]
    strands: Option<PathBuf>,
    /// Write the skin as OBJ, in world space, cm
    #[arg(long, value_name = "FILE.obj")]
    mesh: Option<PathBuf>,
    /// Write the whole scene with every hair for another renderer; comments in its scene file list
    /// what it cannot express
    #[arg(long, value_parser = choice::<Target>(), value_name = "TARGET", requires = "folder")]
    to: Option<Target>,
    /// Folder for --to; created if its parent exists
    #[arg(short = 'o', long, value_name = "FOLDER", requires = "to")]
    folder: Option<PathBuf>,
    /// Representation of the environment for --to
    #[arg(long, value_parser = choice::<EnvironmentAs>(), value_name = "AS", default_value = "map", requires = "to")]
    environment: EnvironmentAs,
}

/// Default limit of the main memory that the hairs of --to take, bytes.
const MEMORY: u64 = 16 << 30;

pub(super) fn run(args: &ExportArgs, global: &Global) -> Result<()> {
    let (scene, assets) = args.scene.load()?;
    args.strands.iter().chain(&args.mesh).try_for_each(|path| files::check_target(path))?;
    let whole = args.to.zip(args.folder.as_ref());
    if let Some((target, folder)) = whole {
        export::check_folder(folder, target)?;
    }
    let mut world = World::load(scene, &assets)?;
    output::admit(&mut world, args.strands.is_some() || whole.is_some(), global.quiet)?;
    if whole.is_some() {
        estimate(&world, &GrowOptions::default())?.check(args.scene.memory.unwrap_or(MEMORY))?;
    }
    let say = |text: String| if global.quiet { Ok(()) } else { output::print(&text) };
    if let Some(path) = &args.mesh {
        export::write_obj(&world.skin, path)?;
        say(format!("{}: {} triangles\n", path.display(), count(world.skin.triangles.len() as u64)))?;
    }
    if let Some(path) = &args.strands {
        let hair = strands(&world)?;
        hair.write(path)?;
        say(format!("{}: {} guard hairs\n", path.display(), count(hair.segments.len() as u64)))?;
    }
    if let Some((target, folder)) = whole {
        let strands = grow(&world, &GrowOptions::default())?;
        let mut bytes = 0;
        for file in export::write(&world, &strands, &assets, target, args.environment, folder)? {
            bytes += file.bytes;
            let holds = if file.holds.is_empty() { "main file".into() } else { file.holds };
            say(format!("{}: {}, {holds}\n", file.path.display(), human_bytes(file.bytes)))?;
        }
        say(format!("total {}\n", human_bytes(bytes)))?;
    }
    Ok(())
}
