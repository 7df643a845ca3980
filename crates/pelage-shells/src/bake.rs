//! Bakes textures of hair for shells and fins, from a groom, a particle system or dots, and writes
//! them for real-time clients.

pub mod compress;
mod dots;
mod fin;
pub mod gltf;
mod guard;
mod hybrid;
mod io;
pub mod ktx2;
pub mod lod;
mod manifest;
mod means;
pub mod memory;
pub mod mips;
mod particles;
mod png;
mod stamp;
mod strand;
mod torus;
mod undercoat;
mod voxels;

pub use fin::fin;
pub use io::{Format, MANIFEST, WriteOptions, check, check_folder, load, load_manifest, write};
pub use manifest::{
    Content, FileEntry, LayerSummary, LodEntry, Manifest, ManifestFile, Texels, manifest_schema,
};
pub use strand::{Hair, HairSource, Knot};
pub use voxels::{Block, Keep, Voxels, voxelise};

use glam::{Vec2, Vec4};
use pelage_core::maps;
use pelage_core::scene::BakeSource;
use pelage_core::{Error, Result, Skin, World};

/// An image that wraps around: linear RGB premultiplied by coverage, and coverage.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Texture {
    /// Texels along u.
    pub width: u32,
    /// Texels along v (upwards in a fin).
    pub height: u32,
    /// Texels, row by row with v = 0 first; texel (i, j) is centred on ((i + 0.5) / width, (j +
    /// 0.5) / height).
    pub texels: Vec<[f32; 4]>,
}

impl Texture {
    /// Bilinear lookup at `uv`, in units of the texture's edges. It wraps along u, and along v if
    /// `wrap_v`; otherwise the outer rows are repeated. Zero for a texture without texels.
    pub fn bilinear(&self, uv: Vec2, wrap_v: bool) -> Vec4 {
        if self.texels.is_empty() {
            return Vec4::ZERO;
        }
        let (width, height) = (self.width as i32, self.height as i32);
        maps::interpolate(uv * Vec2::new(width as f32, height as f32) - 0.5, |x, y| {
            let y = if wrap_v { y.rem_euclid(height) } else { y.clamp(0, height - 1) };
            Vec4::from(self.texels[(y * width + x.rem_euclid(width)) as usize])
        })
    }
}

/// All textures of a fur.
#[derive(Debug, Clone, PartialEq)]
pub struct FurTextures {
    /// The layers, innermost first, all of one size. Layer `l` represents the slab of fur from `l`
    /// to `l + 1` spacings above the skin and is drawn in its middle. Coverage is 1 − exp(−τ), as
    /// seen along the skin's normal with every hair perpendicular to the view. For particles τ is
    /// the hairs' length x diameter in the texel's column over the texel's area. For a groom
    /// (`hybrid`) τ is raised where a hair is deep in few texels, so that a single hair covers its
    /// length x diameter; then the mean transmittance of a layer is that of the fur, exp(−n d
    /// spacing), for any size of texels ([`Keep`]). Dots are opaque. The innermost layer is not
    /// made opaque; the skin lies below it.
    pub layers: Vec<Texture>,
    /// Contribution of the guard hairs to the premultiplied colour and the coverage of each layer.
    /// Empty if the source has only one kind of hair.
    pub guard: Vec<Texture>,
    /// The fin: coverage of a slab of hair seen from the side. u runs along the edge and wraps
    /// around; v runs from the skin to the tips and does not.
    pub fin: Texture,
    /// Contribution of the guard hairs to the fin; 0 x 0 if `guard` is empty.
    pub fin_guard: Texture,
    /// Metadata of the textures.
    pub manifest: Manifest,
}

/// Largest number of texels in all layers: 2 GiB with four bytes per channel, twice that with the
/// guard hairs' contribution.
const MOST_TEXELS: u64 = 1 << 27;

/// Bakes the textures that `world.scene.bake` describes. The same scene and seed give the same
/// bytes for any number of threads. All textures wrap around, except along v of the fin.
///
/// `hybrid` grows the scene's groom on the torus, upright: the renderer adds comb, lean and
/// gravity. Mapped parameters are replaced by their means over the skin, each separately. Hair
/// above the height is left out; if this is more than a hundredth of the length x diameter, a
/// warning is logged.
///
/// # Errors
/// [`Error::Scene`] if there is no hair, if sizes are not positive, or if the layers would be too
/// large.
pub fn bake(world: &World) -> Result<FurTextures> {
    let scene = &world.scene;
    let spec = &scene.bake;
    let seed = scene.render.seed;
    check_sizes(spec.layers, spec.resolution, spec.fin_resolution)?;
    let skin = diameter(&world.skin);
    let hybrid = spec.source == BakeSource::Hybrid;
    let patch = spec.patch.unwrap_or(if hybrid { 1.0 } else { skin / 16.0 });
    positive("bake.patch", patch, "give the edge of the torus in cm")?;
    let block = |height: f32| {
        positive("bake.height", height, "give the height of the fur in cm")?;
        Ok(Block { patch: [patch; 2], height, layers: spec.layers, resolution: spec.resolution })
    };
    let plain_height = spec.height.unwrap_or(skin / 1000.0 * spec.layers as f32);
    let (voxels, fins, block) = match spec.source {
        BakeSource::Hybrid => {
            let fur = hybrid::HybridFur::new(world, patch)?;
            check_patch(&fur, patch, spec.resolution)?;
            let block = block(spec.height.unwrap_or_else(|| fur.height()))?;
            let voxels = voxelise(&fur, &block, Keep::Coverage, true);
            (voxels, fin(&fur, &block, spec.fin_resolution, spec.fin_slab, true), block)
        }
        BakeSource::Particles => {
            let block = block(plain_height)?;
            let fur = particles::ParticleFur::new(&spec.particles, patch, block.height, seed);
            let voxels = voxelise(&fur, &block, Keep::Depth, false);
            (voxels, fin(&fur, &block, spec.fin_resolution, spec.fin_slab, false), block)
        }
        BakeSource::Dots => {
            let block = block(plain_height)?;
            let fur = dots::DotFur::new(&spec.dots, block, seed);
            (fur.layers(), (fur.fin(spec.fin_resolution, spec.fin_slab), Texture::default()), block)
        }
    };
    note_hair_above(&voxels, block.height);
    let manifest = Manifest {
        version: 1,
        generator: concat!("pelage ", env!("CARGO_PKG_VERSION")).into(),
        source: spec.source,
        seed,
        layers: spec.layers,
        resolution: spec.resolution,
        fin_resolution: spec.fin_resolution,
        patch: block.patch,
        fin_length: block.patch[0],
        fin_depth: spec.fin_slab * block.patch[1],
        height: block.height,
        spacing: block.height / spec.layers as f32,
        summary: voxels.layers.iter().zip(&voxels.optical_depth).map(|(t, d)| summary(t, *d)).collect(),
    };
    Ok(FurTextures { layers: voxels.layers, guard: voxels.guard, fin: fins.0, fin_guard: fins.1, manifest })
}

/// The hairs that `source = "particles"` grows in its box, and the box's `[edge, height]` in cm.
pub fn particle_hairs(world: &World) -> (Vec<Hair>, [f32; 2]) {
    let spec = &world.scene.bake;
    let skin = diameter(&world.skin);
    let patch = spec.patch.unwrap_or(skin / 16.0);
    let height = spec.height.unwrap_or(skin / 1000.0 * spec.layers as f32);
    let fur = particles::ParticleFur::new(&spec.particles, patch, height, world.scene.render.seed);
    ((0..fur.count()).map(|i| fur.hair(i)).collect(), [patch, height])
}

/// Diameter of a skin, cm: twice the distance from the centre of its bounding box to its farthest
/// vertex; 0 without vertices.
pub fn diameter(skin: &Skin) -> f32 {
    let (low, high) = skin.bounds();
    let middle = 0.5 * (low + high);
    skin.positions.iter().map(|p| 2.0 * p.distance(middle)).fold(0.0, f32::max)
}

fn positive(key: &str, value: f32, help: &str) -> Result<()> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(Error::fault(key, format!("found {value}, expected a length above 0: {help}")))
}

fn check_sizes(layers: u32, resolution: [u32; 2], fin: [u32; 2]) -> Result<()> {
    if !(1..=128).contains(&layers) {
        return Err(Error::fault("bake.layers", format!("found {layers}, expected 1 to 128")));
    }
    for (key, size) in [("bake.resolution", resolution), ("bake.fin_resolution", fin)] {
        if size.iter().any(|n| !(4..=4096).contains(n)) {
            return Err(Error::fault(
                key,
                format!("found {} x {}, expected 4 to 4096 texels", size[0], size[1]),
            ));
        }
    }
    let texels = u64::from(layers) * u64::from(resolution[0]) * u64::from(resolution[1]);
    if texels > MOST_TEXELS {
        let message = format!(
            "{layers} layers of {} x {} are {texels} texels, expected at most {MOST_TEXELS}: reduce bake.layers or bake.resolution",
            resolution[0], resolution[1]
        );
        return Err(Error::fault("bake.resolution", message));
    }
    Ok(())
}

/// Largest extent of a hair across the skin, texels: its footprint, which has the square of that,
/// is held in memory once per thread.
const MOST_ACROSS: f32 = 4000.0;

/// Checks that a hair's footprint on a torus of `patch` cm is not absurdly large.
fn check_patch(fur: &impl HairSource, patch: f32, resolution: [u32; 2]) -> Result<()> {
    /// Hairs that are looked at.
    const SAMPLE: u32 = 256;
    let across = (0..fur.count().min(SAMPLE))
        .flat_map(|i| fur.hair(i).knots)
        .map(|knot| 2.0 * knot.offset.truncate().abs().max_element() + knot.diameter)
        .fold(0.0, f32::max);
    let texels = across * resolution[0].max(resolution[1]) as f32 / patch;
    if texels <= MOST_ACROSS {
        return Ok(());
    }
    let least = across * resolution[0].max(resolution[1]) as f32 / MOST_ACROSS;
    Err(Error::fault(
        "bake.patch",
        format!(
            "found {patch:e} cm: a hair, {across:.3} cm across the skin, would touch {texels:.0} texels in a row, expected at \
             most {MOST_ACROSS}: with this groom and bake.resolution give {:.4} cm or more",
            1.05 * least
        ),
    ))
}

fn note_hair_above(voxels: &Voxels, height: f32) {
    let total: f64 = voxels.optical_depth.iter().sum::<f64>() + voxels.above;
    let part = voxels.above / total.max(1e-30);
    if part > 0.01 {
        tracing::warn!(
            "bake.height: {:.1} % of the hairs' length x diameter lies above {height} cm and is not baked",
            100.0 * part
        );
    } else if part > 0.0 {
        tracing::info!(
            "{:.2} % of the hairs' length x diameter lies above {height} cm and is not baked",
            100.0 * part
        );
    }
}

fn summary(texture: &Texture, optical_depth: f64) -> LayerSummary {
    let mut sum = [0.0f64; 4];
    for texel in &texture.texels {
        (0..4).for_each(|k| sum[k] += f64::from(texel[k]));
    }
    let color = [0, 1, 2].map(|k| if sum[3] > 0.0 { (sum[k] / sum[3]) as f32 } else { 0.0 });
    let coverage = (sum[3] / texture.texels.len().max(1) as f64) as f32;
    LayerSummary { coverage, optical_depth: optical_depth as f32, color }
}
