//! `pelage reference`: the ground truth of a scene, path traced on the CPU.

use super::args::SceneArgs;
use super::choice::choice;
use super::output::{self, count};
use super::progress::Display;
use super::{Global, interrupt};
use clap::{Args, ValueEnum};
use glam::Vec3;
use pelage::film::composite::Backdrop;
use pelage::film::{Film, io};
use pelage::reference::{self, GrowOptions, Identity, Integrator, LightModel, Options, Outcome, Patch};
use pelage::render::Progress;
use pelage::{Error, Result, Scene, World};
use pelage_core::film::exposure;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  pelage reference scenes/cylinder.toml -o truth.exr --time 120
  pelage reference scenes/cylinder.toml -o truth.exr --time 600 --resume    to go on
  pelage reference scenes/cylinder.toml -o single.exr --integrator single")]
pub(super) struct ReferenceArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Output file, .png or .exr; may be repeated. EXR files hold all planes, both halves and the
    /// variance, and can be resumed
    #[arg(long = "outfile", short = 'o', value_name = "FILE", required = true)]
    outfile: Vec<PathBuf>,
    /// How light is followed
    #[arg(long, value_parser = choice::<Integrator>(), default_value = "path")]
    integrator: Integrator,
    /// Lights: the renderer's directional lights (scene), or the environment itself (map) [default:
    /// scene for single, map for path]
    #[arg(long, value_parser = choice::<LightModel>())]
    lights: Option<LightModel>,
    /// Choose the exposure of PNG output: the log-average luminance of the fur and the skin becomes
    /// middle grey, 0.18, lowered where more than 1 % of them would exceed the highlights (1
    /// without tone mapping, else 4)
    #[arg(long, conflicts_with = "exposure")]
    auto_exposure: bool,
    /// Stop after this time in seconds
    #[arg(long, value_name = "S", value_parser = above_zero)]
    time: Option<f64>,
    /// Stop when the relative mean squared error, estimated from two halves of the samples, is at
    /// most this
    #[arg(long, value_name = "X", value_parser = above_zero)]
    error: Option<f64>,
    /// Resume from the first EXR output file, if it exists
    #[arg(long)]
    resume: bool,
    /// Trace only hairs with roots within R of the point X,Y,Z, all in cm; skin and objects stay
    #[arg(long, value_name = "X,Y,Z,R", value_parser = patch, allow_hyphen_values = true)]
    patch: Option<Patch>,
    /// Layers to trace
    #[arg(long, value_enum, value_delimiter = ',', value_name = "LIST", default_value = "guard,undercoat")]
    layers: Vec<LayerName>,
    /// Segments of an undercoat hair
    #[arg(long, value_name = "N", default_value_t = 8)]
    segments: u32,
    /// Largest number of scattering events of a path
    #[arg(long, value_name = "N", default_value_t = 256)]
    depth: u32,
    /// Seed of the sampling; --seed is that of the fur
    #[arg(long, value_name = "N", default_value_t = 0)]
    sampling_seed: u32,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum LayerName {
    Guard,
    Undercoat,
}

fn above_zero(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x.is_finite() && x > 0.0 => Ok(x),
        _ => Err(format!("expected a number above 0, found {text:?}")),
    }
}

fn patch(text: &str) -> Result<Patch, String> {
    let expected = || format!("expected x,y,z,r in cm with r > 0, found {text:?}");
    let numbers: Vec<f32> =
        text.split(',').map(|n| n.trim().parse()).collect::<Result<_, _>>().map_err(|_| expected())?;
    let [x, y, z, radius] = numbers[..] else { return Err(expected()) };
    let fits = numbers.iter().all(|n| n.is_finite()) && radius > 0.0;
    fits.then_some(Patch { centre: Vec3::new(x, y, z), radius }).ok_or_else(expected)
}

/// Samples per pixel if no limit is given.
const SAMPLES: u32 = 64;

/// Default memory budget, bytes.
const MEMORY: u64 = 8 << 30;

/// Time between two intermediate images.
const WRITE_EVERY: Duration = Duration::from_secs(60);

/// Traces and writes the image; after an interrupt, the partial image.
pub(super) fn run(args: &ReferenceArgs, global: &Global) -> Result<()> {
    args.outfile.iter().try_for_each(io::check_writable)?;
    let (scene, assets) = args.scene.load()?;
    let mut world = World::load(scene, &assets)?;
    // Seen by the camera that the world has chosen, if it had to.
    let backdrop = Backdrop::load(&world.scene, &assets)?;
    output::admit(&mut world, args.patch.is_none(), global.quiet)?;
    let limited = args.time.is_some() || args.error.is_some();
    let mut options = Options {
        integrator: args.integrator,
        lights: args.lights,
        grow: GrowOptions { patch: args.patch, undercoat_segments: args.segments },
        layers: [LayerName::Guard, LayerName::Undercoat].map(|l| args.layers.contains(&l)),
        depth: args.depth,
        seed: args.sampling_seed,
        samples: args.scene.spp.or((!limited).then_some(SAMPLES)),
        time: args.time,
        error: args.error,
        memory: args.scene.memory.unwrap_or(MEMORY),
        assets,
        cancel: Some(interrupt::flag()),
        ..Options::default()
    };
    let identity = Identity::new(&world, &options);
    if args.resume {
        let Some(path) = args.outfile.iter().find(|p| is_exr(p)) else {
            return Err(Error::Usage("--resume: expected an output file with the extension .exr".into()));
        };
        if path.exists() {
            options.start = Some(identity.read(path, [world.scene.film.width, world.scene.film.height])?);
        }
    }
    let save = |film: Film, samples: u32, exposure: Option<f32>| -> Result<()> {
        let mut film = film;
        backdrop.under(&mut film)?;
        let mut metadata = identity.metadata(samples);
        let mut spec = world.scene.film.clone();
        if let Some(stops) = exposure {
            spec.exposure = stops;
            metadata = metadata.with("auto_exposure", output::stops(stops));
        }
        args.outfile.iter().try_for_each(|path| io::write(&film, path, &metadata, &spec))
    };
    let display = Display::new(global.progress, global.quiet);
    let mut written = Instant::now();
    let outcome = reference::render(&world, &options, &mut |progress| {
        interrupt::partial(true);
        display.update(Progress { done: progress.done as f32, stage: "path tracing" });
        if written.elapsed() >= WRITE_EVERY {
            save(progress.means.film(), progress.means.samples, None)?;
            written = Instant::now();
        }
        Ok(())
    });
    display.finish();
    let outcome = outcome?;
    let exposure = args.auto_exposure.then(|| exposure::automatic(&outcome.film, &world.scene.film));
    let exposure = exposure.transpose()?;
    save(outcome.film.clone(), outcome.samples, exposure)?;
    if outcome.complete {
        output::print_notes_of_film(&outcome.film, &world, global.quiet)?;
    }
    if args.json {
        output::print_json(&serde_json::json!({
            "samples": outcome.samples,
            "error": outcome.error,
            "seconds": outcome.seconds,
            "rays": outcome.rays,
            "complete": outcome.complete,
        }))?;
    } else if !global.quiet {
        output::print(&summary(args, &world.scene, &outcome, exposure))?;
    }
    if outcome.complete { Ok(()) } else { Err(Error::Interrupted) }
}

fn is_exr(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"))
}

fn summary(args: &ReferenceArgs, scene: &Scene, outcome: &Outcome, exposure: Option<f32>) -> String {
    let files: Vec<_> = args.outfile.iter().map(|p| p.display().to_string()).collect();
    let exposure = exposure.map_or(String::new(), |stops| format!("exposure   {}\n", output::stops(stops)));
    format!(
        "{}: {} x {}, {} spp, {:.1} s\n{exposure}error      {:.3e} (relative mean squared, estimated from two halves)\nrays       {}, {:.2} million/s\n",
        files.join(", "),
        scene.film.width,
        scene.film.height,
        outcome.samples,
        outcome.seconds,
        outcome.error,
        count(outcome.rays),
        outcome.rays as f64 / outcome.seconds.max(1e-9) * 1e-6
    )
}
