//! `pelage devices`.

use super::output;
use clap::Args;
use pelage::render::list_adapters;
use pelage::{Error, Result};
use pelage_gpu::adapter::HELP;

#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  pelage devices
  WGPU_ADAPTER_NAME=llvmpipe pelage render scenes/default.toml -o fur.png    chooses one by its name")]
pub(super) struct DevicesArgs {
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Lists the adapters.
///
/// # Errors
/// [`Error::Adapter`] if none is usable.
pub(super) fn run(args: &DevicesArgs) -> Result<()> {
    let adapters = list_adapters();
    if args.json {
        output::print_json(&output::to_json(&adapters, "list of adapters")?)?;
    } else {
        for a in &adapters {
            let usable = a.lacks.as_ref().map_or("usable".into(), |lacks| format!("not usable: {lacks}"));
            let timestamps = if a.timestamps { "timestamps" } else { "no timestamps" };
            output::print(&format!(
                "{}\n  {}, {}, {}\n  storage bindings up to {}, {timestamps}\n  {usable}\n",
                a.name,
                a.backend,
                a.device_type,
                a.driver,
                output::human_bytes(a.binding_bytes)
            ))?;
        }
    }
    if adapters.is_empty() {
        return Err(Error::Adapter(format!("no GPU adapter answers; {HELP}")));
    }
    if adapters.iter().all(|a| a.lacks.is_some()) {
        return Err(Error::Adapter(format!("no adapter is sufficient; {HELP}")));
    }
    Ok(())
}
