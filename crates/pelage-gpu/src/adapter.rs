//! Choice of the adapter and its limits. An insufficient adapter is rejected with an error that
//! lists what it lacks.

use pelage_core::{Error, Result};

/// Properties of an adapter as `pelage devices` lists them.
#[derive(Debug, Clone, serde::Serialize)]
pub struct AdapterSummary {
    /// Name as the driver reports it.
    pub name: String,
    /// Vulkan, Metal, ...
    pub backend: String,
    /// Driver and version.
    pub driver: String,
    /// Cpu, DiscreteGpu, ...
    pub device_type: String,
    /// Largest storage binding, bytes.
    pub binding_bytes: u64,
    /// Whether passes can be timed.
    pub timestamps: bool,
    /// `None` if the adapter is sufficient, else the limits that it does not meet.
    pub lacks: Option<String>,
}

/// Advice for machines without a sufficient adapter, appended to error messages.
pub const HELP: &str = "install a Vulkan driver; without a GPU, Mesa's software adapter will do \
                    (Debian and Ubuntu: mesa-vulkan-drivers, Fedora: mesa-vulkan-drivers, Arch: vulkan-swrast)";

/// The backends that are tried: those in WGPU_BACKEND, or the primary ones.
fn backends() -> wgpu::Backends {
    wgpu::Backends::from_env().unwrap_or(wgpu::Backends::PRIMARY)
}

/// An instance of these backends only: OpenGL is not opened unless it is asked for.
fn instance() -> wgpu::Instance {
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle_from_env();
    descriptor.backends = backends();
    wgpu::Instance::new(descriptor)
}

fn all(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    pollster::block_on(instance.enumerate_adapters(backends()))
}

fn driver(info: &wgpu::AdapterInfo) -> String {
    format!("{} {}", info.driver, info.driver_info).trim().to_owned()
}

/// All adapters of the backends in WGPU_BACKEND; without it, of the primary ones.
pub fn list_adapters() -> Vec<AdapterSummary> {
    all(&instance())
        .iter()
        .map(|adapter| {
            let info = adapter.get_info();
            AdapterSummary {
                driver: driver(&info),
                backend: format!("{:?}", info.backend),
                device_type: format!("{:?}", info.device_type),
                binding_bytes: adapter.limits().max_storage_buffer_binding_size,
                timestamps: adapter.features().contains(wgpu::Features::TIMESTAMP_QUERY),
                lacks: limits_for(adapter).err().map(|e| e.to_string()),
                name: info.name,
            }
        })
        .collect()
}

/// The first adapter whose name contains WGPU_ADAPTER_NAME, ignoring case. Without that variable,
/// the best sufficient adapter: discrete before integrated GPUs (the reverse with
/// WGPU_POWER_PREF=low), then virtual GPUs, then the CPU.
///
/// # Errors
/// [`Error::Adapter`] if there is no adapter, none of that name, or none that is sufficient.
pub(super) fn select() -> Result<wgpu::Adapter> {
    let adapters = all(&instance());
    if adapters.is_empty() {
        return Err(Error::Adapter(format!("no GPU adapter answers; {HELP}")));
    }
    if let Some(wanted) = std::env::var("WGPU_ADAPTER_NAME").ok().filter(|name| !name.is_empty()) {
        let names: Vec<String> = adapters.iter().map(|a| a.get_info().name).collect();
        return adapters
            .into_iter()
            .find(|a| a.get_info().name.to_lowercase().contains(&wanted.to_lowercase()))
            .ok_or_else(|| {
                Error::Adapter(format!(
                    "WGPU_ADAPTER_NAME={wanted} matches no adapter; there are: {}",
                    names.join(", ")
                ))
            });
    }
    let low_power = std::env::var("WGPU_POWER_PREF").is_ok_and(|p| p.eq_ignore_ascii_case("low"));
    let rank = |adapter: &wgpu::Adapter| match adapter.get_info().device_type {
        wgpu::DeviceType::DiscreteGpu => u32::from(low_power),
        wgpu::DeviceType::IntegratedGpu => u32::from(!low_power),
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Cpu => 3,
        wgpu::DeviceType::Other => 4,
    };
    let lacking: Vec<String> =
        adapters.iter().filter_map(|a| limits_for(a).err()).map(|e| e.to_string()).collect();
    adapters
        .into_iter()
        .filter(|a| limits_for(a).is_ok())
        .min_by_key(rank)
        .ok_or_else(|| Error::Adapter(format!("no adapter is sufficient: {}; {HELP}", lacking.join("; "))))
}

/// The limits to request: WebGPU's defaults, with the sizes of buffers and storage bindings raised
/// to those of the adapter.
///
/// # Errors
/// [`Error::Adapter`] with every limit that the adapter does not meet.
pub(super) fn limits_for(adapter: &wgpu::Adapter) -> Result<wgpu::Limits> {
    let has = adapter.limits();
    let needs = wgpu::Limits::default();
    let checks = [
        (
            "storage buffers per shader stage",
            u64::from(needs.max_storage_buffers_per_shader_stage),
            u64::from(has.max_storage_buffers_per_shader_stage),
        ),
        ("bytes of a storage binding", 128 << 20, has.max_storage_buffer_binding_size),
        ("invocations per workgroup", 64, u64::from(has.max_compute_invocations_per_workgroup)),
        ("workgroups per dimension", 65_535, u64::from(has.max_compute_workgroups_per_dimension)),
        ("pixels along a texture's edge", 4096, u64::from(has.max_texture_dimension_2d)),
    ];
    let lacks: Vec<String> = checks
        .iter()
        .filter(|(_, needed, available)| available < needed)
        .map(|(what, needed, available)| format!("{what}: needs {needed}, has {available}"))
        .collect();
    if !lacks.is_empty() {
        return Err(Error::Adapter(format!("{}: {}", adapter.get_info().name, lacks.join(", "))));
    }
    Ok(wgpu::Limits {
        max_storage_buffer_binding_size: has.max_storage_buffer_binding_size,
        max_buffer_size: has.max_buffer_size,
        ..needs
    })
}
