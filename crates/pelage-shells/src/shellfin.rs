//! Shells and fins: the real-time image of a fur, rasterised with baked textures.
// Drawing order, the fade of the fins, lighting by a table and levels of detail: [Lengyel2001].
// Silhouette test by a threshold and shells without depth writing: [Tariq2007]. Forces and shadows
// between hairs: [Xbdev].

mod geometry;
mod hair;
mod picture;
mod rows;
mod spread;
mod table;
mod textures;

pub use geometry::{Overlapping, corners, edges};
pub(crate) use geometry::{uv_area, uv_in_cm};
pub(crate) use hair::{bent, brush_weight, hair_curve};
pub use picture::{Pictures, run};
pub use rows::{FIN_ROWS, levels, rows};
pub use spread::spread;
pub use table::{hair_lighting, lighting_table};
pub(crate) use textures::FIN_TEXELS;
pub use textures::{Means, deepened};

use crate::bake::{FurTextures, Manifest};
use crate::passes::shellfin_raster::{Draws, ShellfinRaster, Uses};
use crate::passes::shellfin_rows::ShellfinRows;
use crate::{dynamics, lapped};
use bytemuck::Zeroable;
use glam::Vec3;
use pelage_core::scene::{BakeSource, Color, FinFade, Mapping, Scalar, ShellLighting, Shells};
use pelage_core::{Error, Result, World};
use pelage_fur::layout::{Brush, Frame, ShellRow, Shellfin};
use pelage_gpu::recorder::{RasterTargets, Timings};
use pelage_gpu::{Buffer, Gpu, Recorder, Resource, Scope};
use pelage_render::prepare::Prepared;

/// Standard deviation per axis of the direction of hairs that do not grow from a groom, as the
/// tangent of the angle. Because of it, hair seen along its length still has coverage.
const STRAY: f32 = 0.3;

/// Depth of fur that a fin represents, relative to the mean edge length. With this value the fins
/// on a ball cover as much as its hybrid fur.
const FIN_SPACING: f32 = 0.4;

/// A fur as shells and fins, on the GPU.
pub struct Shellfins<'g> {
    gpu: &'g Gpu,
    world: &'g World,
    prepared: Prepared<'g>,
    pass_rows: ShellfinRows,
    pass_raster: ShellfinRaster,
    textures: textures::Uploaded,
    means: Vec<Means>,
    /// Number of texture layers.
    layers: u32,
    base: Shellfin,
    buffers: Vec<Buffer>,
    edges: u32,
    shell_triangles: u32,
    /// Depth of fur that a fin represents, relative to that of its texture.
    pub fin_depth: f32,
    /// Centre of the skin's bounding box, and the length of its diagonal, cm.
    bounds: (Vec3, f32),
}

/// What changes from frame to frame besides the camera.
#[derive(Debug, Clone, Copy, Default)]
pub struct Pose {
    /// Displacement of the tips by forces, cm, world space. It is limited to the height of the fur;
    /// where `shells.length` shortens the hair it is scaled down in proportion.
    pub bend: Vec3,
}

impl Pose {
    /// The pose `time` s after the scene's first frame, for fur `height` cm high
    /// ([`Shellfins::height`]). At time 0 the hair is at rest under gravity and the mean wind.
    // [Xbdev]
    pub fn at(world: &World, time: f64, height: f32) -> Self {
        let scene = &world.scene;
        Self { bend: dynamics::bend(&scene.shells.dynamics, &scene.animation.motion, height, time) }
    }

    /// The displacement in units of the fur's height, at most 1 long.
    pub fn by_height(&self, height: f32) -> Vec3 {
        (self.bend / height.max(1e-6)).clamp_length_max(1.0)
    }
}

/// The rows of one frame.
pub struct Rows {
    /// Parameters, as uploaded.
    pub shellfin: Shellfin,
    /// The rows, shells first.
    pub rows: Vec<ShellRow>,
    /// Numbers of primitives to draw.
    pub draws: Draws,
    buffers: [Buffer; 4],
}

/// Variance per axis of the direction of hairs other than guard hairs, `height` cm above the skin.
pub(crate) fn stray_variance(world: &World, source: BakeSource, height: f32) -> f32 {
    if source != BakeSource::Hybrid {
        return STRAY * STRAY;
    }
    // Same as the random rotation of the undercoat's tangents (shaders/shared/clumps.wgsl).
    let undercoat = &world.scene.undercoat;
    let t = (height / undercoat.height.max().max(1e-6)).min(1.0);
    (undercoat.tangent_jitter * t.powf(undercoat.jitter_exponent)).powi(2) / 3.0
}

/// Depth of fur that a fin represents relative to that of its texture, for fins on edges of these
/// lengths in cm.
pub(crate) fn fin_depth(
    shells: &Shells,
    manifest: &Manifest,
    lengths: impl ExactSizeIterator<Item = f32>,
) -> f32 {
    if !shells.slanted {
        return 1.0;
    }
    let count = lengths.len().max(1);
    let mean = lengths.map(f64::from).sum::<f64>() / count as f64;
    FIN_SPACING * mean as f32 / manifest.fin_depth
}

/// Loads the textures that the scene names, or else bakes those that it describes, spread over
/// `shells.layers` if that is more than they have.
///
/// # Errors
/// [`Error::Scene`] or [`Error::Io`] if the named files are missing or damaged, and the errors of
/// [`crate::bake::bake`].
pub fn textures(world: &World) -> Result<FurTextures> {
    let textures = match &world.textures {
        Some(manifest) => crate::bake::load(manifest)?,
        None => crate::bake::bake(world)?,
    };
    // Fewer shells than layers are the inner ones; for more, the layers are spread over them.
    let wanted = world.scene.shells.layers.unwrap_or(0);
    Ok(if wanted > textures.manifest.layers { spread(&textures, wanted) } else { textures })
}

impl<'g> Shellfins<'g> {
    /// Maps `textures` to the skin and uploads everything that is constant over frames. `frame` is
    /// the first view, for which the light on the skin is computed.
    ///
    /// # Errors
    /// [`Error::Scene`] if the mapping needs uv and the skin has none; [`Error::OutOfMemory`],
    /// [`Error::Gpu`].
    pub fn new(
        gpu: &'g Gpu,
        world: &'g World,
        textures: &FurTextures,
        frame: &Frame,
        timings: &mut Timings,
    ) -> Result<Self> {
        let scene = &world.scene;
        let shells = &scene.shells;
        let skin = &world.skin;
        let prepared = Prepared::new(gpu, world, frame, timings)?;
        let mut overlapping = Overlapping::default();
        let corner_uv = match shells.mapping {
            Mapping::Lapped => {
                let lapped = lapped::lap(skin, scene)?;
                if scene.lapped.overlapping {
                    overlapping = Overlapping::new(skin, &lapped);
                }
                lapped.corner_uv
            }
            Mapping::Uv => uv_in_cm(skin).ok_or_else(|| {
                Error::fault(
                    "shells.mapping",
                    "found \"uv\", but the mesh has no uv: use \"lapped\", or add uv to the mesh",
                )
            })?,
        };
        let mut corners = corners(skin, &corner_uv);
        // With overlapping patches, shells have their own corners after those of the skin.
        let first_corner = if overlapping.points == 0 { 0 } else { corners.len() };
        corners.append(&mut overlapping.corners);
        let shell_triangles = ((corners.len() - first_corner) / 3) as u32;
        let mut outlines = overlapping.outlines;
        outlines.resize(outlines.len().max(1), glam::Vec2::ZERO);
        let fin_edges = edges(skin);
        let mut brushes: Vec<Brush> = shells
            .brushes
            .iter()
            .map(|b| Brush {
                center: b.center,
                radius: b.radius,
                direction: b.direction,
                tint: b.tint,
                ..Brush::zeroed()
            })
            .collect();
        let strokes = brushes.len() as u32;
        // A binding needs at least one element.
        brushes.resize(brushes.len().max(1), Brush::zeroed());
        let manifest = &textures.manifest;
        let hybrid = manifest.source == BakeSource::Hybrid;
        let brightest = world
            .lights
            .iter()
            .max_by(|a, b| a.irradiance.element_sum().total_cmp(&b.irradiance.element_sum()));
        let base = Shellfin {
            comb: shells.comb,
            fin_rows: FIN_ROWS,
            shadow_direction: brightest.map_or(Vec3::Y, |l| l.direction).into(),
            lighting: u32::from(shells.lighting == ShellLighting::Table),
            torus: manifest.patch,
            fin_length: manifest.fin_length,
            height: shells.spacing.map_or(manifest.height, |s| s * manifest.layers as f32),
            fade: match shells.fade {
                FinFade::Cosine => 0,
                FinFade::Threshold => 1,
                FinFade::Both => 2,
            },
            fin_threshold: shells.fin_threshold,
            slanted: u32::from(shells.slanted),
            shadow_offset: shells.shadow.offset,
            shadow_strength: shells.shadow.strength,
            vertices: skin.positions.len() as u32,
            brushes: strokes,
            curved: u32::from(hybrid),
            spread: scene.guard.spread.to_radians().tan(),
            guard: u32::from(!textures.guard.is_empty()),
            edge_fade: f32::from(u8::from(shells.slanted && shells.fins)),
            first_corner: first_corner as u32,
            ..Shellfin::zeroed()
        };
        let (low, high) = skin.bounds();
        let buffers = vec![
            gpu.upload("fur_corners", 4, &corners)?,
            gpu.upload("fin_edges", 4, &fin_edges)?,
            gpu.upload("outlines", 4, &outlines)?,
            gpu.upload("brushes", 3, &brushes)?,
            gpu.upload("vertex_uv", 3, &pelage_fur::surface::vertex_uv(skin))?,
            gpu.uniform("lighting_table", &lighting_table(&shells.table))?,
        ];
        let uses = Uses {
            guard: base.guard == 1,
            detail: shells.lod.enabled,
            shadow: shells.shadow.strength > 0.0,
            outline: overlapping.points,
            mapped: !matches!(
                (&shells.color, &shells.length),
                (Color::Constant([1.0, 1.0, 1.0]), Scalar::Constant(_))
            ),
            coats: prepared.variant.coats,
        };
        let fin_depth = fin_depth(shells, manifest, geometry::lengths(skin, &fin_edges));
        let fins = deepened(textures, fin_depth);
        let (uploaded, means) = textures::upload(gpu, textures, fins)?;
        Ok(Self {
            gpu,
            world,
            pass_rows: ShellfinRows::new(gpu, prepared.variant)?,
            prepared,
            pass_raster: ShellfinRaster::new(gpu, uses)?,
            textures: uploaded,
            means,
            layers: textures.layers.len() as u32,
            base,
            buffers,
            fin_depth,
            shell_triangles,
            edges: if shells.fins { fin_edges.len() as u32 } else { 0 },
            bounds: (0.5 * (low + high), (high - low).length()),
        })
    }

    /// The prepared skin with the light in its fur.
    pub fn prepared(&self) -> &Prepared<'g> {
        &self.prepared
    }

    /// Height of the fur where `shells.length` is 1, cm.
    pub fn height(&self) -> f32 {
        self.base.height
    }

    /// Number of edges that may carry fins; 0 without fins.
    pub fn edges(&self) -> u32 {
        self.edges
    }

    /// A buffer that is constant over frames: `fur_corners`, `fin_edges`, `outlines`, `brushes`,
    /// `vertex_uv`.
    pub fn buffer(&self, name: &str) -> Option<&Buffer> {
        self.buffers.iter().find(|b| b.name == name)
    }

    /// Places and lights the rows of vertices above the skin for a view.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if the rows do not fit a binding, [`Error::Gpu`].
    pub fn rows(&self, frame: &Frame, pose: &Pose, timings: &mut Timings) -> Result<Rows> {
        let gpu = self.gpu;
        let shells = &self.world.scene.shells;
        let distance = (Vec3::from(frame.eye) - self.bounds.0).length() / self.bounds.1.max(1e-6);
        let drawn = if shells.shells { shells.layers.unwrap_or(self.layers).min(self.layers) } else { 0 };
        let source = if self.base.curved == 1 { BakeSource::Hybrid } else { BakeSource::Particles };
        let jitter = |height: f32| stray_variance(self.world, source, height * self.base.height);
        let all = rows(shells, self.layers, drawn, distance, &self.means, &jitter);
        let count = all.len() as u32;
        let bend = pose.by_height(self.base.height).into();
        let shellfin = Shellfin { bend, shells: count - FIN_ROWS, ..self.base };
        let elements = u64::from(count) * u64::from(self.base.vertices);
        let buffers = [
            gpu.uniform("shellfin", &shellfin)?,
            gpu.upload("shell_rows", 3, &all)?,
            gpu.storage("row_positions", 3, elements * 16)?,
            gpu.storage("row_lights", 3, elements * 16)?,
        ];
        let frame = gpu.uniform("frame", frame)?;
        let scope = self.scope().with(&buffers.each_ref()).with(&[&frame]);
        let mut recorder = Recorder::new(gpu);
        self.pass_rows.record(&mut recorder, &scope, count, self.base.vertices)?;
        recorder.submit(timings)?;
        let draws = Draws {
            triangles: self.prepared.triangles,
            edges: self.edges,
            fin_rows: FIN_ROWS,
            shells: shellfin.shells,
            shell_triangles: self.shell_triangles,
            depth_write: shells.depth_write,
        };
        Ok(Rows { shellfin, rows: all, draws, buffers })
    }

    /// Draws a frame with the rows of its view.
    ///
    /// # Errors
    /// [`Error::Gpu`], [`Error::DeviceLost`].
    pub fn draw(
        &self,
        frame: &Buffer,
        rows: &Rows,
        targets: &RasterTargets<'_>,
        timings: &mut Timings,
    ) -> Result<()> {
        let scope = self.scope().with(&rows.buffers.each_ref()).with(&[frame]);
        let mut recorder = Recorder::new(self.gpu);
        self.pass_raster.record(&mut recorder, &scope, targets, &rows.draws)?;
        recorder.submit(timings)
    }

    /// All resources that are constant over frames, by name.
    pub fn scope(&self) -> Scope<'_> {
        self.prepared
            .rows_scope()
            .with(&self.buffers.iter().collect::<Vec<_>>())
            .and("layers", Resource::Texture(&self.textures.layers))
            .and("guard_layers", Resource::Texture(&self.textures.guard))
            .and("fin", Resource::Texture(&self.textures.fin))
            .and("repeating", Resource::Sampler(&self.textures.repeating))
            .and("upright", Resource::Sampler(&self.textures.upright))
    }
}

impl Rows {
    /// A buffer by name: `shellfin`, `shell_rows`, `row_positions`, `row_lights`.
    pub fn buffer(&self, name: &str) -> Option<&Buffer> {
        self.buffers.iter().find(|b| b.name == name)
    }
}
