//! `pelage figure`.

use super::{args, interrupt};
use clap::Args;
use pelage::Result;
use pelage_studies::figure;
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("which").required(true).args(["names", "all", "list"]))]
#[command(after_long_help = "Examples:
  pelage figure --list
  pelage figure fig8 --quick
  pelage figure --all --quick --check")]
pub(super) struct FigureArgs {
    /// Figures: folders of paper_figures/, or unique endings of their names (fig8)
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    /// Produce all figures; skip those whose files are missing
    #[arg(long)]
    all: bool,
    /// List the figures
    #[arg(long)]
    list: bool,
    /// Folder for the results (FOLDER/NAME/result) and the report (FOLDER/index.html) [default:
    /// paper_figures/]
    #[arg(long = "outfile", short = 'o', value_name = "FOLDER")]
    outfile: Option<PathBuf>,
    /// Produce small versions; all figures take about a quarter of an hour on two CPU cores
    #[arg(long)]
    quick: bool,
    /// Size of a panel in pixels, in place of the figure's own
    #[arg(long, value_name = "WxH", value_parser = args::size)]
    size: Option<[u32; 2]>,
    /// Compare the results with the kept small versions; needs --quick
    #[arg(long, requires = "quick", conflicts_with = "size")]
    check: bool,
    /// Keep the results for --check, and rewrite the report in Markdown; needs --quick
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
    figure::run(&options, interrupt::flag())
}
