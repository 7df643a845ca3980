//! `pelage render`.

use super::args::{self, SceneArgs};
use super::frames::{self, Frames};
use super::output::{self, count, human_bytes};
use super::preview::{Preview, title};
use super::progress::Display;
use super::{Global, interrupt};
use clap::Args;
use pelage::assets::Assets;
use pelage::film::composite::Backdrop;
use pelage::film::tev::{self, Tev};
use pelage::film::{Film, Metadata, depth_of_field, io};
use pelage::render::{self, RenderOptions, Stats, animation, mattes};
use pelage::scene::FurLayers;
use pelage::{Error, Result, Scene, World};
use pelage_core::files;
use pelage_core::film::exposure;
use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::time::Duration;

#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  pelage render scenes/default.toml -o fur.png
  pelage render scenes/default.toml --size 320x200 --spp 1 -o quick.png
  pelage render scenes/species.toml -D preset=wolf -o wolf.png -o wolf.exr
  pelage render scenes/default.toml -D animation.turntable=360 --frames 48 -o turn.png")]
pub(super) struct RenderArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Output file, .png or .exr; may be repeated. EXR files hold all planes
    #[arg(long = "outfile", short = 'o', value_name = "FILE", required = true)]
    outfile: Vec<PathBuf>,
    /// Render only a part of the film, in 0..1 of its width and height. Files have the whole film's
    /// size; outside the part they are transparent, whatever the background
    #[arg(long, value_name = "X0,X1,Y0,Y1", value_parser = args::crop)]
    cropwindow: Option<[f32; 4]>,
    /// Render frames of the scene's [animation]: the first N, A..B (both included) or A.. (to the
    /// end). Output files are numbered: -o fur.png gives fur_0001.png and so on, and likewise for
    /// --stats. Frames are independent of each other
    #[arg(long, value_name = "N|A..B", value_parser = frames::frames)]
    frames: Option<Frames>,
    /// Refresh the output files while rendering, at most every so many seconds [3]; they then hold
    /// the finished tiles, without depth of field as a post-process
    #[arg(long, value_name = "SECONDS", num_args = 0..=1, require_equals = true,
          default_missing_value = "3", value_parser = clap::value_parser!(u16).range(1..))]
    preview: Option<u16>,
    /// Show the picture in the viewer tev while rendering and when it is finished
    #[arg(long, value_name = "HOST:PORT", num_args = 0..=1, require_equals = true,
          default_missing_value = tev::ADDRESS)]
    tev: Option<String>,
    /// Choose the exposure of PNG output: the log-average luminance of the fur and the skin becomes
    /// middle grey, 0.18, lowered where more than 1 % of them would exceed the highlights (1
    /// without tone mapping, else 4)
    #[arg(long, conflicts_with = "exposure")]
    auto_exposure: bool,
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
    let mut world = World::load(scene, &assets)?;
    output::admit(&mut world, true, global.quiet)?;
    let exposure = Cell::new(None);
    let Some(numbers) = numbers else {
        return picture(args, global, &world, 0.0, &assets, &args.outfile, args.stats.as_deref(), &exposure);
    };
    let scene = world.scene.clone();
    let last = *numbers.end();
    if !global.quiet && first != Some(last) && !animation::moves(&scene) {
        eprintln!(
            "note: nothing moves, so all frames are the same picture: set animation.turntable (degrees over \
             animation.frames frames) or animation.motion.amplitude"
        );
    }
    for number in numbers {
        let state = animation::at(&scene, number);
        world.scene.camera = state.camera;
        let outfile: Vec<_> = args.outfile.iter().map(|path| named(path, Some(number))).collect();
        let stats = args.stats.as_ref().map(|path| named(path, Some(number)));
        picture(args, global, &world, state.time, &assets, &outfile, stats.as_deref(), &exposure)
            .inspect_err(|_| {
                eprintln!("frame {number} is not finished; resume with --frames {number}..{last}")
            })?;
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
    exposure: &Cell<Option<f32>>,
) -> Result<()> {
    // Before rendering, so that a missing plate or viewer is reported early.
    let backdrop = Backdrop::load(&world.scene, assets)?;
    let exr = outfile.iter().any(|path| is_exr(path));
    let tev = match &args.tev {
        Some(address) => Some(Tev::connect(address, &outfile.first().map_or("pelage".into(), |p| title(p)))?),
        None => None,
    };
    if exr && world.scene.render.fur == FurLayers::Shells && !global.quiet {
        eprintln!(
            "note: shells and fins have no Albedo, N, Tangent, coverage of layers or CryptoLayer in EXR files: \
             blended, they cannot be separated"
        );
    }
    let files = if args.preview.is_some() { outfile.to_vec() } else { Vec::new() };
    let previewed = !files.is_empty() || tev.is_some();
    let interval = Duration::from_secs(args.preview.unwrap_or(1).into());
    let preview = Preview::new(&world.scene, backdrop.clone(), interval, files, tev);
    let partial = |film: &Film| preview.offer(film);
    let display = Display::new(global.progress, global.quiet);
    let show = |progress: render::Progress| {
        // Shells and fins count their preparation as a fifth of the work.
        interrupt::partial(match progress.stage {
            "shellfin_raster" => progress.done > 0.2,
            "resolve" | "film" => progress.done > 0.0,
            _ => false,
        });
        display.update(progress);
    };
    let options = RenderOptions {
        time,
        crop: args.cropwindow,
        aovs: world.scene.camera.lens.is_some(),
        features: exr,
        partial: previewed.then_some(&partial),
        progress: Some(&show),
        cancel: Some(interrupt::flag()),
    };
    let frame = render::render(world, &options);
    display.finish();
    let mut frame = frame?;
    if !global.quiet {
        output::warn_of_cuts(&frame.stats);
    }
    if args.auto_exposure && exposure.get().is_none() {
        // The frames of an animation share the first one's, so that they do not flicker.
        exposure.set(Some(exposure::automatic(&frame.film, &world.scene.film)?));
    }
    let mut scene = world.scene.clone();
    scene.film.exposure = exposure.get().unwrap_or(scene.film.exposure);
    if frame.complete {
        output::print_notes_of_film(&frame.film, world, global.quiet)?;
    }

    depth_of_field::apply(&mut frame.film, &world.scene.camera)?;
    let mut metadata = metadata(&scene, &frame.stats);
    if let Some(stops) = exposure.get() {
        metadata = metadata.with("auto_exposure", output::stops(stops));
    }
    if exr {
        metadata = mattes::add(&mut frame.film, metadata, &world.scene)?;
    }
    backdrop.under(&mut frame.film)?;
    if let Some(crop) = args.cropwindow {
        pelage::film::composite::clear_outside(&mut frame.film, crop);
    }
    if !global.quiet {
        output::warn_of_cut_pixels(&frame.film);
    }
    for path in outfile {
        io::write(&frame.film, path, &metadata, &scene.film)?;
    }
    preview.finish(&frame.film);
    interrupt::partial(false);
    let json = output::to_json(&frame.stats, "statistics")?;
    if let Some(path) = stats {
        output::write_json(path, &json)?;
    }
    if args.json {
        output::print_json(&json)?;
    } else if !global.quiet {
        output::print(&summary(outfile, &frame.stats, exposure.get()))?;
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
fn summary(outfile: &[PathBuf], s: &Stats, exposure: Option<f32>) -> String {
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
    if let Some(stops) = exposure {
        text += &format!("exposure   {}\n", output::stops(stops));
    }
    text += &format!("adapter    {} ({})\n", s.adapter, s.driver);
    text += &format!(
        "geometry   {} triangles, {} strands, {} subelements ({})\n",
        count(s.triangles),
        count(s.strands),
        count(s.subelements),
        s.storage
    );
    text += &format!(
        "fragments  {}, at most {} per sample, {} dropped, {} unread; {} rays lost, {} cut; {} tiles, {} retried\n",
        count(s.fragments),
        count(s.fragments_max),
        count(s.fragments_dropped),
        count(s.fragments_unread),
        count(s.rays_lost),
        count(s.rays_cut),
        count(s.tiles),
        count(s.tiles_retried)
    );
    text += &format!("light      {} paths cut\n", count(s.light_paths_cut));
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
