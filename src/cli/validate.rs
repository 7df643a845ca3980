//! `pelage validate`.

use super::progress::Display;
use super::{Global, interrupt, output};
use clap::Args;
use pelage::Result;
use pelage_studies::report::number;
use pelage_studies::validate::{self, Level};
use std::path::PathBuf;

#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  pelage validate --quick
  pelage validate --only furnace -o out/furnace")]
pub(super) struct ValidateArgs {
    /// Run a few minutes: fewer cases, smaller and noisier images
    #[arg(long, conflicts_with = "full")]
    quick: bool,
    /// Run all cases with larger images and more samples: hours on a few cores
    #[arg(long)]
    full: bool,
    /// Folder for report.html, report.json and pictures
    #[arg(long = "outfile", short = 'o', value_name = "FOLDER", default_value = "out/validate")]
    outfile: PathBuf,
    /// Run only this experiment: transmittance, furnace, volume or hybrid; may be repeated
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,
}

/// Measures, writes the report, and prints the table.
///
/// # Errors
/// As [`validate::Report::verdict`] and [`validate::run`].
pub(super) fn run(args: &ValidateArgs, global: &Global) -> Result<()> {
    let level = match (args.quick, args.full) {
        (true, _) => Level::Quick,
        (_, true) => Level::Full,
        _ => Level::Usual,
    };
    let options = validate::Options {
        level,
        out: args.outfile.clone(),
        only: args.only.clone(),
        ..validate::Options::default()
    };
    let display = Display::new(global.progress, global.quiet);
    let report = validate::run(&options, &|progress| display.update(progress), interrupt::flag());
    display.finish();
    let report = report?;
    if !global.quiet {
        output::print(&summary(&report))?;
        output::print(&format!("{}\n", options.out.join("report.html").display()))?;
    }
    report.verdict()
}

fn summary(report: &validate::Report) -> String {
    let mut text = String::new();
    for section in &report.sections {
        text += &format!("{} ({:.0} s)\n", section.title, section.seconds);
        for f in &section.findings {
            let verdict = match f.met {
                Some(true) => "met",
                Some(false) => "MISSED",
                None => "",
            };
            let goal = f.goal.map_or(String::new(), |goal| goal.to_string());
            let value = number(f.value);
            text += format!(
                "  {:<38} {:<42} {:<40} {value:>9}  {goal:<14} {verdict}",
                f.approximation, f.case, f.metric
            )
            .trim_end();
            text += "\n";
        }
        section.skipped.iter().for_each(|case| text += &format!("  left out: {case}\n"));
    }
    text
}
