//! `pelage bench`.

use super::args;
use crate::{
    Result,
    bench::{self, sweep::Sweep},
    files,
};
use clap::Args;
use std::{num::NonZeroU32, path::PathBuf};

#[derive(Debug, Args)]
pub(super) struct BenchArgs {
    /// Scene files; not given: cylinder, hat and bunny (for --sweep the cylinder).
    #[arg(value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Image sizes; not given: 1024x1024 and 3840x2274.
    #[arg(long, value_name = "WxH", value_parser = args::size)]
    size: Vec<[u32; 2]>,
    /// Renderings of each; the table shows the fastest and the median.
    #[arg(long, value_name = "N", default_value = "1")]
    runs: NonZeroU32,
    /// GPU memory budget, e.g. 1GiB.
    #[arg(long, value_name = "SIZE", value_parser = args::bytes)]
    memory: Option<u64>,
    /// Compare ways to render instead of making the table; may be given several times.
    #[arg(long, value_enum, value_name = "WHAT")]
    sweep: Vec<Sweep>,
    /// Write the results as JSON too.
    #[arg(long, value_name = "FILE.json")]
    json: Option<PathBuf>,
}

pub(super) fn run(args: &BenchArgs) -> Result<()> {
    if let Some(path) = &args.json {
        files::check_target(path)?;
    }
    bench::run(&bench::Options {
        scenes: args.scenes.clone(),
        sizes: args.size.clone(),
        runs: args.runs.get(),
        memory: args.memory,
        json: args.json.clone(),
        sweeps: args.sweep.clone(),
    })
}
