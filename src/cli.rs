//! The command line. Results go to stdout; progress, warnings and errors to stderr.
//!
//! Exit codes: 0 success; 1 rendering, input or output failed, a comparison exceeds a threshold, or
//! a goal is missed; 2 wrong usage; 3 the scene or an asset is not valid; 4 no adapter, or its
//! limits are too low; 5 device lost; 130 interrupted.

mod args;
mod bake;
mod bench;
mod check;
mod choice;
mod compare;
mod devices;
mod export;
mod figure;
mod frames;
mod interrupt;
mod lapped;
mod new;
mod output;
mod presets;
mod preview;
mod progress;
mod reference;
mod render;
mod schema;
mod validate;

use clap::{Args, Parser, Subcommand};
use pelage::{Error, Result};
use std::num::NonZeroUsize;
use std::process::ExitCode;

/// Renders fur: guard hairs as strands, undercoat as a volume, blended exactly.
#[derive(Debug, Parser)]
#[command(name = "pelage", version, max_term_width = 110, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    global: Global,
}

const EXIT_CODES: &str = "Exit codes: 0 success; 1 rendering or I/O failed, a comparison exceeds a threshold, or a goal is missed; \
2 wrong usage; 3 scene invalid; 4 no GPU adapter or limits too low; 5 GPU device lost; 130 interrupted.\n\
WGPU_BACKEND, WGPU_ADAPTER_NAME and WGPU_POWER_PREF choose the adapter; RUST_LOG sets the log level.";

/// Options of all subcommands.
#[derive(Debug, Args)]
struct Global {
    /// No progress, no summary, no warnings
    #[arg(long, short, global = true)]
    quiet: bool,
    /// Progress on stderr [default: bar on a terminal, none otherwise]
    #[arg(long, global = true, value_enum, value_name = "HOW")]
    progress: Option<progress::Style>,
    /// Number of CPU threads [default: one per core]
    #[arg(long, global = true, value_name = "N")]
    threads: Option<NonZeroUsize>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a scene to PNG or EXR files
    Render(render::RenderArgs),
    /// Write a commented scene file for a mesh, with the camera and lights that suit it
    New(new::NewArgs),
    /// Path trace a scene on the CPU with every hair as a strand: the ground truth; needs no GPU
    Reference(reference::ReferenceArgs),
    /// Check a scene and print its size, hairs, memory and warnings; needs no GPU
    Check(check::CheckArgs),
    /// List the presets of fur, or print one
    Presets(presets::PresetsArgs),
    /// Print the JSON schema of scene files, or all their keys as Markdown
    Schema(schema::SchemaArgs),
    /// List the GPU adapters
    Devices(devices::DevicesArgs),
    /// Write a scene's strands, mesh or whole fur for other renderers
    Export(export::ExportArgs),
    /// Bake textures for shells and fins, with levels of detail, mip levels and a manifest
    Bake(bake::BakeArgs),
    /// Cover a mesh with lapped patches: uv for small fur textures, pictures, statistics
    Lapped(lapped::LappedArgs),
    /// Compare two images: light, structure, FLIP, HDR-FLIP and detail; overall, at the silhouette
    /// and inside
    Compare(compare::CompareArgs),
    /// Measure time and memory in the rows of Andersen et al. 2016, Table 1
    Bench(bench::BenchArgs),
    /// Produce figures and tables of the papers from paper_figures/
    Figure(figure::FigureArgs),
    /// Measure the approximations against the ground truth and write a report; exits with 1 if a
    /// goal is missed
    Validate(validate::ValidateArgs),
}

/// Runs the command line of this process, prints errors, and returns the exit code.
pub fn run() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(e) => {
            // Help and version also arrive here, with code 0. A closed pipe is not reported.
            let _ = e.print();
            return ExitCode::from(u8::try_from(e.exit_code()).unwrap_or(2));
        }
    };
    start_logging(cli.global.quiet);
    match interrupt::listen().and_then(|()| dispatch(&cli)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Error::Interrupted) => {
            report(&Error::Interrupted);
            interrupt::quit()
        }
        Err(e) => {
            report(&e);
            ExitCode::from(e.exit_code())
        }
    }
}

fn dispatch(cli: &Cli) -> Result<()> {
    if let Some(threads) = cli.global.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads.get())
            .build_global()
            .map_err(|e| Error::Usage(format!("--threads {threads}: {e}")))?;
    }
    match &cli.command {
        Command::Render(args) => render::run(args, &cli.global),
        Command::New(args) => new::run(args, &cli.global),
        Command::Reference(args) => reference::run(args, &cli.global),
        Command::Check(args) => check::run(args, &cli.global),
        Command::Presets(args) => presets::run(args),
        Command::Schema(args) => schema::run(args),
        Command::Devices(args) => devices::run(args),
        Command::Export(args) => export::run(args, &cli.global),
        Command::Bake(args) => bake::run(args, &cli.global),
        Command::Lapped(args) => lapped::run(args, &cli.global),
        Command::Compare(args) => compare::run(args, &cli.global),
        Command::Bench(args) => bench::run(args),
        Command::Figure(args) => figure::run(args),
        Command::Validate(args) => validate::run(args, &cli.global),
    }
}

fn start_logging(quiet: bool) {
    use tracing_subscriber::EnvFilter;
    // OpenGL is only one of the backends that are tried: that it has no driver is no error.
    let default = if quiet { "error,wgpu_hal::gles=off" } else { "pelage=warn,error,wgpu_hal::gles=off" };
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(default));
    // A subscriber that is already set stays.
    let _ = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .without_time()
        .try_init();
}

fn report(error: &Error) {
    match error {
        Error::Scene(faults) => {
            for fault in pelage_core::error::shown_faults(faults) {
                eprintln!("error: {fault}");
            }
            if faults.len() > 1 {
                eprintln!("{} errors", faults.len());
            }
        }
        error => eprintln!("error: {error}"),
    }
}
