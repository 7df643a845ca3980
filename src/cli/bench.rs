//! `pelage bench`.

use super::args;
use super::choice::choice;
use clap::Args;
use pelage::{Error, Result};
use pelage_core::files;
use pelage_studies::bench::sweep::Sweep;
use pelage_studies::bench::{self, shells};
use std::num::NonZeroU32;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  pelage bench scenes/cylinder.toml --size 960x568 --runs 3
  pelage bench --sweep blend
  pelage bench --shells --json shells.json")]
pub(super) struct BenchArgs {
    /// Scene files [default: cylinder, hat and bunny; with --sweep: cylinder; with --shells: a
    /// furry bunny and other meshes]
    #[arg(value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Image sizes [default: 1024x1024 and 3840x2274; with --sweep: 960x568; with --shells:
    /// 640x480]
    #[arg(long, value_name = "WxH", value_parser = args::size)]
    size: Vec<[u32; 2]>,
    /// Renderings of each scene, of which the table shows the fastest and the median [default: 1;
    /// with --shells: 20]
    #[arg(long, value_name = "N")]
    runs: Option<NonZeroU32>,
    /// GPU memory budget, e.g. 1GiB
    #[arg(long, value_name = "SIZE", value_parser = args::bytes)]
    memory: Option<u64>,
    /// Compare rendering methods or settings instead of measuring the table; may be repeated
    #[arg(long, value_parser = choice::<Sweep>(), value_name = "WHAT")]
    sweep: Vec<Sweep>,
    /// Measure frames per second of shells and fins instead of the table, and the growth of their
    /// cost with layers and triangles
    #[arg(long, conflicts_with = "sweep")]
    shells: bool,
    /// Numbers of layers that --shells compares [default: 4,8,16,32,64]
    #[arg(long, value_name = "N,...", value_delimiter = ',', requires = "shells", value_parser = clap::value_parser!(u32).range(1..=128))]
    layers: Vec<u32>,
    /// Also write the results to a JSON file
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
}

/// Default number of frames of each fur.
const FRAMES: u32 = 20;

pub(super) fn run(args: &BenchArgs) -> Result<()> {
    if let Some(path) = &args.json {
        files::check_target(path)?;
    }
    if args.shells {
        if args.size.len() > 1 {
            let found = args.size.len();
            return Err(Error::Usage(format!(
                "--shells: expected one --size, found {found}; run it once for each size"
            )));
        }
        return shells::run(&shells::Options {
            scenes: args.scenes.clone(),
            size: args.size.first().copied(),
            runs: args.runs.map_or(FRAMES, NonZeroU32::get),
            layers: args.layers.clone(),
            memory: args.memory,
            json: args.json.clone(),
        });
    }
    bench::run(&bench::Options {
        scenes: args.scenes.clone(),
        sizes: args.size.clone(),
        runs: args.runs.map_or(1, NonZeroU32::get),
        memory: args.memory,
        json: args.json.clone(),
        sweeps: args.sweep.clone(),
    })
}
