//! Baked textures on the GPU: one array texture for the layers of all levels of detail, with mips.

use crate::bake::{FurTextures, Texture, lod, mips};
use half::f16;
use pelage_core::{Error, Result};
use pelage_gpu::Gpu;

/// The uploaded textures and their samplers.
pub(super) struct Uploaded {
    /// Layers of all levels of detail, one level after the other.
    pub layers: wgpu::TextureView,
    /// Contribution of the guard hairs to the layers, or one empty texel.
    pub guard: wgpu::TextureView,
    /// The fin, and the guard hairs' contribution to it.
    pub fin: wgpu::TextureView,
    /// Repeats along u and v, for layers.
    pub repeating: wgpu::Sampler,
    /// Repeats along u and clamps along v, for fins.
    pub upright: wgpu::Sampler,
}

/// Means of a layer: colours (linear RGB) and coverage.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Means {
    /// Mean colour of everything but guard hair.
    pub undercoat: [f32; 3],
    /// Mean colour of the guard hairs.
    pub guard: [f32; 3],
    /// Mean coverage.
    pub coverage: f32,
    /// Fraction of the coverage that is guard hair.
    pub share: f32,
}

/// Rows of texels in the coarsest mip of a fin. Light on a fin varies strongly from skin to tip, so
/// that different heights must not be mixed.
pub(crate) const FIN_TEXELS: u32 = 8;

/// The fin and the guard hairs' contribution to it, for a slab of fur `times` as deep:
/// transmittances are raised to that power. This must be done before mips are made, because the
/// power of a mean is not the mean of the powers.
pub fn deepened(textures: &FurTextures, times: f32) -> [Texture; 2] {
    let factor = |coverage: f32| (1.0 - (1.0 - coverage).max(0.0).powf(times)) / coverage.max(1e-6);
    let scaled = |part: &Texture| {
        let texels = part.texels.iter().zip(&textures.fin.texels);
        Texture { texels: texels.map(|(t, whole)| t.map(|c| c * factor(whole[3]))).collect(), ..part.clone() }
    };
    [scaled(&textures.fin), scaled(&textures.fin_guard)]
}

/// Uploads all levels of detail with their mips, and the fin textures (whole, guard hairs'
/// contribution). Returns the means of all layers too.
pub(super) fn upload(
    gpu: &Gpu,
    textures: &FurTextures,
    [fin, mut fin_guard]: [Texture; 2],
) -> Result<(Uploaded, Vec<Means>)> {
    let coarser = lod::coarser(textures);
    let all: Vec<&Texture> = textures.layers.iter().chain(coarser.iter().flat_map(|l| &l.layers)).collect();
    let mut guard: Vec<&Texture> =
        textures.guard.iter().chain(coarser.iter().flat_map(|l| &l.guard)).collect();
    let means = (0..all.len()).map(|i| means(all[i], guard.get(i).copied())).collect();
    let none = Texture { width: 1, height: 1, texels: vec![[0.0; 4]] };
    if guard.is_empty() {
        guard.push(&none);
    }
    if fin_guard.texels.len() != fin.texels.len() {
        fin_guard = Texture { texels: vec![[0.0; 4]; fin.texels.len()], ..fin };
    }
    let coarsest = (fin.height.max(1) / FIN_TEXELS).max(1).ilog2();
    let sampler = |v, coarsest: f32| {
        gpu.device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("fur"),
            address_mode_u: wgpu::AddressMode::Repeat,
            address_mode_v: v,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            mipmap_filter: wgpu::MipmapFilterMode::Linear,
            lod_max_clamp: coarsest,
            // On software adapters anisotropic filtering costs more than ten times everything else;
            // images rendered there have more samples instead.
            anisotropy_clamp: if gpu.software { 1 } else { 8 },
            ..Default::default()
        })
    };
    let uploaded = Uploaded {
        layers: array(gpu, "layers", &all)?,
        guard: array(gpu, "guard_layers", &guard)?,
        fin: array(gpu, "fin", &[&fin, &fin_guard])?,
        repeating: sampler(wgpu::AddressMode::Repeat, 32.0),
        upright: sampler(wgpu::AddressMode::ClampToEdge, coarsest as f32),
    };
    Ok((uploaded, means))
}

fn means(whole: &Texture, guard: Option<&Texture>) -> Means {
    let sum = |texture: Option<&Texture>| {
        texture.into_iter().flat_map(|t| &t.texels).fold([0f64; 4], |mut sum, texel| {
            (0..4).for_each(|k| sum[k] += f64::from(texel[k]));
            sum
        })
    };
    let (all, guard) = (sum(Some(whole)), sum(guard));
    let color = |sum: [f64; 4]| [0, 1, 2].map(|k| (sum[k] / sum[3].max(1e-12)).clamp(0.0, 1.0) as f32);
    Means {
        undercoat: color([0, 1, 2, 3].map(|k| (all[k] - guard[k]).max(0.0))),
        guard: color(guard),
        coverage: (all[3] / whole.texels.len().max(1) as f64) as f32,
        share: (guard[3] / all[3].max(1e-12)).clamp(0.0, 1.0) as f32,
    }
}

/// Uploads an array texture with all mips.
fn array(gpu: &Gpu, name: &'static str, layers: &[&Texture]) -> Result<wgpu::TextureView> {
    let [width, height] = [layers[0].width, layers[0].height];
    let limit = gpu.limits.max_texture_array_layers;
    if layers.len() as u32 > limit {
        return Err(Error::gpu(
            "shellfin_raster",
            format!(
                "found {} layers including levels of detail, the adapter supports at most {limit}",
                layers.len()
            ),
        ));
    }
    let side = gpu.limits.max_texture_dimension_2d;
    if width.max(height) > side {
        return Err(Error::gpu(
            "shellfin_raster",
            format!(
                "found a texture of {width} x {height} texels, the adapter supports at most {side} per side"
            ),
        ));
    }
    let levels = mips::levels([width, height]);
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(name),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: layers.len() as u32 },
        mip_level_count: levels,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    for (i, layer) in layers.iter().enumerate() {
        for (level, mip) in mips::chain(layer, mips::Keep::Mean).iter().enumerate() {
            let texels: Vec<[f16; 4]> = mip.texels.iter().map(|t| t.map(f16::from_f32)).collect();
            gpu.queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture: &texture,
                    mip_level: level as u32,
                    origin: wgpu::Origin3d { x: 0, y: 0, z: i as u32 },
                    aspect: wgpu::TextureAspect::All,
                },
                bytemuck::cast_slice(&texels),
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(8 * mip.width),
                    rows_per_image: Some(mip.height),
                },
                wgpu::Extent3d { width: mip.width, height: mip.height, depth_or_array_layers: 1 },
            );
        }
    }
    gpu.check("shellfin_raster")?;
    Ok(texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    }))
}
