//! Tables of the hairs' scattering on the GPU.

use crate::Result;
use crate::fibre::Fibre;
use crate::gpu::{Gpu, Resource, Scope};
use half::f16;

/// One texture a layer of the fur.
pub(super) struct Tables {
    guard: wgpu::TextureView,
    coat: wgpu::TextureView,
    sampler: wgpu::Sampler,
}

impl Tables {
    pub(super) fn new(gpu: &Gpu, guard: &Fibre, coat: &Fibre) -> Result<Self> {
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("table_sampler"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        Ok(Self { guard: upload(gpu, guard)?, coat: upload(gpu, coat)?, sampler })
    }

    /// `scope` with `guard_table`, `coat_table` and `table_sampler`.
    pub(super) fn bind<'a>(&'a self, scope: Scope<'a>) -> Scope<'a> {
        scope
            .and("guard_table", Resource::Texture(&self.guard))
            .and("coat_table", Resource::Texture(&self.coat))
            .and("table_sampler", Resource::Sampler(&self.sampler))
    }
}

fn upload(gpu: &Gpu, fibre: &Fibre) -> Result<wgpu::TextureView> {
    let ([width, height, layers], texels) = fibre.texels();
    let texels: Vec<[f16; 4]> = texels.iter().map(|t| t.map(f16::from_f32)).collect();
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: layers };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("fibre table"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    gpu.queue.write_texture(
        wgpu::TexelCopyTextureInfo {
            texture: &texture,
            mip_level: 0,
            origin: wgpu::Origin3d::ZERO,
            aspect: wgpu::TextureAspect::All,
        },
        bytemuck::cast_slice(&texels),
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(8 * width),
            rows_per_image: Some(height),
        },
        size,
    );
    gpu.check("prepare")?;
    Ok(texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    }))
}
