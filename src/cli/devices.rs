//! `pelage devices`.

use super::output;
use clap::Args;
use pelage_core::{Error, Result};
use pelage_gpu as gpu;

#[derive(Debug, Args)]
pub(super) struct DevicesArgs {
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Lists the adapters.
///
/// # Errors
/// [`Error::Adapter`] where there is none that suffices.
pub(super) fn run(args: &DevicesArgs) -> Result<()> {
    let adapters = gpu::list_adapters();
    if args.json {
        let rows = serde_json::to_value(&adapters)
            .map_err(|e| Error::Encoding(format!("the adapters cannot be written as JSON: {e}")))?;
        output::print_json(&rows)?;
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
        return Err(Error::Adapter(format!("no GPU adapter answers; {}", gpu::adapter::HELP)));
    }
    if adapters.iter().all(|a| a.lacks.is_some()) {
        return Err(Error::Adapter(format!("no adapter is sufficient; {}", gpu::adapter::HELP)));
    }
    Ok(())
}
