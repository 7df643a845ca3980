//! `pelage figure`.

use crate::{Result, figure};
use clap::Args;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("which").required(true).args(["name", "list"]))]
pub(super) struct FigureArgs {
    /// The figure, a folder of paper_figures/.
    #[arg(value_name = "NAME")]
    name: Option<String>,
    /// List the figures.
    #[arg(long)]
    list: bool,
    /// Folder for the images; not given: out/figures/NAME.
    #[arg(long = "outfile", short = 'o', value_name = "FOLDER")]
    outfile: Option<PathBuf>,
    /// Small, one sample a pixel.
    #[arg(long)]
    quick: bool,
}

pub(super) fn run(args: &FigureArgs) -> Result<()> {
    figure::run(&figure::Options { name: args.name.clone(), out: args.outfile.clone(), quick: args.quick })
}
