//! `pelage bench`: time and memory in the rows of Andersen et al. 2016, Table 1, and comparisons of
//! methods for the same fur.
//!
//! All renderings use one open device. Compilation and the first dispatch of each kernel come
//! before the measurement and are reported separately. The renderer has no special path for the
//! bench, which loads a [`World`] and calls [`pelage_shells::render_on`].

pub mod paper;
pub mod shells;
pub mod sweep;

use crate::provenance::{Provenance, only_files_missing, repository_path, say, write_json};
use pelage_core::assets::Assets;
use pelage_core::scene::{Blend, Storage};
use pelage_core::stats::Stats;
use pelage_core::{Error, Result, Scene, World};
use pelage_gpu::Gpu;
use pelage_render::RenderOptions;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;
use sweep::{Subtable, Sweep};

/// Scenes of the paper's table.
const SCENES: [&str; 3] = ["scenes/cylinder.toml", "scenes/hat.toml", "scenes/bunny.toml"];
/// Default image sizes; the second is the paper's.
const SIZES: [[u32; 2]; 2] = [[1024, 1024], [3840, 2274]];

/// A small scene that runs every kernel once.
const WARM_UP: &str = r#"
[mesh]
shape = "plane"
[[lights]]
[guard]
density = 2
[undercoat]
density = 500
layers = 2
subdivision = 0
[film]
width = 16
height = 16
spp = 1
"#;

/// Settings of a measurement.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Scene files; empty: cylinder, hat and bunny.
    pub scenes: Vec<PathBuf>,
    /// Image sizes; empty: 1024x1024 and 3840x2274.
    pub sizes: Vec<[u32; 2]>,
    /// Renderings of each scene; at least 1.
    pub runs: u32,
    /// GPU memory budget, bytes; `None`: the scene's.
    pub memory: Option<u64>,
    /// JSON file for the results.
    pub json: Option<PathBuf>,
    /// Comparisons to measure instead of the table.
    pub sweeps: Vec<Sweep>,
}

/// Smallest and median of several runs, ms.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Times {
    /// Smallest.
    pub min: f64,
    /// Median; for an even number of runs the mean of the middle two.
    pub median: f64,
}

impl Times {
    /// The times of all runs; `None` if a run has no time.
    pub fn of(runs: impl Iterator<Item = Option<f64>>) -> Option<Self> {
        let mut all: Vec<f64> = runs.collect::<Option<_>>()?;
        all.sort_by(f64::total_cmp);
        let middle = all.get(all.len() / 2)? + all.get((all.len() - 1) / 2)?;
        Some(Self { min: all[0], median: 0.5 * middle })
    }
}

/// A row of the table.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// 1..=7.
    pub step: u32,
    /// Name as in the paper.
    pub name: String,
    /// GPU time; `None` if the adapter has no timestamps.
    pub ms: Option<Times>,
    /// Largest size of its buffers, bytes.
    pub bytes: u64,
}

/// One scene at one size.
#[derive(Debug, Clone, Serialize)]
pub struct Column {
    /// Name of the scene file without folder and extension.
    pub scene: String,
    /// Steps 1 to 7.
    pub rows: Vec<Row>,
    /// GPU time of steps 1 to 3.
    pub preprocessing_ms: Option<Times>,
    /// GPU time of steps 4 to 7.
    pub online_ms: Option<Times>,
    /// GPU time of all steps.
    pub total_ms: Option<Times>,
    /// Wall-clock time of the whole call, with uploads, read-back and work on the CPU.
    pub wall_ms: Times,
    /// Bytes of all steps together.
    pub total_bytes: u64,
    /// Most bytes allocated at once.
    pub peak_bytes: u64,
    /// The paper's column for this scene, at 3840 x 2274.
    pub paper: Option<paper::Column>,
    /// Counts of the last run.
    pub stats: Stats,
}

/// Results of a measurement.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// Adapter, driver, version, date, command.
    pub provenance: Provenance,
    /// Time to open the device, compile all passes and run each once, ms.
    pub compile_ms: f64,
    /// Runs of each scene.
    pub runs: u32,
    /// The table.
    pub table: Vec<Column>,
    /// Comparisons.
    pub sweeps: Vec<Subtable>,
    /// Scenes that could not be measured, and why.
    pub skipped: Vec<Skipped>,
}

/// A scene that could not be measured.
#[derive(Debug, Clone, Serialize)]
pub struct Skipped {
    /// The scene.
    pub scene: String,
    /// The reason.
    pub reason: String,
}

/// Measures, prints the results as Markdown to stdout, and writes the JSON file if one is set.
///
/// # Errors
/// Those of [`measure`]; [`Error::Io`] if the JSON file cannot be written.
pub fn run(options: &Options) -> Result<()> {
    let report = measure(options, &mut |text| say(text))?;
    match &options.json {
        Some(path) => write_json(path, &report),
        None => Ok(()),
    }
}

/// Measures; `print` receives each part as Markdown as soon as it is complete. A scene whose mesh
/// or map is missing is reported and skipped.
///
/// # Errors
/// [`Error::Usage`] if a scene file does not exist, [`Error::Scene`] if it is not valid, and those
/// of [`pelage_shells::render_on`].
pub fn measure(options: &Options, print: &mut dyn FnMut(&str) -> Result<()>) -> Result<Report> {
    let started = Instant::now();
    let gpu = pelage_render::open()?;
    warm_up(&gpu)?;
    let mut report = Report {
        provenance: Provenance::of(&gpu),
        compile_ms: started.elapsed().as_secs_f64() * 1e3,
        runs: options.runs.max(1),
        table: Vec::new(),
        sweeps: Vec::new(),
        skipped: Vec::new(),
    };
    let p = &report.provenance;
    print(&format!(
        "{} ({}, {}), pelage {}, {}; device and kernels ready after {:.0} ms; {} run(s) each\n",
        p.adapter, p.backend, p.driver, p.version, p.date, report.compile_ms, report.runs
    ))?;
    let scenes = match &options.scenes[..] {
        [] => SCENES.iter().map(|s| repository_path(s)).collect::<Result<Vec<_>>>()?,
        given => given.to_vec(),
    };
    if !options.sweeps.is_empty() {
        let size = options.sizes.first().copied();
        for path in scenes.iter().take(options.scenes.len().max(1)) {
            let Some(world) = load(path, size.unwrap_or(sweep::SIZE), options.memory, &mut report, print)?
            else {
                continue;
            };
            for kind in &options.sweeps {
                let table = kind.measure(&gpu, &world, &name_of(path), report.runs)?;
                print(&table.markdown())?;
                report.sweeps.push(table);
            }
        }
        return Ok(report);
    }
    let sizes = if options.sizes.is_empty() { &SIZES[..] } else { &options.sizes };
    for path in &scenes {
        for size in sizes {
            let Some(world) = load(path, *size, options.memory, &mut report, print)? else { break };
            let column = Column::measure(&gpu, &world, &name_of(path), report.runs)?;
            print(&column.markdown())?;
            report.table.push(column);
        }
    }
    Ok(report)
}

/// Renders a small scene in every blending mode, with densities stored and evaluated, because some
/// drivers compile at the first dispatch.
fn warm_up(gpu: &Gpu) -> Result<()> {
    let scene = Scene::parse(WARM_UP, "warm-up", &[])?;
    let mut world = World::load(scene, &Assets::default())?;
    for storage in [Storage::Stored, Storage::Evaluated] {
        for blend in [Blend::Exact, Blend::Virtual, Blend::Simplified] {
            world.scene.render.blend = blend;
            world.scene.undercoat.storage = storage;
            pelage_shells::render_on(gpu, &world, &RenderOptions::default())?;
        }
    }
    Ok(())
}

/// Loads a scene at one sample a pixel of `size`; `None`, noted in `report`, if a file that it
/// names is missing.
fn load(
    path: &Path,
    size: [u32; 2],
    memory: Option<u64>,
    report: &mut Report,
    print: &mut dyn FnMut(&str) -> Result<()>,
) -> Result<Option<World>> {
    match load_world(path, &overrides(size, memory)) {
        Ok(world) => Ok(Some(world)),
        Err(e) if only_files_missing(&e) => {
            print(&format!("\n{}: skipped: {e}\n", name_of(path)))?;
            report.skipped.push(Skipped { scene: name_of(path), reason: e.to_string() });
            Ok(None)
        }
        Err(e) => Err(e),
    }
}

/// Overrides for one sample a pixel of `size`, and for a memory budget.
fn overrides([width, height]: [u32; 2], memory: Option<u64>) -> Vec<String> {
    let mut all = vec![format!("film.width={width}"), format!("film.height={height}"), "film.spp=1".into()];
    all.extend(memory.map(|bytes| format!("render.memory={bytes}")));
    all
}

fn load_world(path: &Path, overrides: &[String]) -> Result<World> {
    if !path.is_file() {
        return Err(Error::Usage(format!("{}: no such scene file", path.display())));
    }
    let (scene, assets) = Scene::load(path, overrides)?;
    World::load(scene, &assets)
}

/// The name of a scene or mesh: its file name without extension.
fn name_of(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

/// Renders a world `runs` times.
///
/// # Errors
/// Those of [`pelage_shells::render_on`].
pub fn repeat(gpu: &Gpu, world: &World, runs: u32) -> Result<Vec<Stats>> {
    (0..runs.max(1))
        .map(|_| {
            gpu.ledger.reset_peaks();
            Ok(pelage_shells::render_on(gpu, world, &RenderOptions::default())?.stats)
        })
        .collect()
}

/// GPU time of the chosen steps, ms; `None` if one has no time.
pub(crate) fn steps_ms(stats: &Stats, chosen: &[u32]) -> Option<f64> {
    stats.steps.iter().filter(|s| chosen.contains(&s.step)).map(|s| s.ms).sum()
}

/// Smallest and median GPU time of the chosen steps.
fn time_of_steps(runs: &[Stats], chosen: &[u32]) -> Option<Times> {
    Times::of(runs.iter().map(|stats| steps_ms(stats, chosen)))
}

impl Column {
    /// Measures `world`, called `name`.
    ///
    /// # Errors
    /// Those of [`pelage_shells::render_on`].
    pub fn measure(gpu: &Gpu, world: &World, name: &str, runs: u32) -> Result<Self> {
        let all = repeat(gpu, world, runs)?;
        let last = all.last().cloned().unwrap_or_default();
        let rows: Vec<Row> = last
            .steps
            .iter()
            .map(|s| Row {
                step: s.step,
                name: s.name.clone(),
                ms: time_of_steps(&all, &[s.step]),
                bytes: s.bytes,
            })
            .collect();
        let wall = Times::of(all.iter().map(|s| Some(s.total_ms)));
        Ok(Self {
            scene: name.to_owned(),
            preprocessing_ms: time_of_steps(&all, &[1, 2, 3]),
            online_ms: time_of_steps(&all, &[4, 5, 6, 7]),
            total_ms: time_of_steps(&all, &[1, 2, 3, 4, 5, 6, 7]),
            wall_ms: wall.unwrap_or(Times { min: 0.0, median: 0.0 }),
            total_bytes: rows.iter().map(|r| r.bytes).sum(),
            peak_bytes: last.gpu_peak_bytes,
            paper: paper::column(name).copied(),
            rows,
            stats: last,
        })
    }

    /// The column as a Markdown table, beside the paper's figures.
    pub fn markdown(&self) -> String {
        let s = &self.stats;
        let mut text = format!(
            "\n{}, {} x {}, 1 spp, {} ({}): {} triangles, {} strands, {} fragments, {} dropped, {} tile(s), undercoat {}\n\n",
            self.scene,
            s.width,
            s.height,
            s.fur,
            s.blend,
            s.triangles,
            s.strands,
            s.fragments,
            s.fragments_dropped,
            s.tiles,
            s.storage
        );
        text += "|   | step                               |    min, ms | median, ms |  paper, ms |   memory, MiB | paper, MiB |\n";
        text += "|---|------------------------------------|-----------:|-----------:|-----------:|--------------:|-----------:|\n";
        let mut line = |step: &str,
                        name: &str,
                        ms: Option<Times>,
                        paper_ms: Option<f64>,
                        bytes: Option<u64>,
                        gb: Option<f64>| {
            text += &format!(
                "| {step:1} | {name:34} | {} | {} | {} | {} | {} |\n",
                cell(ms.map(|t| t.min), 10, 1),
                cell(ms.map(|t| t.median), 10, 1),
                paper_ms.map_or_else(|| " ".repeat(10), |ms| cell(Some(ms), 10, 1)),
                bytes.map_or_else(|| " ".repeat(13), |b| cell(Some(mebibytes(b)), 13, 1)),
                gb.map_or_else(|| " ".repeat(10), |gb| cell(Some(gb * 1e9 / MEBIBYTE), 10, 0)),
            );
        };
        let paper = self.paper;
        for (i, row) in self.rows.iter().enumerate() {
            let (ms, gb) = (paper.map(|p| p.ms[i]), paper.and_then(|p| p.gigabytes[i]));
            line(&row.step.to_string(), &row.name, row.ms, ms, Some(row.bytes), gb);
        }
        let total = paper.map(|p| p.preprocessing_ms + p.online_ms);
        line(
            "",
            "pre-processing (1-3)",
            self.preprocessing_ms,
            paper.map(|p| p.preprocessing_ms),
            None,
            None,
        );
        line("", "online (4-7)", self.online_ms, paper.map(|p| p.online_ms), None, None);
        line(
            "",
            "total, total memory",
            self.total_ms,
            total,
            Some(self.total_bytes),
            paper.map(|p| p.total_gigabytes),
        );
        line("", "wall time, most memory at once", Some(self.wall_ms), None, Some(self.peak_bytes), None);
        text
    }
}

const MEBIBYTE: f64 = (1 << 20) as f64;

pub(crate) fn mebibytes(bytes: u64) -> f64 {
    bytes as f64 / MEBIBYTE
}

/// A number, or `n/a`, right-aligned in `width` characters.
fn cell(value: Option<f64>, width: usize, digits: usize) -> String {
    match value {
        Some(v) => format!("{v:>width$.digits$}"),
        None => format!("{:>width$}", "n/a"),
    }
}
