//! `pelage render`.

use super::args::{self, SceneArgs};
use super::frames::{self, Frames};
use super::output::{self, count, human_bytes};
use super::progress::Display;
use super::{Global, interrupt};
use clap::Args;
use pelage::assets::Assets;
use pelage::film::{Metadata, composite, depth_of_field, io};
use pelage::render::{self, RenderOptions, Stats, animation};
use pelage::{Error, Result, Scene, World};
use pelage_core::files;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

#[derive(Debug, Args)]
pub(super) struct RenderArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Output file, .png or .exr; may be repeated. EXR files hold all planes
    #[arg(long = "outfile", short = 'o', value_name = "FILE", required = true)]
    outfile: Vec<PathBuf>,
    /// Render only a part of the film, in 0..1 of its width and height
    #[arg(long, value_name = "X0,X1,Y0,Y1", value_parser = args::crop)]
    cropwindow: Option<[f32; 4]>,
    /// Render frames of the scene's [animation]: the first N, A..B (both included) or A.. (to the
    /// end). Output files are numbered: -o fur.png gives fur_0001.png and so on, and likewise for
    /// --stats. Frames are independent of each other
    #[arg(long, value_name = "N|A..B", value_parser = frames::frames)]
    frames: Option<Frames>,
    /// Write the statistics to a JSON file
    #[arg(long, value_name = "FILE.json")]
    stats: Option<PathBuf>,
    /// Print the statistics as JSON instead of text
    #[arg(long)]
    json: bool,
}

fn is_exr(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"))
}

/// Renders and writes the images; after an interrupt or the loss of the device, the partial image.
pub(super) fn run(args: &RenderArgs, global: &Global) -> Result<()> {
    let png = |path: &PathBuf| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png"));
    if let Some(path) = args.outfile.iter().find(|path| !is_exr(path) && !png(path)) {
        let found = path.display();
        return Err(Error::Usage(format!("-o {found}: expected the extension .png or .exr")));
    }
    let (scene, assets) = args.scene.load()?;
    let numbers = args.frames.map(|f| f.numbers(&scene.animation)).transpose()?;
    let named = |path: &Path, number: Option<u32>| {
        number.map_or_else(|| path.to_owned(), |number| frames::numbered(path, number))
    };
    let first = numbers.as_ref().map(|n| *n.start());
    args.outfile.iter().chain(&args.stats).try_for_each(|path| files::check_target(&named(path, first)))?;
    let cancel = interrupt::listen()?;
    let mut world = World::load(scene, &assets)?;
    output::print_notes(world.mesh_notes(), global.quiet);
    if cancel.load(Ordering::SeqCst) {
        return Err(Error::Interrupted);
    }
    let Some(numbers) = numbers else {
        return picture(args, global, &world, 0.0, &assets, &args.outfile, args.stats.as_deref(), cancel);
    };
    let scene = world.scene.clone();
    let last = *numbers.end();
    for number in numbers {
        let state = animation::at(&scene, number);
        world.scene.camera = state.camera;
        let outfile: Vec<_> = args.outfile.iter().map(|path| named(path, Some(number))).collect();
        let stats = args.stats.as_ref().map(|path| named(path, Some(number)));
        picture(args, global, &world, state.time, &assets, &outfile, stats.as_deref(), cancel).inspect_err(
            |_| eprintln!("frame {number} is not finished; resume with --frames {number}..{last}"),
        )?;
    }
    Ok(())
}

/// Renders the picture `time` s after the first frame and writes it to every file of `outfile`.
#[allow(clippy::too_many_arguments)] // Each is an independent input.
fn picture(
    args: &RenderArgs,
    global: &Global,
    world: &World,
    time: f64,
    assets: &Assets,
    outfile: &[PathBuf],
    stats: Option<&Path>,
    cancel: &AtomicBool,
) -> Result<()> {
    let display = Display::new(global.progress, global.quiet);
    let show = |progress| display.update(progress);
    let options = RenderOptions {
        time,
        crop: args.cropwindow,
        aovs: outfile.iter().any(|path| is_exr(path)) || world.scene.camera.lens.is_some(),
        progress: Some(&show),
        cancel: Some(cancel),
    };
    let frame = render::render(world, &options);
    display.finish();
    let mut frame = frame?;

    depth_of_field::apply(&mut frame.film, &world.scene.camera)?;
    composite::over_background(&mut frame.film, &world.scene, assets)?;
    let metadata = metadata(&world.scene, &frame.stats);
    for path in outfile {
        io::write(&frame.film, path, &metadata, &world.scene.film)?;
    }
    let json = output::to_json(&frame.stats, "statistics")?;
    if let Some(path) = stats {
        output::write_json(path, &json)?;
    }
    if args.json {
        output::print_json(&json)?;
    } else if !global.quiet {
        output::print(&summary(outfile, &frame.stats))?;
    }
    match frame.fault {
        Some(fault) => Err(fault),
        None if frame.complete => Ok(()),
        None => Err(Error::Interrupted),
    }
}

/// The metadata of an image. The resolved scene in it renders the same image without included files
/// and flags.
fn metadata(scene: &Scene, stats: &Stats) -> Metadata {
    Metadata::of_program()
        .with_scene(&toml::to_string(scene).unwrap_or_default())
        .with_seed(scene.render.seed)
        .with_command_line(output::command_line())
        .with_stats(stats)
}

/// The statistics as text: the files, counts, and the rows of Andersen et al. 2016, Table 1.
fn summary(outfile: &[PathBuf], s: &Stats) -> String {
    let files: Vec<_> = outfile.iter().map(|p| p.display().to_string()).collect();
    let mut text = format!(
        "{}: {} x {}, {} spp, {} ({}), {:.2} s\n",
        files.join(", "),
        s.width,
        s.height,
        s.spp,
        s.fur,
        s.blend,
        s.total_ms / 1000.0
    );
    text += &format!("adapter    {} ({})\n", s.adapter, s.driver);
    text += &format!(
        "geometry   {} triangles, {} strands, {} subelements ({})\n",
        count(s.triangles),
        count(s.strands),
        count(s.subelements),
        s.storage
    );
    text += &format!(
        "fragments  {}, at most {} per sample, {} dropped; {} rays lost; {} tiles, {} retried\n",
        count(s.fragments),
        count(s.fragments_max),
        count(s.fragments_dropped),
        count(s.rays_lost),
        count(s.tiles),
        count(s.tiles_retried)
    );
    text += &format!(
        "memory     {} at most, budget {}\n",
        human_bytes(s.gpu_peak_bytes),
        human_bytes(s.memory_budget_bytes)
    );
    for step in &s.steps {
        let ms = step.ms.map_or("n/a".into(), |ms| format!("{ms:.1} ms"));
        text += &format!("{:>4}  {:<36} {ms:>12} {:>12}\n", step.step, step.name, human_bytes(step.bytes));
    }
    text
}
