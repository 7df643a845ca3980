//! `pelage presets`: the groom presets and their values.

use super::output;
use clap::Args;
use pelage::{Error, Result};
use pelage_core::scene::preset;
use serde_json::{Value, json};

#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  pelage presets                            all presets, one line each
  pelage presets red_fox                    the values of one, as TOML
  pelage render scenes/species.toml -D preset=red_fox -o fox.png")]
pub(super) struct PresetsArgs {
    /// Print this preset's TOML; without a name, list all presets
    #[arg(value_name = "NAME")]
    name: Option<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Lists the presets or prints one.
///
/// # Errors
/// [`Error::Usage`] if no preset has the name.
pub(super) fn run(args: &PresetsArgs) -> Result<()> {
    let Some(name) = &args.name else {
        let all = preset::names().map(|name| (name, preset::about(name).unwrap_or_default()));
        if args.json {
            let list: Vec<_> = all.map(|(name, about)| json!({ "name": name, "about": about })).collect();
            return output::print_json(&Value::Array(list));
        }
        let lines: String = all.map(|(name, about)| format!("{name:<12} {about}\n")).collect();
        return output::print(&lines);
    };
    let Some((text, about)) = preset::text(name).zip(preset::about(name)) else {
        let names: Vec<_> = preset::names().collect();
        return Err(Error::Usage(format!("no preset is called \"{name}\"; there are {}", names.join(", "))));
    };
    if args.json {
        let values: Value = toml::from_str(text)
            .map_err(|e| Error::Encoding(format!("preset {name} cannot be written as JSON: {e}")))?;
        return output::print_json(&json!({ "name": name, "about": about, "values": values }));
    }
    output::print(text)
}
