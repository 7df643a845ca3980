//! `pelage bench`.

use super::args;
use super::choice::choice;
use clap::Args;
use pelage_core::{Error, Result, files};
use pelage_studies::bench;
use pelage_studies::bench::shells;
use pelage_studies::bench::sweep::Sweep;
use std::{num::NonZeroU32, path::PathBuf};

#[derive(Debug, Args)]
pub(super) struct BenchArgs {
    /// Scene files; not given: cylinder, hat and bunny (for --sweep the cylinder; for --shells a furry bunny and other meshes).
    #[arg(value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Image sizes; not given: 1024x1024 and 3840x2274 (for --shells 640x480).
    #[arg(long, value_name = "WxH", value_parser = args::size)]
    size: Vec<[u32; 2]>,
    /// Renderings of each; the table shows the fastest and the median. Not given: 1 (for --shells 20).
    #[arg(long, value_name = "N")]
    runs: Option<NonZeroU32>,
    /// GPU memory budget, e.g. 1GiB.
    #[arg(long, value_name = "SIZE", value_parser = args::bytes)]
    memory: Option<u64>,
    /// Compare ways to render instead of making the table; may be given several times.
    #[arg(long, value_parser = choice::<Sweep>(), value_name = "WHAT")]
    sweep: Vec<Sweep>,
    /// Frames a second of shells and fins instead of the table, and how their cost grows with layers and triangles.
    #[arg(long, conflicts_with = "sweep")]
    shells: bool,
    /// Numbers of layers that --shells compares; not given: 4,8,16,32,64.
    #[arg(long, value_name = "N,...", value_delimiter = ',', requires = "shells", value_parser = clap::value_parser!(u32).range(1..=128))]
    layers: Vec<u32>,
    /// Write the results as JSON too.
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
}

/// Frames of each fur where no number is given.
const FRAMES: u32 = 20;

pub(super) fn run(args: &BenchArgs) -> Result<()> {
    if let Some(path) = &args.json {
        files::check_target(path)?;
    }
    if args.shells {
        if args.size.len() > 1 {
            let found = args.size.len();
            return Err(Error::Usage(format!(
                "--shells: expected one --size, found {found}: run it once for each"
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
