//! The command line. Results go to stdout; progress, warnings and errors to stderr.
//!
//! Exit codes: 0 done; 1 rendering, input or output failed, a comparison is past its threshold, or a goal is missed;
//! 2 wrong usage;
//! 3 the scene or an asset is not valid; 4 no adapter, or its limits are too low; 5 device lost; 130 interrupted.

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
mod output;
mod progress;
mod reference;
mod render;
mod schema;
mod validate;

use clap::{Args, Parser, Subcommand};
use pelage_core::{Error, Result};
use std::{num::NonZeroUsize, process::ExitCode};

/// Renders fur: guard hairs as strands, undercoat as a ray-marched shell, blended exactly.
#[derive(Debug, Parser)]
#[command(name = "pelage", version, max_term_width = 110, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    global: Global,
}

const EXIT_CODES: &str = "Exit codes: 0 done; 1 rendering or I/O failed, a comparison is past its threshold, or a goal is missed; \
2 wrong usage; 3 scene invalid; 4 no GPU adapter or limits too low; 5 GPU device lost; 130 interrupted.\n\
The adapter is chosen with WGPU_BACKEND, WGPU_ADAPTER_NAME and WGPU_POWER_PREF; logs with RUST_LOG.";

/// What every subcommand understands.
#[derive(Debug, Args)]
struct Global {
    /// No progress, no summary, no warnings.
    #[arg(long, short, global = true)]
    quiet: bool,
    /// How progress is shown on stderr; not given: a bar on a terminal, else nothing.
    #[arg(long, global = true, value_enum, value_name = "HOW")]
    progress: Option<progress::Style>,
    /// CPU threads; not given: one a core.
    #[arg(long, global = true, value_name = "N")]
    threads: Option<NonZeroUsize>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a scene to PNG or EXR files.
    Render(render::RenderArgs),
    /// Trace a scene's ground truth on the CPU, every hair a strand; needs no GPU.
    Reference(reference::ReferenceArgs),
    /// Print the resolved scene with counts and a memory estimate, without a GPU.
    Check(check::CheckArgs),
    /// Print the JSON schema of scene files.
    Schema,
    /// List the GPU adapters.
    Devices(devices::DevicesArgs),
    /// Write the strands and the mesh of a scene for other renderers.
    Export(export::ExportArgs),
    /// Bake textures for shells and fins: layers, fin, levels of detail, mips, manifest.
    Bake(bake::BakeArgs),
    /// Cover a mesh with lapped patches: uv for small textures of fur, a picture, statistics.
    Lapped(lapped::LappedArgs),
    /// Compare two images: light, structure, FLIP and HDR-FLIP, detail; all, at the silhouette and inside.
    Compare(compare::CompareArgs),
    /// Measure time and memory in the rows of Andersen et al. 2016, Table 1.
    Bench(bench::BenchArgs),
    /// Make a figure of the registry.
    Figure(figure::FigureArgs),
    /// Measure the approximations against the ground truth and write a report; exit with 1 where a goal is missed.
    Validate(validate::ValidateArgs),
}

/// Runs the command of this process's arguments, prints what went wrong, and returns the exit code.
pub fn run() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(e) => {
            // Help and version come this way too, with code 0. A closed pipe is no reason to complain.
            let _ = e.print();
            return ExitCode::from(u8::try_from(e.exit_code()).unwrap_or(2));
        }
    };
    start_logging(cli.global.quiet);
    match dispatch(&cli) {
        Ok(()) => ExitCode::SUCCESS,
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
        Command::Reference(args) => reference::run(args, &cli.global),
        Command::Check(args) => check::run(args, &cli.global),
        Command::Schema => schema::run(),
        Command::Devices(args) => devices::run(args),
        Command::Export(args) => export::run(args, &cli.global),
        Command::Bake(args) => bake::run(args, &cli.global),
        Command::Lapped(args) => lapped::run(args, &cli.global),
        Command::Compare(args) => compare::run(args),
        Command::Bench(args) => bench::run(args),
        Command::Figure(args) => figure::run(args),
        Command::Validate(args) => validate::run(args, &cli.global),
    }
}

fn start_logging(quiet: bool) {
    use tracing_subscriber::EnvFilter;
    let default = if quiet { "error" } else { "pelage=warn,error" };
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| EnvFilter::new(default));
    // A program that embeds the library may have set its own subscriber: that one stays.
    let _ = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .without_time()
        .try_init();
}

fn report(error: &Error) {
    match error {
        Error::Scene(faults) => {
            for fault in faults {
                eprintln!("error: {fault}");
            }
            if faults.len() > 1 {
                eprintln!("{} faults", faults.len());
            }
        }
        error => eprintln!("error: {error}"),
    }
}
