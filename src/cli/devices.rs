//! `pelage devices`.

use super::output;
use crate::gpu;
use crate::{Error, Result};
use clap::Args;

#[derive(Debug, Args)]
pub(super) struct DevicesArgs {
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Lists the adapters.
///
/// # Errors
/// [`Error::Adapter`] where there is none.
pub(super) fn run(args: &DevicesArgs) -> Result<()> {
    let adapters = gpu::list_adapters();
    if args.json {
        let rows = serde_json::to_value(&adapters)
            .map_err(|e| Error::Check(format!("the adapters cannot be written as JSON: {e}")))?;
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
    if adapters.is_empty() { Err(Error::Adapter(NO_ADAPTER.into())) } else { Ok(()) }
}

const NO_ADAPTER: &str = "no GPU adapter answers\n  \
help: install a driver for Vulkan, Metal or DirectX 12; a software adapter will do \
(Debian, Ubuntu: apt-get install mesa-vulkan-drivers; Fedora: dnf install mesa-vulkan-drivers; \
Arch: pacman -S vulkan-swrast). WGPU_BACKEND and VK_DRIVER_FILES hide adapters where they are set.";
