//! `pelage figure`.

use super::{args, interrupt};
use clap::Args;
use pelage_core::Result;
use pelage_studies::figure;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("which").required(true).args(["names", "all", "list"]))]
pub(super) struct FigureArgs {
    /// The figures, folders of paper_figures/ or the unique ends of their names (fig8).
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    /// Make all figures; one whose files are missing is skipped.
    #[arg(long)]
    all: bool,
    /// List the figures.
    #[arg(long)]
    list: bool,
    /// Folder for the results, FOLDER/NAME/result, and the report, FOLDER/index.html; not given: the registry, paper_figures/.
    #[arg(long = "outfile", short = 'o', value_name = "FOLDER")]
    outfile: Option<PathBuf>,
    /// Small: all figures take about a quarter of an hour on two CPU cores.
    #[arg(long)]
    quick: bool,
    /// Pixels of a panel instead of the figure's own.
    #[arg(long, value_name = "WxH", value_parser = args::size)]
    size: Option<[u32; 2]>,
    /// Compare what is made with the small figures that the repository keeps; needs --quick.
    #[arg(long, requires = "quick", conflicts_with = "size")]
    check: bool,
    /// Keep what is made in the repository for --check and for the report in Markdown; needs --quick.
    #[arg(long, requires = "quick", conflicts_with_all = ["size", "check"])]
    bless: bool,
}

pub(super) fn run(args: &FigureArgs) -> Result<()> {
    if args.list {
        return figure::list();
    }
    let options = figure::Options {
        names: args.names.clone(),
        out: args.outfile.clone(),
        quick: args.quick,
        size: args.size,
        check: args.check,
        bless: args.bless,
    };
    figure::run(&options, interrupt::listen()?)
}
