//! Tables of multiple scattering as textures.

use half::f16;
use pelage_core::Result;
use pelage_gpu::{Gpu, Resource, Scope};
use pelage_transport::{ALBEDOS, COSINES, DEPTHS, ROWS, Table};

/// The textures and the sampler that `shaders/shared/transport.wgsl` reads.
pub(super) struct Tables {
    field: wgpu::TextureView,
    sent: wgpu::TextureView,
    response: wgpu::TextureView,
    sampler: wgpu::Sampler,
}

impl Tables {
    /// Uploads the tables; `None` if the model of multiple scattering has none.
    pub(super) fn new(gpu: &Gpu, scattered: Option<&Table>) -> Result<Self> {
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("table_sampler"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let size = |rows: usize, layers: usize| [COSINES, rows, layers].map(|n| n as u32);
        // Without tables, bound but not read.
        let nothing = || upload(gpu, [1, 1, 2], &[[0.0; 4]; 2]);
        let (field, sent, response) = match scattered {
            Some(table) => (
                upload(gpu, size(3 * DEPTHS, ALBEDOS), table.field_texels())?,
                upload(gpu, size(3 * DEPTHS, COSINES * ALBEDOS), table.sent_texels())?,
                upload(gpu, size(ROWS, ALBEDOS), &table.response_texels())?,
            ),
            None => (nothing()?, nothing()?, nothing()?),
        };
        Ok(Self { field, sent, response, sampler })
    }

    /// `scope` with `field_table`, `sent_table`, `response_table` and `table_sampler` added.
    pub(super) fn bind<'a>(&'a self, scope: Scope<'a>) -> Scope<'a> {
        scope
            .and("field_table", Resource::Texture(&self.field))
            .and("sent_table", Resource::Texture(&self.sent))
            .and("response_table", Resource::Texture(&self.response))
            .and("table_sampler", Resource::Sampler(&self.sampler))
    }
}

fn upload(gpu: &Gpu, [width, height, layers]: [u32; 3], texels: &[[f32; 4]]) -> Result<wgpu::TextureView> {
    let texels: Vec<[f16; 4]> = texels.iter().map(|t| t.map(f16::from_f32)).collect();
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: layers };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("scattering table"),
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
