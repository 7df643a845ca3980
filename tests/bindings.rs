//! What is bound to a kernel: a missing name, a wrong size and a wrong kind are errors that name
//! the binding.

use crate::common::gpu;
use pelage_fur::layout::{Bin, StrandBatch, TileGrid};
use pelage_gpu::{Buffers, Gpu, Kernel, Recorder, Scope};

/// The message of dispatching a kernel that reads `bin` and writes `words`, with these buffers in
/// scope.
fn message(gpu: &Gpu, scope: &Scope<'_>) -> Option<String> {
    let kernel = Kernel::new(gpu, "bound", "main").expect("a kernel");
    let mut recorder = Recorder::new(gpu);
    recorder.dispatch(&kernel, scope, 1).err().map(|fault| fault.to_string())
}

fn open() -> Option<Gpu> {
    gpu::open()?;
    let source = |name: &str| {
        (name == "bound").then(|| {
            "struct Bin { start: u32, strands: u32, }\n\
             struct Record { words: array<u32, 8>, }\n\
             @group(0) @binding(0) var<uniform> bin: Bin;\n\
             @group(0) @binding(1) var<storage, read_write> records: array<Record>;\n\
             @compute @workgroup_size(64)\n\
             fn main(@builtin(global_invocation_id) id: vec3u) { records[id.x].words[0] = bin.start; }\n"
                .into()
        })
    };
    Some(Gpu::open(source).expect("a device"))
}

#[test]
fn buffers_of_the_declared_size_are_bound() {
    let Some(gpu) = open() else { return };
    let bin = gpu.uniform("bin", &Bin { start: 0, strands: 0 }).unwrap();
    let records = gpu.storage("records", 0, 32).unwrap();
    assert_eq!(message(&gpu, &Scope::default().with(&[&bin, &records])), None);
}

#[test]
fn a_wrong_size_names_the_binding_and_both_sizes() {
    let Some(gpu) = open() else { return };
    let grid = TileGrid { origin: [0; 2], size: [0; 2], grid: [0; 2], margin: 0.0, length: 0.0 };
    let wrong = gpu.uniform("bin", &grid).unwrap();
    let records = gpu.storage("records", 0, 32).unwrap();
    let found = message(&gpu, &Scope::default().with(&[&wrong, &records])).expect("a fault");
    assert!(found.contains("`bin`") && found.contains("32 bytes") && found.contains("declares 8"), "{found}");
    // An array needs room for one element.
    let bin = gpu.uniform("bin", &Bin { start: 0, strands: 0 }).unwrap();
    let short = gpu.storage("records", 0, 16).unwrap();
    let found = message(&gpu, &Scope::default().with(&[&bin, &short])).expect("a fault");
    assert!(
        found.contains("`records`") && found.contains("16 bytes") && found.contains("declares 32"),
        "{found}"
    );
}

#[test]
fn an_unknown_name_names_what_is_in_scope() {
    let Some(gpu) = open() else { return };
    let other = gpu.uniform("strand_batch", &StrandBatch { strands: 0 }).unwrap();
    let records = gpu.storage("records", 0, 32).unwrap();
    let found = message(&gpu, &Scope::default().with(&[&other, &records])).expect("a fault");
    assert!(found.contains("`bin`") && found.contains("strand_batch"), "{found}");
    let buffers = Buffers::from(vec![other, records]);
    assert!(buffers.get("records").is_ok());
    let found = buffers.get("record").err().expect("a fault").to_string();
    assert!(
        found.contains("record") && found.contains("records") && found.contains("strand_batch"),
        "{found}"
    );
}

#[test]
fn a_texture_is_no_buffer() {
    let Some(gpu) = open() else { return };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::R32Uint,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    let view = texture.create_view(&Default::default());
    let records = gpu.storage("records", 0, 32).unwrap();
    let scope = Scope::default().with(&[&records]).and("bin", pelage_gpu::Resource::Texture(&view));
    let found = message(&gpu, &scope).expect("a fault");
    assert!(found.contains("`bin`") && found.contains("a texture"), "{found}");
}
