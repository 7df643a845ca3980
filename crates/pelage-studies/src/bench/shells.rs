//! `pelage bench --shells`: frames per second of shells and fins, beside those of Lengyel et al.
//! 2001, and the growth of the cost with layers and triangles.
//!
//! A frame is all that is computed for a new view: placing and lighting the rows of vertices, and
//! drawing skin, fins and shells. Nothing is read back, and no film is filtered. The program waits
//! for the device after the rows and after the picture, so that short frames measure latency; the
//! time of a frame without its passes is in the column "rest".

use super::{Skipped, Times, cell, load_world, name_of, overrides, paper};
use crate::provenance::{Provenance, only_files_missing, say, write_json};
use glam::Vec2;
use pelage_core::assets::Assets;
use pelage_core::{Error, Result, Scene, World};
use pelage_fur::camera;
use pelage_gpu::Gpu;
use pelage_gpu::recorder::Timings;
use pelage_shells::shellfin::{self, Pictures, Pose, Shellfins};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Default image size.
pub const SIZE: [u32; 2] = [640, 480];
/// Default numbers of layers.
pub const LAYERS: [u32; 5] = [4, 8, 16, 32, 64];
/// Default meshes, relative to the asset folders; all tables use the first.
const MESHES: [&str; 4] =
    ["meshes/bunny-5k.obj", "meshes/spot.obj", "meshes/spot-23k.obj", "meshes/stanford-bunny.obj"];
/// Frames before the measurement.
const WARM_UP: u32 = 2;

/// The scene of a mesh, with the layers, textures and lighting of Lengyel et al. 2001. The fur's
/// height is a fiftieth of the body.
const SCENE: &str = r#"
[mesh]
size = 10
center = true
[camera]
eye = [4, 3, 29]
fov = 26
[[lights]]
direction = [0.5, 0.8, 0.6]
irradiance = [2.5, 2.4, 2.3]
[bake]
source = "particles"
layers = 16
resolution = [128, 128]
fin_resolution = [512, 64]
height = 0.2
[shells]
lighting = "table"
"#;

/// Settings of a measurement.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Scene files; empty: a furry bunny, and other meshes to measure the growth with triangles.
    pub scenes: Vec<PathBuf>,
    /// Image size; `None`: 640x480.
    pub size: Option<[u32; 2]>,
    /// Frames of each fur; at least 1.
    pub runs: u32,
    /// Numbers of layers to compare; empty: 4, 8, 16, 32, 64.
    pub layers: Vec<u32>,
    /// GPU memory budget, bytes; `None`: the scene's.
    pub memory: Option<u64>,
    /// JSON file for the results.
    pub json: Option<PathBuf>,
}

/// Frames per second.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rate {
    /// Of the fastest frame.
    pub best: f64,
    /// Of the median frame.
    pub median: f64,
}

/// Measurements of one fur.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    /// The scene.
    pub scene: String,
    /// Triangles of the skin.
    pub triangles: u32,
    /// Edges that may carry fins.
    pub edges: u32,
    /// Number of shells drawn.
    pub shells: u32,
    /// Height of the fur, cm.
    pub height: f32,
    /// Height for which its textures were baked, cm.
    pub baked_height: f32,
    /// Frames per second, wall-clock.
    pub fps: Rate,
    /// Wall-clock time of a frame.
    pub frame_ms: Times,
    /// GPU time to place and light the rows of vertices; `None`, as for the next three, if the
    /// adapter has no timestamps.
    pub rows_ms: Option<Times>,
    /// GPU time of the skin.
    pub skin_ms: Option<Times>,
    /// GPU time of the fins.
    pub fins_ms: Option<Times>,
    /// GPU time of the shells.
    pub shells_ms: Option<Times>,
    /// Time of a frame outside its passes: uploads, bindings, waiting.
    pub rest_ms: Option<Times>,
    /// Once, before the first frame: time to bake or read the textures, ms.
    pub textures_ms: f64,
    /// Once: time to lay them on the skin, light the fur, upload and compile, ms.
    pub laying_ms: f64,
    /// Most bytes allocated on the device at once.
    pub peak_bytes: u64,
}

/// Results of a measurement.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// Adapter, driver, version, date, command.
    pub provenance: Provenance,
    /// Pixels, one sample each.
    pub size: [u32; 2],
    /// Frames of each fur.
    pub runs: u32,
    /// The paper's bunny.
    pub paper: paper::Rates,
    /// For each scene: all layers, then half of them.
    pub frames: Vec<Row>,
    /// The first scene with each number of layers, over the same height.
    pub layers: Vec<Row>,
    /// All scenes with all layers, by number of triangles; empty for one scene.
    pub triangles: Vec<Row>,
    /// Furs that could not be measured.
    pub skipped: Vec<Skipped>,
}

/// Measures, prints the results as Markdown to stdout, and writes the JSON file if one is set.
///
/// # Errors
/// Those of [`measure`]; [`Error::Io`] if the JSON file cannot be written.
pub fn run(options: &Options) -> Result<()> {
    let report = measure(options, &mut |text| say(text))?;
    options.json.as_ref().map_or(Ok(()), |path| write_json(path, &report))
}

/// Measures; `print` receives each part as Markdown as soon as it is complete. A scene whose mesh
/// or map is missing, and a fur that does not fit the device, are reported and skipped.
///
/// # Errors
/// [`Error::Usage`] if a scene file does not exist, [`Error::Scene`] if it is not valid; those of
/// [`shellfin::textures`], [`Shellfins::new`] and [`Shellfins::draw`], except
/// [`Error::OutOfMemory`].
pub fn measure(options: &Options, print: &mut dyn FnMut(&str) -> Result<()>) -> Result<Report> {
    let gpu = pelage_render::open()?;
    let size = options.size.unwrap_or(SIZE);
    let mut report = Report {
        provenance: Provenance::of(&gpu),
        size,
        runs: options.runs.max(1),
        paper: paper::LENGYEL_BUNNY,
        frames: Vec::new(),
        layers: Vec::new(),
        triangles: Vec::new(),
        skipped: Vec::new(),
    };
    let p = &report.provenance;
    print(&format!(
        "{} ({}, {}), pelage {}, {}; {} x {}, 1 spp, {} frame(s) each\n\
         The program waits for the device twice a frame: short frames measure latency.\n",
        p.adapter, p.backend, p.driver, p.version, p.date, size[0], size[1], report.runs
    ))?;
    let worlds = worlds(options, size, &mut report.skipped)?;
    for skipped in &report.skipped {
        print(&format!("\n{}: skipped: {}\n", skipped.scene, skipped.reason))?;
    }
    let counts = if options.layers.is_empty() { &LAYERS[..] } else { &options.layers };
    // The meshes after the first only serve to measure the growth with triangles.
    let halved = if options.scenes.is_empty() { 1 } else { worlds.len() };
    for (i, (name, world)) in worlds.iter().enumerate() {
        let Some(all) = report.row(&gpu, world, name, print)? else { continue };
        report.triangles.push(all.clone());
        if i >= halved {
            continue;
        }
        let half = all.with_layers(world, (all.shells / 2).max(1));
        let half = report.row(&gpu, &half, name, print)?;
        let found: Vec<Row> = std::iter::once(all.clone()).chain(half).collect();
        print(&table(&format!("{name}: all layers, and half of them"), &found, Some(report.paper)))?;
        report.frames.extend(found);
        if i == 0 {
            for count in counts {
                if world.textures.is_some() && *count > all.shells {
                    let reason = format!("{count} layers: its textures have {}", all.shells);
                    print(&format!("\n{name}: skipped: {reason}\n"))?;
                    report.skipped.push(Skipped { scene: name.clone(), reason });
                    continue;
                }
                let row = report.row(&gpu, &all.with_layers(world, *count), name, print)?;
                report.layers.extend(row);
            }
            print(&table(&format!("{name}: growth with layers"), &report.layers, None))?;
        }
    }
    if report.triangles.len() > 1 {
        report.triangles.sort_by_key(|row| row.triangles);
        print(&table("growth with triangles", &report.triangles, None))?;
    } else {
        report.triangles.clear();
    }
    Ok(report)
}

/// The furs to measure, by name, at one sample a pixel.
fn worlds(options: &Options, size: [u32; 2], skipped: &mut Vec<Skipped>) -> Result<Vec<(String, World)>> {
    let mut overrides = overrides(size, options.memory);
    overrides.push("render.fur=shells".into());
    let of_mesh = |key: &str, value: &str| {
        let all: Vec<String> = overrides.iter().cloned().chain([format!("mesh.{key}={value}")]).collect();
        let scene = Scene::parse(SCENE, "bench", &all)?;
        World::load(scene, &Assets::of_folder(Path::new(".")))
    };
    let mut found = Vec::new();
    let mut take = |name: String, world: Result<World>| match world {
        Ok(world) => {
            found.push((name, world));
            Ok(())
        }
        Err(e) if only_files_missing(&e) => {
            skipped.push(Skipped { scene: name, reason: e.to_string() });
            Ok(())
        }
        Err(e) => Err(e),
    };
    for path in &options.scenes {
        take(name_of(path), load_world(path, &overrides))?;
    }
    if options.scenes.is_empty() {
        for mesh in MESHES {
            take(name_of(Path::new(mesh)), of_mesh("path", mesh))?;
        }
        // Without the bunny, a built-in shape takes its place.
        if !found.iter().any(|(name, _)| *name == name_of(Path::new(MESHES[0]))) {
            found.insert(0, ("critter".into(), of_mesh("shape", "critter")?));
        }
    }
    Ok(found)
}

impl Report {
    /// Measures a fur; `None`, noted in the report, if it does not fit the device.
    fn row(
        &mut self,
        gpu: &Gpu,
        world: &World,
        name: &str,
        print: &mut dyn FnMut(&str) -> Result<()>,
    ) -> Result<Option<Row>> {
        match Row::measure(gpu, world, name, self.runs) {
            Ok(row) => Ok(Some(row)),
            Err(e @ Error::OutOfMemory { .. }) => {
                print(&format!("\n{name}: skipped: {e}\n"))?;
                self.skipped.push(Skipped { scene: name.to_owned(), reason: e.to_string() });
                Ok(None)
            }
            Err(e) => Err(e),
        }
    }
}

impl Row {
    /// Draws `runs` frames of `world`, called `name`.
    ///
    /// # Errors
    /// Those of [`shellfin::textures`], [`Shellfins::new`], [`Shellfins::rows`] and
    /// [`Shellfins::draw`].
    pub fn measure(gpu: &Gpu, world: &World, name: &str, runs: u32) -> Result<Self> {
        let scene = &world.scene;
        let size = [scene.film.width, scene.film.height];
        gpu.ledger.reset_peaks();
        let started = Instant::now();
        let textures = shellfin::textures(world)?;
        let textures_ms = milliseconds(started);
        let started = Instant::now();
        let view = camera::frame(&scene.camera, size, Vec2::ZERO, Vec2::ZERO, scene.render.seed);
        let fur = Shellfins::new(gpu, world, &textures, &view, &mut Timings::default())?;
        let laying_ms = milliseconds(started);
        let pictures = Pictures::new(gpu, size)?;
        let pose = Pose::at(world, 0.0, fur.height());
        let one = || -> Result<(f64, u32, Timings)> {
            let started = Instant::now();
            let mut timings = Timings::default();
            let rows = fur.rows(&view, &pose, &mut timings)?;
            let frame = gpu.uniform("frame", &view)?;
            fur.draw(&frame, &rows, &pictures.targets(size), &mut timings)?;
            Ok((milliseconds(started), rows.draws.shells, timings))
        };
        for _ in 0..WARM_UP {
            one()?;
        }
        let frames = (0..runs.max(1)).map(|_| one()).collect::<Result<Vec<_>>>()?;
        // A pass that was not drawn took no time.
        let pass = |timings: &Timings, label: &str| timings.passes.get(label).map_or(Some(0.0), |p| p.0);
        let of = |label: &str| Times::of(frames.iter().map(|(_, _, t)| pass(t, label)));
        let rest = |ms: f64, timings: &Timings| {
            let passes: Option<f64> = timings.passes.values().map(|p| p.0).sum();
            passes.map(|passes| (ms - passes).max(0.0))
        };
        let frame_ms = Times::of(frames.iter().map(|f| Some(f.0))).unwrap_or(Times { min: 0.0, median: 0.0 });
        Ok(Self {
            scene: name.to_owned(),
            triangles: world.skin.triangles.len() as u32,
            edges: fur.edges(),
            shells: frames.last().map_or(0, |f| f.1),
            height: fur.height(),
            baked_height: textures.manifest.height,
            fps: Rate { best: 1e3 / frame_ms.min.max(1e-6), median: 1e3 / frame_ms.median.max(1e-6) },
            frame_ms,
            rows_ms: of("shellfin_rows.main"),
            skin_ms: of("shellfin_raster.skin_vertex"),
            fins_ms: of("shellfin_raster.fin_vertex"),
            shells_ms: of("shellfin_raster.shell_vertex"),
            rest_ms: Times::of(frames.iter().map(|(ms, _, t)| rest(*ms, t))),
            textures_ms,
            laying_ms,
            peak_bytes: gpu.ledger.peak(),
        })
    }

    /// The world of this row with `layers` layers over the same height; of textures read from
    /// files, the innermost layers are drawn.
    pub(crate) fn with_layers(&self, world: &World, layers: u32) -> World {
        let mut world = world.clone();
        let scene = &mut world.scene;
        if world.textures.is_some() {
            scene.shells.layers = Some(layers);
        } else {
            scene.shells.layers = None;
            scene.shells.spacing = Some(self.height / layers as f32);
            scene.bake.layers = layers;
            scene.bake.height = Some(self.baked_height);
        }
        world
    }
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// Rows as a Markdown table, and the paper's rates if given.
fn table(title: &str, rows: &[Row], paper: Option<paper::Rates>) -> String {
    let mut text = format!("\n{title}; times are medians, ms\n\n");
    text += "| scene              | triangles | shells | fps, median |  fps, best |  frame |   rows |   skin |   fins | shells |   rest | textures, once | laying, once |\n";
    text += "|--------------------|----------:|-------:|------------:|-----------:|-------:|-------:|-------:|-------:|-------:|-------:|---------------:|-------------:|\n";
    for row in rows {
        let parts = [row.rows_ms, row.skin_ms, row.fins_ms, row.shells_ms, row.rest_ms];
        let parts = parts.map(|ms| format!("{} | ", cell(ms.map(|t| t.median), 6, 2))).concat();
        text += &format!(
            "| {:18} | {:>9} | {:>6} | {:>11.1} | {:>10.1} | {:>6.2} | {parts}{:>14.0} | {:>12.0} |\n",
            row.scene,
            row.triangles,
            row.shells,
            row.fps.median,
            row.fps.best,
            row.frame_ms.median,
            row.textures_ms,
            row.laying_ms,
        );
    }
    if let Some(p) = paper {
        text += &format!(
            "\nLengyel et al. 2001, Table 1, {}: {} triangles, {} layers: {} fps, half of them: {} fps, on a GeForce DDR and an AMD K7 of \
             700 MHz.\n",
            p.model, p.triangles, p.layers, p.fps_all, p.fps_half
        );
    }
    text
}
