//! Kernels: WGSL entry points whose bindings are found by name.
//!
//! A resource has one name everywhere: the buffer called `prisms` is bound wherever a shader
//! declares `prisms`. Layouts come from naga's reflection of what the entry point uses, so that
//! Rust code contains no binding numbers.

use super::{Buffer, Gpu, shader};
use pelage_core::{Error, Result};
use std::collections::BTreeMap;

/// A resource that can be bound to a name.
#[derive(Clone, Copy)]
pub enum Resource<'a> {
    /// The whole of a buffer.
    Buffer(&'a wgpu::Buffer),
    /// A texture.
    Texture(&'a wgpu::TextureView),
    /// A sampler.
    Sampler(&'a wgpu::Sampler),
}

impl Resource<'_> {
    fn kind(&self) -> &'static str {
        match self {
            Self::Buffer(_) => "a buffer",
            Self::Texture(_) => "a texture",
            Self::Sampler(_) => "a sampler",
        }
    }
}

/// Resources by the names under which shaders declare them.
#[derive(Clone, Default)]
pub struct Scope<'a>(BTreeMap<&'a str, Resource<'a>>);

impl<'a> Scope<'a> {
    /// The same scope with `buffers` added; later ones replace earlier ones of the same name.
    pub fn with(&self, buffers: &[&'a Buffer]) -> Self {
        let mut scope = self.clone();
        for buffer in buffers {
            scope.0.insert(buffer.name, Resource::Buffer(&buffer.raw));
        }
        scope
    }

    /// The same scope with `resource` added under `name`; it replaces an earlier one.
    pub fn and(&self, name: &'a str, resource: Resource<'a>) -> Self {
        let mut scope = self.clone();
        scope.0.insert(name, resource);
        scope
    }
}

/// A binding as the shader declares it.
struct Binding {
    name: String,
    index: u32,
    ty: wgpu::BindingType,
    stages: wgpu::ShaderStages,
    /// Size of the declared type in bytes, a runtime-sized array counted as one element; 0 for
    /// textures and samplers.
    size: u64,
}

impl Binding {
    /// Whether a buffer of `size` bytes fits the declaration. A uniform buffer must have the size
    /// of its struct, rounded up because buffers are allocated in multiples of 16 bytes; a storage
    /// buffer may be larger than declared.
    fn takes(&self, size: u64) -> bool {
        match self.ty {
            wgpu::BindingType::Buffer { ty: wgpu::BufferBindingType::Uniform, .. } => {
                size == self.size.next_multiple_of(16)
            }
            _ => size >= self.size,
        }
    }
}

/// The bindings that one or more entry points of a module use.
struct Interface {
    stem: String,
    bindings: Vec<Binding>,
    layout: wgpu::BindGroupLayout,
}

impl Interface {
    fn reflect(
        gpu: &Gpu,
        stem: &str,
        module: &naga::Module,
        info: &naga::valid::ModuleInfo,
        entries: &[(&str, wgpu::ShaderStages)],
    ) -> Result<Self> {
        let mut bindings = Vec::new();
        for (handle, variable) in module.global_variables.iter() {
            let Some(place) = variable.binding else { continue };
            let mut stages = wgpu::ShaderStages::NONE;
            for (i, entry) in module.entry_points.iter().enumerate() {
                let stage = entries.iter().find(|(name, _)| *name == entry.name);
                if let Some((_, stage)) = stage.filter(|_| !info.get_entry_point(i)[handle].is_empty()) {
                    stages |= *stage;
                }
            }
            if stages.is_empty() {
                continue;
            }
            bindings.push(Binding {
                name: variable.name.clone().unwrap_or_default(),
                index: place.binding,
                ty: binding_type(stem, module, variable)?,
                stages,
                size: size_of(module, variable),
            });
        }
        let storage = bindings
            .iter()
            .filter(|b| {
                matches!(b.ty, wgpu::BindingType::Buffer { ty: wgpu::BufferBindingType::Storage { .. }, .. })
            })
            .count();
        if storage > gpu.limits.max_storage_buffers_per_shader_stage as usize {
            return Err(Error::gpu(
                stem,
                format!(
                    "{entries:?} use {storage} storage buffers, the adapter allows {}",
                    gpu.limits.max_storage_buffers_per_shader_stage
                ),
            ));
        }
        let entries: Vec<wgpu::BindGroupLayoutEntry> = bindings
            .iter()
            .map(|b| wgpu::BindGroupLayoutEntry {
                binding: b.index,
                visibility: b.stages,
                ty: b.ty,
                count: None,
            })
            .collect();
        let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(stem),
            entries: &entries,
        });
        Ok(Self { stem: stem.into(), bindings, layout })
    }

    fn bind(&self, gpu: &Gpu, scope: &Scope<'_>) -> Result<wgpu::BindGroup> {
        let mut entries = Vec::with_capacity(self.bindings.len());
        for binding in &self.bindings {
            let resource = scope.0.get(binding.name.as_str()).ok_or_else(|| {
                let known: Vec<&&str> = scope.0.keys().collect();
                Error::gpu(&self.stem, format!("nothing is bound to `{}`; in scope: {known:?}", binding.name))
            })?;
            let resource = match (resource, binding.ty) {
                (Resource::Buffer(buffer), wgpu::BindingType::Buffer { .. }) => {
                    if !binding.takes(buffer.size()) {
                        return Err(Error::gpu(
                            &self.stem,
                            format!(
                                "the buffer bound to `{}` has {} bytes, the shader declares {}",
                                binding.name,
                                buffer.size(),
                                binding.size
                            ),
                        ));
                    }
                    buffer.as_entire_binding()
                }
                (Resource::Texture(view), wgpu::BindingType::Texture { .. }) => {
                    wgpu::BindingResource::TextureView(view)
                }
                (Resource::Sampler(sampler), wgpu::BindingType::Sampler(_)) => {
                    wgpu::BindingResource::Sampler(sampler)
                }
                (found, _) => {
                    return Err(Error::gpu(
                        &self.stem,
                        format!(
                            "{} is bound to `{}`, which the shader declares as another kind of resource",
                            found.kind(),
                            binding.name
                        ),
                    ));
                }
            };
            entries.push(wgpu::BindGroupEntry { binding: binding.index, resource });
        }
        Ok(gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some(&self.stem),
            layout: &self.layout,
            entries: &entries,
        }))
    }
}

/// Size of a buffer's declared type in bytes, a runtime-sized array counted as one element; 0 for
/// other resources.
fn size_of(module: &naga::Module, variable: &naga::GlobalVariable) -> u64 {
    match variable.space {
        naga::AddressSpace::Uniform | naga::AddressSpace::Storage { .. } => {
            u64::from(module.types[variable.ty].inner.size(module.to_ctx()))
        }
        _ => 0,
    }
}

fn binding_type(
    stem: &str,
    module: &naga::Module,
    variable: &naga::GlobalVariable,
) -> Result<wgpu::BindingType> {
    use naga::{AddressSpace, ImageClass, ScalarKind, StorageAccess, TypeInner};
    let min_binding_size = std::num::NonZeroU64::new(size_of(module, variable));
    let buffer = |ty| wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size };
    Ok(match variable.space {
        AddressSpace::Uniform => buffer(wgpu::BufferBindingType::Uniform),
        AddressSpace::Storage { access } => {
            buffer(wgpu::BufferBindingType::Storage { read_only: !access.contains(StorageAccess::STORE) })
        }
        AddressSpace::Handle => match module.types[variable.ty].inner {
            TypeInner::Image { dim: naga::ImageDimension::D2, arrayed, class } => {
                let sample_type = match class {
                    ImageClass::Sampled { kind: ScalarKind::Uint, multi: false } => {
                        wgpu::TextureSampleType::Uint
                    }
                    ImageClass::Sampled { kind: ScalarKind::Float, multi: false } => {
                        wgpu::TextureSampleType::Float { filterable: true }
                    }
                    ImageClass::Depth { multi: false } => wgpu::TextureSampleType::Depth,
                    other => return Err(unsupported(stem, variable, &other)),
                };
                wgpu::BindingType::Texture {
                    sample_type,
                    view_dimension: if arrayed {
                        wgpu::TextureViewDimension::D2Array
                    } else {
                        wgpu::TextureViewDimension::D2
                    },
                    multisampled: false,
                }
            }
            TypeInner::Sampler { comparison: false } => {
                wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering)
            }
            ref other => return Err(unsupported(stem, variable, other)),
        },
        space => {
            return Err(Error::gpu(
                stem,
                format!("binding {:?} is in the unsupported address space {space:?}", variable.name),
            ));
        }
    })
}

fn unsupported(stem: &str, variable: &naga::GlobalVariable, found: &dyn std::fmt::Debug) -> Error {
    Error::gpu(stem, format!("binding {:?} has an unsupported type {found:?}", variable.name))
}

/// Compiles a module; errors are reported with file and line.
fn compile(gpu: &Gpu, stem: &str) -> Result<(wgpu::ShaderModule, naga::Module, naga::valid::ModuleInfo)> {
    let (resolved, module, info) = shader::validate(gpu.sources, stem)?;
    let compiled = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(stem),
        source: wgpu::ShaderSource::Wgsl(resolved.text.into()),
    });
    gpu.check(stem)?;
    Ok((compiled, module, info))
}

/// A compute entry point.
pub struct Kernel {
    /// `stem.entry`, the label in recordings and timings.
    pub label: String,
    /// Stem of the pass.
    pub stem: &'static str,
    pub(super) pipeline: wgpu::ComputePipeline,
    interface: Interface,
}

impl Kernel {
    /// Compiles entry point `entry` of shader `stem`.
    ///
    /// # Errors
    /// [`Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu, stem: &'static str, entry: &str) -> Result<Self> {
        Self::specialised(gpu, stem, entry, &[])
    }

    /// As [`Kernel::new`], with values for the shader's `override` constants.
    ///
    /// # Errors
    /// As [`Kernel::new`].
    pub fn specialised(
        gpu: &Gpu,
        stem: &'static str,
        entry: &str,
        constants: &[(&str, f64)],
    ) -> Result<Self> {
        let (compiled, module, info) = compile(gpu, stem)?;
        if !module.entry_points.iter().any(|e| e.name == entry) {
            let known: Vec<&str> = module.entry_points.iter().map(|e| e.name.as_str()).collect();
            return Err(Error::gpu(stem, format!("no entry point `{entry}`; the shader has {known:?}")));
        }
        let interface =
            Interface::reflect(gpu, stem, &module, &info, &[(entry, wgpu::ShaderStages::COMPUTE)])?;
        let label = format!("{stem}.{entry}");
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(&label),
            bind_group_layouts: &[Some(&interface.layout)],
            immediate_size: 0,
        });
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(&label),
            layout: Some(&layout),
            module: &compiled,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions { constants, ..Default::default() },
            cache: None,
        });
        gpu.check(stem)?;
        Ok(Self { label, stem, pipeline, interface })
    }

    pub(super) fn bind(&self, gpu: &Gpu, scope: &Scope<'_>) -> Result<wgpu::BindGroup> {
        self.interface.bind(gpu, scope)
    }
}

/// Output of a raster kernel, and the fixed-function state that goes with it.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// Triangle numbers, with depth test and depth writes; both sides are drawn.
    TriangleIds,
    /// No colour target: the fragment stage writes to storage buffers. Front faces only, no depth
    /// test.
    Records,
    /// Premultiplied colours with a depth test.
    Color {
        /// Blends over the target; otherwise replaces it.
        over: bool,
        /// Writes depth.
        solid: bool,
        /// Draws both sides; otherwise front faces only.
        both_sides: bool,
    },
}

/// A pair of vertex and fragment entry points.
pub struct RasterKernel {
    /// `stem.vertex`, the label in recordings and timings.
    pub label: String,
    /// Stem of the pass.
    pub stem: &'static str,
    pub(super) pipeline: wgpu::RenderPipeline,
    pub(super) target: Target,
    interface: Interface,
}

/// Format of triangle numbers.
pub const ID_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
/// Format of colour targets.
pub const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Format of the depth buffer.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

impl RasterKernel {
    /// Compiles the entry points `vertex` and `fragment` of shader `stem`.
    ///
    /// # Errors
    /// [`Error::Gpu`] with file and line of a fault in the shader.
    pub fn new(gpu: &Gpu, stem: &'static str, vertex: &str, fragment: &str, target: Target) -> Result<Self> {
        Self::specialised(gpu, stem, [vertex, fragment], target, &[])
    }

    /// As [`RasterKernel::new`], with values for the shader's `override` constants.
    ///
    /// # Errors
    /// As [`RasterKernel::new`].
    pub fn specialised(
        gpu: &Gpu,
        stem: &'static str,
        [vertex, fragment]: [&str; 2],
        target: Target,
        constants: &[(&str, f64)],
    ) -> Result<Self> {
        let (compiled, module, info) = compile(gpu, stem)?;
        let stages = [(vertex, wgpu::ShaderStages::VERTEX), (fragment, wgpu::ShaderStages::FRAGMENT)];
        let interface = Interface::reflect(gpu, stem, &module, &info, &stages)?;
        let label = format!("{stem}.{vertex}");
        let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(&label),
            bind_group_layouts: &[Some(&interface.layout)],
            immediate_size: 0,
        });
        // Reversed depth: nearer is greater.
        use wgpu::CompareFunction as Compare;
        let (format, over, solid, both_sides, compare) = match target {
            Target::TriangleIds => (Some(ID_FORMAT), false, true, true, Compare::Greater),
            // Without a colour target, the depth target alone sets the size of the render area.
            Target::Records => (None, false, false, false, Compare::Always),
            Target::Color { over, solid, both_sides } => {
                (Some(COLOR_FORMAT), over, solid, both_sides, Compare::GreaterEqual)
            }
        };
        let pictures: Vec<_> = format
            .into_iter()
            .map(|format| {
                let blend = over.then_some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING);
                Some(wgpu::ColorTargetState { format, blend, write_mask: wgpu::ColorWrites::ALL })
            })
            .collect();
        let options = || wgpu::PipelineCompilationOptions { constants, ..Default::default() };
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(&label),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &compiled,
                entry_point: Some(vertex),
                compilation_options: options(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module: &compiled,
                entry_point: Some(fragment),
                compilation_options: options(),
                targets: &pictures,
            }),
            primitive: wgpu::PrimitiveState {
                cull_mode: (!both_sides).then_some(wgpu::Face::Back),
                ..Default::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(solid),
                depth_compare: Some(compare),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            multiview_mask: None,
            cache: None,
        });
        gpu.check(stem)?;
        Ok(Self { label, stem, pipeline, target, interface })
    }

    pub(super) fn bind(&self, gpu: &Gpu, scope: &Scope<'_>) -> Result<wgpu::BindGroup> {
        self.interface.bind(gpu, scope)
    }
}
