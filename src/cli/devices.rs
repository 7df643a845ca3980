//! `pelage devices`.

use super::{backend::gpu, output};
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
        let rows: Vec<_> = adapters
            .iter()
            .map(|a| {
                serde_json::json!({
                    "name": a.name, "backend": a.backend, "driver": a.driver, "device_type": a.device_type,
                    "usable": a.limits_ok.is_ok(), "reason": a.limits_ok.as_ref().err(),
                })
            })
            .collect();
        output::print_json(&rows.into())?;
    } else {
        for a in &adapters {
            let usable = match &a.limits_ok {
                Ok(()) => "usable".to_owned(),
                Err(why) => format!("not usable: {why}"),
            };
            output::print(&format!(
                "{}\n  {}, {}, {}\n  {usable}\n",
                a.name, a.backend, a.device_type, a.driver
            ))?;
        }
    }
    if adapters.is_empty() { Err(Error::Adapter(NO_ADAPTER.into())) } else { Ok(()) }
}

const NO_ADAPTER: &str = "no GPU adapter answers\n  \
help: install a driver for Vulkan, Metal or DirectX 12; a software adapter will do \
(Debian, Ubuntu: apt-get install mesa-vulkan-drivers; Fedora: dnf install mesa-vulkan-drivers; \
Arch: pacman -S vulkan-swrast). WGPU_BACKEND and VK_DRIVER_FILES hide adapters where they are set.";
