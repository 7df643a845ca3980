//! `pelage bench`.

use super::{args, backend::bench};
use crate::{Result, files};
use clap::Args;
use std::{num::NonZeroU32, path::PathBuf};

#[derive(Debug, Args)]
pub(super) struct BenchArgs {
    /// Scene files; not given: cylinder, hat and bunny.
    #[arg(value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// Image sizes; not given: 1024x1024 and 3840x2274.
    #[arg(long, value_name = "WxH", value_parser = args::size)]
    size: Vec<[u32; 2]>,
    /// Renderings of each, the fastest counts.
    #[arg(long, value_name = "N", default_value = "1")]
    runs: NonZeroU32,
    /// GPU memory budget, e.g. 1GiB.
    #[arg(long, value_name = "SIZE", value_parser = args::bytes)]
    memory: Option<u64>,
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
    })
}
