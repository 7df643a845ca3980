//! Buffers and raster targets that steps 4 to 7 write for a tile.

use crate::twin::film::halves;
use crate::twin::lattice::unpack_albedo;
use crate::twin::resolve::{Node, sort};
use glam::{Vec3, Vec4};
use pelage_core::{Error, Result};
use pelage_fur::layout::{BASE_WORDS, NODE_FEATURE_WORDS, NODE_WORDS, SAMPLE_FEATURE_WORDS, SAMPLE_WORDS};
use pelage_fur::octahedral;
use pelage_gpu::kernel::{DEPTH_FORMAT, ID_FORMAT};
use pelage_gpu::recorder::RasterTargets;
use pelage_gpu::{Buffer, Buffers, Gpu, Resource, Scope};

/// Bytes per fragment in the lists, without features.
pub const FRAGMENT_BYTES: u64 = 4 * NODE_WORDS as u64;

/// Bytes of `march_counters`; `shaders/shared/march_counters.wgsl` names its words.
pub const COUNTER_BYTES: u64 = 32;

/// What steps 5 and 7 count in `march_counters`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct MarchCounts {
    /// Rays that lost their place in the shell.
    pub rays_lost: u64,
    /// Length of the longest list.
    pub longest: u64,
    /// Fragments in the lists that `resolve` walked.
    pub listed: u64,
    /// Fragments of these that it did not reach before the adapter ended the loops.
    pub unread: u64,
    /// Rays of `resolve` whose loops the adapter ended.
    pub rays_cut: u64,
    /// Nested marches towards a light that reached their last step.
    pub light_paths_cut: u64,
    /// Rays of `undercoat_march` whose loops the adapter ended.
    pub marches_cut: u64,
}

impl MarchCounts {
    /// Counts of two passes over the image.
    pub fn plus(self, other: Self) -> Self {
        Self {
            rays_lost: self.rays_lost + other.rays_lost,
            longest: self.longest.max(other.longest),
            listed: self.listed + other.listed,
            unread: self.unread + other.unread,
            rays_cut: self.rays_cut + other.rays_cut,
            light_paths_cut: self.light_paths_cut + other.light_paths_cut,
            marches_cut: self.marches_cut + other.marches_cut,
        }
    }

    /// These counts after `resolve` has run once more and counted `again`, from zero.
    pub fn resolved_again(self, again: Self) -> Self {
        Self {
            rays_lost: self.rays_lost.max(again.rays_lost),
            light_paths_cut: self.light_paths_cut.max(again.light_paths_cut),
            marches_cut: self.marches_cut,
            ..again
        }
    }
}

/// Words per sample besides fragments: base record, list head, film sample, triangle number, depth.
const WORDS: u32 = BASE_WORDS + 1 + SAMPLE_WORDS + 1 + 1;

/// Bytes per fragment in the lists.
pub fn fragment_bytes(features: bool) -> u64 {
    FRAGMENT_BYTES + if features { 4 * u64::from(NODE_FEATURE_WORDS) } else { 0 }
}

/// Bytes per sample besides fragments.
pub fn sample_bytes(features: bool) -> u64 {
    4 * u64::from(WORDS + if features { SAMPLE_FEATURE_WORDS } else { 0 })
}

/// The buffers `base_records`, `fragment_lists`, `samples` and `march_counters`, and the targets of
/// the raster passes.
pub struct TileBuffers {
    buffers: Buffers,
    ids: wgpu::Texture,
    views: [wgpu::TextureView; 2],
    features: bool,
}

/// Size of `fragment_lists` for `samples` samples and `fragments` fragments without features,
/// bytes.
pub fn list_bytes(samples: u64, fragments: u64) -> u64 {
    4 * (1 + samples) + FRAGMENT_BYTES * fragments
}

impl TileBuffers {
    /// Allocates for tiles of up to `size` samples. `list_bytes`: size of `fragment_lists` (see
    /// [`list_bytes()`]); `features`: whether samples and fragments have them.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`], [`Error::Gpu`].
    pub fn new(gpu: &Gpu, size: [u32; 2], list_bytes: u64, features: bool) -> Result<Self> {
        let samples = u64::from(size[0]) * u64::from(size[1]);
        let sample_words = SAMPLE_WORDS + if features { SAMPLE_FEATURE_WORDS } else { 0 };
        let buffers = vec![
            gpu.storage("base_records", 5, samples * 4 * u64::from(BASE_WORDS))?,
            gpu.storage("fragment_lists", 6, list_bytes)?,
            gpu.storage("samples", 7, samples * 4 * u64::from(sample_words))?,
            gpu.storage("march_counters", 7, COUNTER_BYTES)?,
        ];
        use wgpu::TextureUsages as U;
        let texture = |format, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some("raster"),
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let ids = texture(ID_FORMAT, U::RENDER_ATTACHMENT | U::TEXTURE_BINDING | U::COPY_SRC);
        let depth = texture(DEPTH_FORMAT, U::RENDER_ATTACHMENT);
        gpu.check("base_raster")?;
        let views = [&ids, &depth].map(|texture| texture.create_view(&Default::default()));
        Ok(Self { buffers: buffers.into(), ids, views, features })
    }

    /// A buffer by its name.
    ///
    /// # Errors
    /// [`Error::Gpu`] if there is none of that name; it lists the names that exist.
    pub fn buffer(&self, name: &str) -> Result<&Buffer> {
        self.buffers.get(name)
    }

    /// Reads `march_counters`.
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn counts(&self, gpu: &Gpu) -> Result<MarchCounts> {
        let words: Vec<u32> = gpu.read(self.buffer("march_counters")?, COUNTER_BYTES)?;
        let word = |i: usize| u64::from(words.get(i).copied().unwrap_or(0));
        Ok(MarchCounts {
            rays_lost: word(0),
            longest: word(1),
            listed: word(2),
            unread: word(3),
            rays_cut: word(4),
            light_paths_cut: word(5),
            marches_cut: word(6),
        })
    }

    /// Number of fragments that fit the lists of a tile of `samples` samples.
    ///
    /// # Errors
    /// As [`TileBuffers::buffer`].
    pub fn capacity(&self, samples: u64) -> Result<u64> {
        let room = self.buffer("fragment_lists")?.size.saturating_sub(list_bytes(samples, 0));
        Ok(room / fragment_bytes(self.features))
    }

    /// `scope` with these buffers and `triangle_ids` added.
    pub fn add_to<'a>(&'a self, scope: &Scope<'a>) -> Scope<'a> {
        self.buffers.add_to(scope).and("triangle_ids", Resource::Texture(&self.views[0]))
    }

    /// The targets of raster passes for a tile of `size` samples.
    pub fn targets(&self, size: [u32; 2]) -> RasterTargets<'_> {
        RasterTargets { ids: &self.views[0], depth: &self.views[1], size }
    }

    /// The triangle numbers: the number of the nearest triangle + 1, or 0 where there is none.
    pub fn ids(&self) -> &wgpu::Texture {
        &self.ids
    }

    /// Reads the fragments of each of the first `samples` samples back, nearest first.
    ///
    /// # Errors
    /// [`Error::Unsupported`] if there are more fragments than fit, or some are in no list.
    pub fn lists(&self, gpu: &Gpu, samples: usize) -> Result<Vec<Vec<Node>>> {
        let lists = self.buffer("fragment_lists")?;
        let capacity = self.capacity(samples as u64)?;
        let used = u64::from(gpu.read::<u32>(lists, 4)?.first().copied().unwrap_or(0));
        if used > capacity {
            return Err(Error::Unsupported(format!(
                "{used} fragments, but the lists hold {capacity}: use a smaller tile"
            )));
        }
        let bytes = list_bytes(samples as u64, 0) + used * fragment_bytes(self.features);
        let words: Vec<u32> = gpu.read(lists, bytes)?;
        let of_node = (fragment_bytes(self.features) / 4) as usize;
        let (heads, nodes) = words[1..].split_at(samples);
        let node = |number: u32| &nodes[(number as usize - 1) * of_node..][..of_node];
        let list = |head: u32| {
            let mut list = Vec::new();
            let mut next = head;
            while next != 0 {
                let words = node(next);
                let ([r, g], [b, a]) = (halves(words[3]), halves(words[4]));
                let color = Vec4::new(r, g, b, a);
                let (mut albedo, mut tangent) = (Vec3::ZERO, Vec3::ZERO);
                if let [packed, direction] = words[NODE_WORDS as usize..] {
                    (albedo, tangent) = (unpack_albedo(packed), octahedral::unpack(direction));
                }
                let (z, source) = (f32::from_bits(words[1]), words[2]);
                list.push(Node { z, source, color, albedo, tangent });
                next = words[0];
            }
            sort(&mut list);
            list
        };
        let lists: Vec<Vec<Node>> = heads.iter().map(|head| list(*head)).collect();
        let listed: usize = lists.iter().map(Vec::len).sum();
        if listed as u64 != used {
            return Err(Error::Unsupported(format!(
                "{used} fragments were counted, but {listed} are in the lists"
            )));
        }
        Ok(lists)
    }
}
