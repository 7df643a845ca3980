//! Comparisons: the same fur with different methods or amounts.

use super::{MEBIBYTE, Times, cell, mebibytes, repeat, steps_ms};
use pelage_core::scene::{Blend, FurLayers, Scalar, Storage};
use pelage_core::stats::Stats;
use pelage_core::{Error, Result, World};
use pelage_gpu::Gpu;
use pelage_render::FRAGMENT_BYTES;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Default image size.
pub const SIZE: [u32; 2] = [960, 568];
/// Virtual fragments per ray in the comparison.
const VIRTUAL_FRAGMENTS: u32 = 30;
/// Deepest subdivision level of the comparison.
const DEEPEST: u32 = 6;

/// A kind of comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Sweep {
    /// Exact blending against 30 virtual fragments and the paper's equation 4.
    Blend,
    /// Time of the march for subdivision levels 0 to 6, densities stored and evaluated.
    Subdivision,
    /// 1, 2, 4, 8, 16 times the guard hairs, in the same memory.
    Strands,
}

/// Measurements of one variant.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// Name of the variant.
    pub label: String,
    /// GPU time of the compared steps; `None` if the adapter has no timestamps.
    pub ms: Option<Times>,
    /// Smallest time by that of the first row of the same group.
    pub ratio: Option<f64>,
    /// Bytes of all fragments.
    pub fragment_bytes: u64,
    /// The reason if the variant could not be measured.
    pub failed: Option<String>,
    /// Counts of the last run.
    pub stats: Option<Stats>,
}

/// Results of a comparison.
#[derive(Debug, Clone, Serialize)]
pub struct Subtable {
    /// Kind of comparison.
    pub sweep: Sweep,
    /// Title, with the steps whose time is compared.
    pub title: String,
    /// Name of the scene.
    pub scene: String,
    /// Pixels.
    pub size: [u32; 2],
    /// The variants.
    pub rows: Vec<Row>,
}

/// A world to render, its label, and whether it is the first of a group.
struct Variant {
    label: String,
    first: bool,
    world: World,
}

impl Sweep {
    /// Renders all variants of `world`, called `name`, `runs` times each. A variant that does not
    /// fit the memory has a row with the reason.
    ///
    /// # Errors
    /// Those of [`pelage_shells::render_on`], except [`Error::OutOfMemory`].
    pub fn measure(self, gpu: &Gpu, world: &World, name: &str, runs: u32) -> Result<Subtable> {
        let (title, variants) = match self {
            Self::Blend => ("blending; time of steps 4, 6 and 7".into(), blends(world)),
            Self::Subdivision => subdivisions(gpu, world),
            Self::Strands => ("number of guard hairs; time of steps 3, 6 and 7".into(), strands(world)),
        };
        let mut rows = Vec::new();
        let mut reference = None;
        for variant in variants {
            let row = match repeat(gpu, &variant.world, runs) {
                Ok(all) => {
                    let ms = Times::of(all.iter().map(|stats| self.time(stats)));
                    if variant.first {
                        reference = ms.map(|t| t.min);
                    }
                    let stats = all.last().cloned();
                    Row {
                        label: variant.label,
                        ms,
                        ratio: ms.zip(reference).map(|(t, first)| t.min / first),
                        fragment_bytes: stats.as_ref().map_or(0, |s| s.fragments * FRAGMENT_BYTES),
                        failed: None,
                        stats,
                    }
                }
                Err(e @ Error::OutOfMemory { .. }) => Row {
                    label: variant.label,
                    ms: None,
                    ratio: None,
                    fragment_bytes: 0,
                    failed: Some(e.to_string()),
                    stats: None,
                },
                Err(e) => return Err(e),
            };
            rows.push(row);
        }
        let film = &world.scene.film;
        Ok(Subtable { sweep: self, title, scene: name.to_owned(), size: [film.width, film.height], rows })
    }

    /// GPU time of the compared steps, ms.
    fn time(self, stats: &Stats) -> Option<f64> {
        match self {
            Self::Blend => steps_ms(stats, &[4, 6, 7]),
            Self::Strands => steps_ms(stats, &[3, 6, 7]),
            // Only the march: with undercoat alone, resolve does nothing else.
            Self::Subdivision => stats
                .passes
                .iter()
                .filter(|p| ["undercoat_march", "resolve"].iter().any(|stem| p.pass.starts_with(stem)))
                .map(|p| p.ms)
                .sum(),
        }
    }
}

fn blends(world: &World) -> Vec<Variant> {
    let with = |label: &str, blend| {
        let mut world = world.clone();
        world.scene.render.fur = FurLayers::Hybrid;
        world.scene.render.blend = blend;
        world.scene.render.virtual_fragments = VIRTUAL_FRAGMENTS;
        Variant { label: label.into(), first: blend == Blend::Exact, world }
    };
    vec![
        with("exact", Blend::Exact),
        with(&format!("virtual, {VIRTUAL_FRAGMENTS}"), Blend::Virtual),
        with("simplified (eq. 4)", Blend::Simplified),
    ]
}

/// Undercoat alone, with as many layers as can be stored at the deepest level.
fn subdivisions(gpu: &Gpu, world: &World) -> (String, Vec<Variant>) {
    let deepest = (world.skin.triangles.len().max(1) as u64) << (2 * DEEPEST);
    let fit = gpu.binding_limit().min(world.scene.render.memory / 2) / (4 * deepest);
    let layers = world.scene.undercoat.layers.min(u32::try_from(fit).unwrap_or(u32::MAX)).max(1);
    let mut variants = Vec::new();
    for (name, storage) in [("stored", Storage::Stored), ("evaluated", Storage::Evaluated)] {
        for d in 0..=DEEPEST {
            let mut world = world.clone();
            world.scene.render.fur = FurLayers::Implicit;
            world.scene.render.blend = Blend::Exact;
            world.scene.undercoat.subdivision = Some(d);
            world.scene.undercoat.layers = layers;
            world.scene.undercoat.storage = storage;
            variants.push(Variant { label: format!("{name}, d = {d}"), first: d == 0, world });
        }
    }
    (format!("subdivision level, undercoat alone, {layers} layers; time of the march"), variants)
}

/// Multiplies the density of the guard hairs.
pub(crate) fn multiply_strands(world: &mut World, factor: f32) {
    match &mut world.scene.guard.density {
        Scalar::Constant(density) => *density *= factor,
        Scalar::Mapped(map) => {
            map.value *= factor;
            map.offset *= factor;
        }
    }
}

fn strands(world: &World) -> Vec<Variant> {
    [1.0, 2.0, 4.0, 8.0, 16.0]
        .map(|factor: f32| {
            let mut world = world.clone();
            multiply_strands(&mut world, factor);
            Variant { label: format!("{factor} x"), first: factor == 1.0, world }
        })
        .into()
}

impl Subtable {
    /// The comparison as a Markdown table.
    pub fn markdown(&self) -> String {
        let [width, height] = self.size;
        let mut text = format!("\n{}, {width} x {height}, 1 spp: {}\n\n", self.scene, self.title);
        text += "|                    |   min, ms | median, ms | ratio |    strands |  fragments | fragments, MiB | peak, MiB | tiles |\n";
        text += "|--------------------|----------:|-----------:|------:|-----------:|-----------:|---------------:|----------:|------:|\n";
        for row in &self.rows {
            let Some(stats) = &row.stats else {
                let reason = row.failed.as_deref().unwrap_or_default();
                text += &format!("| {:18} | {reason} |\n", row.label);
                continue;
            };
            text += &format!(
                "| {:18} | {} | {} | {} | {:>10} | {:>10} | {:>14.1} | {:>9.1} | {:>5} |\n",
                row.label,
                cell(row.ms.map(|t| t.min), 9, 1),
                cell(row.ms.map(|t| t.median), 10, 1),
                cell(row.ratio, 5, 2),
                stats.strands,
                stats.fragments,
                row.fragment_bytes as f64 / MEBIBYTE,
                mebibytes(stats.gpu_peak_bytes),
                stats.tiles,
            );
        }
        text
    }
}
