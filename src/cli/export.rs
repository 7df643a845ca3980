//! `pelage export`: what is rendered, for other renderers.

use super::{
    Global,
    args::SceneArgs,
    output::{self, count},
};
use crate::{Result, World, files, mesh, render};
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("what").required(true).multiple(true).args(["strands", "mesh"]))]
pub(super) struct ExportArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Write the guard hairs in Cem Yuksel's HAIR format.
    #[arg(long, value_name = "FILE.hair")]
    strands: Option<PathBuf>,
    /// Write the skin, in world space, cm.
    #[arg(long, value_name = "FILE.obj")]
    mesh: Option<PathBuf>,
}

pub(super) fn run(args: &ExportArgs, global: &Global) -> Result<()> {
    let (scene, assets) = args.scene.load()?;
    args.strands.iter().chain(&args.mesh).try_for_each(|path| files::check_target(path))?;
    let world = World::load(scene, &assets)?;
    let say = |text: String| if global.quiet { Ok(()) } else { output::print(&text) };
    if let Some(path) = &args.mesh {
        mesh::write_obj(&world.skin, path)?;
        say(format!("{}: {} triangles\n", path.display(), count(world.skin.triangles.len() as u64)))?;
    }
    if let Some(path) = &args.strands {
        let hair = render::strands(&world)?;
        hair.write(path)?;
        say(format!("{}: {} guard hairs\n", path.display(), count(hair.segments.len() as u64)))?;
    }
    Ok(())
}
