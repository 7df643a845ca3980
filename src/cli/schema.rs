//! `pelage schema`.

use super::output;
use clap::Args;
use pelage::{Result, scene};

#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  pelage schema > pelage.schema.json            for editors
  pelage schema --markdown > docs/scene.md      to read")]
pub(super) struct SchemaArgs {
    /// Print all keys as Markdown tables: type, unit, default, range, what each does
    #[arg(long)]
    markdown: bool,
}

/// Prints the JSON schema of scene files, or the reference made from it.
pub(super) fn run(args: &SchemaArgs) -> Result<()> {
    if args.markdown {
        return output::print(&pelage_core::scene::markdown());
    }
    output::print_json(scene::json_schema())
}
