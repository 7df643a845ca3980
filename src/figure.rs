//! The registry of paper figures: each is a folder of `paper_figures/` with a `figure.toml`, its scenes, and a caption.
//!
//! A figure is made with the calls that render any other picture. Its folder holds everything that is particular to it, so that
//! a new figure needs no code.

mod panel;

use crate::film::{Film, Metadata, composite, depth_of_field, io};
use crate::provenance::{Provenance, only_files_missing, repository_path, say, write_json};
use crate::render::{self, RenderOptions};
use crate::scene::{FilmSpec, Tonemap};
use crate::stats::Stats;
use crate::{Error, Result, Scene, World, bench, files, gpu::Gpu};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The folder of the registry.
const FOLDER: &str = "paper_figures";
/// What `--quick` divides the edges by; it also takes one sample a pixel.
const QUICK_DIVISOR: u32 = 6;

/// What is made.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// The figure, a folder of `paper_figures/` or the unique end of its name; `None`: list them.
    pub name: Option<String>,
    /// Folder for the results; `None`: `out/figures/NAME`.
    pub out: Option<PathBuf>,
    /// Small, one sample a pixel.
    pub quick: bool,
}

/// A `figure.toml`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// One line.
    pub title: String,
    /// Paper and number.
    pub source: String,
    /// Panels side by side.
    #[serde(default = "one")]
    pub columns: u32,
    /// Pixels of a panel.
    #[serde(default = "usual_size")]
    pub size: [u32; 2],
    /// Samples a pixel.
    #[serde(default = "one")]
    pub spp: u32,
    /// The panels, row by row.
    #[serde(default)]
    pub panels: Vec<Panel>,
    /// A table of these scenes instead of panels, as `pelage bench` measures it.
    pub table: Option<Table>,
}

/// One picture of a figure.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Panel {
    /// What it shows.
    pub label: String,
    /// Scene file, relative to the figure's folder.
    pub scene: String,
    /// Overrides, as after `-D`.
    #[serde(default)]
    pub set: Vec<String>,
}

/// What a table measures.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table {
    /// Scene files, relative to the figure's folder.
    pub scenes: Vec<String>,
    /// Image sizes.
    pub sizes: Vec<[u32; 2]>,
    /// Renderings of each.
    pub runs: u32,
}

fn one() -> u32 {
    1
}
fn usual_size() -> [u32; 2] {
    [960, 568]
}

/// The JSON file beside a figure.
#[derive(Debug, Serialize)]
struct Record {
    figure: String,
    title: String,
    source: String,
    quick: bool,
    provenance: Provenance,
    panels: Vec<PanelRecord>,
}

#[derive(Debug, Serialize)]
struct PanelRecord {
    label: String,
    file: String,
    scene: String,
    set: Vec<String>,
    stats: Stats,
}

impl Figure {
    /// The names of all figures, sorted.
    ///
    /// # Errors
    /// [`Error::Usage`] if there is no folder `paper_figures/`, [`Error::Io`].
    pub fn names() -> Result<Vec<String>> {
        let folder = repository_path(FOLDER)?;
        let entries = std::fs::read_dir(&folder).map_err(|e| Error::io(&folder, e))?;
        let mut names: Vec<String> = entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|path| path.join("figure.toml").is_file())
            .filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned()))
            .collect();
        names.sort();
        Ok(names)
    }

    /// Reads the figure called `name`, with its folder, which has the full name. The part after the last hyphens will do where it
    /// is unique: `fig8` for `andersen2016-fig8`.
    ///
    /// # Errors
    /// [`Error::Usage`] with the known names if there is none of that name, [`Error::Scene`] if its file is not valid.
    pub fn find(name: &str) -> Result<(Self, PathBuf)> {
        let names = Self::names()?;
        let end = format!("-{name}");
        let ending: Vec<&String> = names.iter().filter(|known| known.ends_with(&end)).collect();
        let found = match (names.iter().find(|known| *known == name), &ending[..]) {
            (Some(exact), _) => exact,
            (None, [only]) => only,
            _ => {
                return Err(Error::Usage(format!(
                    "there is no figure {name:?}; there are {}",
                    names.join(", ")
                )));
            }
        };
        let folder = repository_path(FOLDER)?.join(found);
        let path = folder.join("figure.toml");
        let text = std::fs::read_to_string(&path).map_err(|e| Error::io(&path, e))?;
        let figure: Self = toml::from_str(&text).map_err(|e| {
            let line = e.span().map_or(0, |span| text[..span.start].matches('\n').count() + 1);
            Error::fault_at(&path, line, e.message())
        })?;
        figure.check().map_err(|message| Error::fault(&path, message))?;
        Ok((figure, folder))
    }

    fn check(&self) -> Result<(), String> {
        if self.panels.is_empty() == self.table.is_none() {
            return Err("expected either panels or a table".into());
        }
        if self.columns == 0 || self.spp == 0 || self.size.contains(&0) || self.panels.len() > 26 {
            return Err("columns, spp and size must be at least 1, and there are at most 26 panels".into());
        }
        Ok(())
    }
}

/// Makes a figure or lists them all.
///
/// # Errors
/// [`Error::Usage`] for an unknown name, [`Error::Scene`] if a scene is not valid or an asset is missing (with how to get it),
/// [`Error::Io`], and those of [`render::render_on`].
pub fn run(options: &Options) -> Result<()> {
    let Some(name) = &options.name else {
        for name in Figure::names()? {
            let (figure, _) = Figure::find(&name)?;
            say(&format!("{name:22} {} ({})\n", figure.title, figure.source))?;
        }
        return Ok(());
    };
    let (figure, folder) = Figure::find(name)?;
    let name = &folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let out = options.out.clone().unwrap_or_else(|| Path::new("out/figures").join(name));
    std::fs::create_dir_all(&out).map_err(|e| Error::io(&out, format!("cannot be made: {e}")))?;
    match &figure.table {
        Some(table) => make_table(name, &figure, table, &folder, &out, options.quick),
        None => make_panels(name, &figure, &folder, &out, options.quick),
    }
}

fn make_table(
    name: &str,
    figure: &Figure,
    table: &Table,
    folder: &Path,
    out: &Path,
    quick: bool,
) -> Result<()> {
    let sizes = if quick { vec![[160, 95]] } else { table.sizes.clone() };
    let options = bench::Options {
        scenes: table.scenes.iter().map(|scene| folder.join(scene)).collect(),
        sizes,
        runs: if quick { 1 } else { table.runs },
        ..bench::Options::default()
    };
    let mut text = format!("# {} ({})\n\n", figure.title, figure.source);
    let report = bench::measure(&options, &mut |part| {
        text += part;
        say(part)
    })?;
    let markdown = out.join(format!("{name}.md"));
    files::write_atomically(&markdown, |file| Ok(std::io::Write::write_all(file, text.as_bytes())?))?;
    write_json(&out.join(format!("{name}.json")), &report)
}

fn make_panels(name: &str, figure: &Figure, folder: &Path, out: &Path, quick: bool) -> Result<()> {
    // Everything is loaded before anything is rendered: a missing file shows itself at once.
    let jobs = figure
        .panels
        .iter()
        .map(|panel| load(figure, panel, folder, quick).map(|job| (panel, job)))
        .collect::<Result<Vec<_>>>()?;
    let gpu = Gpu::open()?;
    let mut record = Record {
        figure: name.to_owned(),
        title: figure.title.clone(),
        source: figure.source.clone(),
        quick,
        provenance: Provenance::of(&gpu),
        panels: Vec::new(),
    };
    let mut pictures = Vec::new();
    for (i, (panel, (world, assets))) in jobs.iter().enumerate() {
        let letter = char::from(b'a' + (i % 26) as u8);
        gpu.ledger.reset_peaks();
        let mut frame =
            render::render_on(&gpu, world, &RenderOptions { aovs: true, ..RenderOptions::default() })?;
        depth_of_field::apply(&mut frame.film, &world.scene.camera)?;
        composite::over_background(&mut frame.film, &world.scene, assets)?;
        let file = format!("{letter}_{}.exr", file_name(&panel.label));
        let metadata = metadata(&world.scene, &frame.stats);
        io::write(&frame.film, out.join(&file), &metadata, &world.scene.film)?;
        say(&format!(
            "{letter} {}: {:.2} s, {}\n",
            panel.label,
            frame.stats.total_ms / 1e3,
            out.join(&file).display()
        ))?;
        pictures.push(panel::Picture::of(
            &frame.film,
            &world.scene.film,
            format!("({letter}) {}", panel.label),
        )?);
        record.panels.push(PanelRecord {
            label: panel.label.clone(),
            file,
            scene: panel.scene.clone(),
            set: panel.set.clone(),
            stats: frame.stats,
        });
    }
    let sheet: Film = panel::assemble(&pictures, figure.columns);
    let spec = FilmSpec { tonemap: Tonemap::None, exposure: 0.0, ..FilmSpec::default() };
    let metadata = Metadata::of_program()
        .with_adapter(&record.provenance.adapter, &record.provenance.driver)
        .with_command_line(std::env::args_os().map(|a| a.to_string_lossy().into_owned()));
    let path = out.join(format!("{name}.png"));
    io::write(&sheet, &path, &metadata, &spec)?;
    write_json(&out.join(format!("{name}.json")), &record)?;
    say(&format!("{}\n", path.display()))
}

type Job = (World, crate::assets::Assets);

fn load(figure: &Figure, panel: &Panel, folder: &Path, quick: bool) -> Result<Job> {
    let divisor = if quick { QUICK_DIVISOR } else { 1 };
    let [width, height] = figure.size.map(|n| (n / divisor).max(1));
    let spp = if quick { 1 } else { figure.spp };
    let mut overrides =
        vec![format!("film.width={width}"), format!("film.height={height}"), format!("film.spp={spp}")];
    overrides.extend(panel.set.iter().cloned());
    let job = Scene::load(&folder.join(&panel.scene), &overrides)
        .and_then(|(scene, assets)| Ok((World::load(scene, &assets)?, assets)));
    job.map_err(|e| match e {
        Error::Scene(mut faults) if only_files_missing(&Error::Scene(faults.clone())) => {
            for fault in &mut faults {
                fault.help.get_or_insert_with(|| {
                    "scripts/fetch_assets.sh fetches the bunny and the environment maps".into()
                });
            }
            Error::Scene(faults)
        }
        other => other,
    })
}

fn metadata(scene: &Scene, stats: &Stats) -> Metadata {
    Metadata::of_program()
        .with_scene(&toml::to_string(scene).unwrap_or_default())
        .with_seed(scene.render.seed)
        .with_command_line(std::env::args_os().map(|a| a.to_string_lossy().into_owned()))
        .with_stats(stats)
}

/// A label as part of a file name.
fn file_name(label: &str) -> String {
    let words = label.split(|c: char| !c.is_ascii_alphanumeric()).filter(|w| !w.is_empty());
    words.collect::<Vec<_>>().join("_").to_lowercase()
}
