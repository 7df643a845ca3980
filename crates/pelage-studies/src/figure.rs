//! The figures and tables of the works that pelage implements. Each is a folder of `paper_figures/`
//! with a `figure.toml`, its scenes, and a caption.
//!
//! Panels are scenes that are rendered like any other picture; they need no code. A figure that is
//! more than scenes side by side has a [`study`]. Both give a [`FigureContent`], whose files and
//! [`Record`] are written to `NAME/result/`. `page` and `markdown` write reports from the records,
//! `golden` compares small versions with the kept ones.

mod content;
mod context;
mod drawing;
mod golden;
mod markdown;
mod page;
mod panel;
mod probe;
mod spec;
pub mod study;

pub use content::{Diagram, FigureContent, PanelImage, Record, Value};
pub use context::FigureContext;
pub use spec::{Figure, Panel, Quick, Wipe};

use crate::provenance::{Provenance, only_files_missing, repository_path, say};
use pelage_core::{Error, Result};
use pelage_gpu::Gpu;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// What a run produces.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Figures: folders of `paper_figures/`, or unique endings of their names; empty: all.
    pub names: Vec<String>,
    /// Folder for the results and the report; `None`: `paper_figures/`.
    pub out: Option<PathBuf>,
    /// The small version, sized for two CPU cores.
    pub quick: bool,
    /// Pixels of a panel; `None`: the figure's.
    pub size: Option<[u32; 2]>,
    /// Whether results are compared with the kept ones (`paper_figures/NAME/golden/`).
    pub check: bool,
    /// Whether results replace the kept ones, and the report in Markdown is rewritten.
    pub bless: bool,
}

/// Lists all figures.
///
/// # Errors
/// As [`Figure::names`] and [`Figure::find`].
pub fn list() -> Result<()> {
    for name in Figure::names()? {
        let (figure, _) = Figure::find(&name)?;
        say(&format!("{name:22} {} ({})\n", figure.title, figure.source))?;
    }
    Ok(())
}

/// Produces figures and writes `index.html`. A figure that fails or lacks a file is reported, and
/// the others are still produced.
///
/// # Errors
/// [`Error::Usage`] for an unknown name; [`Error::Interrupted`]; [`Error::Io`]. At the end: the
/// error of the figure if only one was asked for, otherwise [`Error::GoalMissed`] with the figures
/// that failed and the parts that differ from the kept ones. If several figures are asked for,
/// missing assets are not an error.
pub fn run(options: &Options, cancel: &AtomicBool) -> Result<()> {
    let names = if options.names.is_empty() { Figure::names()? } else { options.names.clone() };
    let figures = names.iter().map(|name| Figure::find(name)).collect::<Result<Vec<_>>>()?;
    let registry = repository_path(spec::FOLDER)?;
    let root = options.out.as_ref().unwrap_or(&registry);
    let gpu = pelage_render::open()?;
    let (mut faults, mut differing) = (Vec::new(), Vec::new());
    for (figure, folder) in &figures {
        let name = name_of(folder);
        say(&format!("{name}: {}\n", figure.title))?;
        match make(&gpu, figure, folder, root, options, cancel) {
            Ok(record) => {
                say(&format!("  {:.1} s, {}\n", record.seconds, result_folder(root, &name).display()))?;
                if !record.missing.is_empty() {
                    say(&format!(
                        "  note: {} not found; pictures are neither kept nor compared\n",
                        record.missing.join(", ")
                    ))?;
                } else if options.bless {
                    golden::keep(&record, root, folder)?;
                }
                if options.check {
                    differing.extend(golden::differences(&record, root, folder)?);
                }
            }
            Err(Error::Interrupted) => return Err(Error::Interrupted),
            Err(error) => {
                let missing = only_files_missing(&error);
                say(&format!("  {}: {error}\n", if missing { "skipped" } else { "failed" }))?;
                if !missing || figures.len() == 1 {
                    faults.push((name, error));
                }
            }
        }
    }
    let records: Vec<Record> =
        Figure::names()?.iter().filter_map(|name| Record::read(&result_folder(root, name))).collect();
    page::write(&records, root)?;
    if options.bless {
        markdown::write(&registry)?;
    }
    say(&format!("{}\n", root.join(page::FILE).display()))?;
    verdict(faults, &differing, figures.len())
}

fn verdict(mut faults: Vec<(String, Error)>, differing: &[String], figures: usize) -> Result<()> {
    if figures == 1 && faults.len() == 1 {
        return Err(faults.remove(0).1);
    }
    let failed = faults.iter().map(|(name, error)| format!("\n{name}: {error}"));
    let lines: Vec<String> = failed.chain(differing.iter().map(|line| format!("\n{line}"))).collect();
    if lines.is_empty() {
        return Ok(());
    }
    Err(Error::GoalMissed(format!(
        "{} figures failed, {} parts differ from the kept ones:{}",
        faults.len(),
        differing.len(),
        lines.concat()
    )))
}

fn make(
    gpu: &Gpu,
    figure: &Figure,
    folder: &Path,
    root: &Path,
    options: &Options,
    cancel: &AtomicBool,
) -> Result<Record> {
    let begin = Instant::now();
    let name = name_of(folder);
    let out = result_folder(root, &name);
    // Files of an earlier run would be taken for results of this one.
    match std::fs::remove_dir_all(&out) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => return Err(Error::io(&out, e)),
        _ => {}
    }
    std::fs::create_dir_all(&out).map_err(|e| Error::io(&out, format!("cannot be created: {e}")))?;
    let caption = folder.join("caption.md");
    let caption = std::fs::read_to_string(&caption).map_err(|e| Error::io(&caption, e))?;
    let context =
        FigureContext { gpu, figure, folder, out: &out, quick: options.quick, asked: options.size, cancel };
    let mut content = context.panels()?;
    if let Some(study) = figure.study.as_deref().and_then(study::find) {
        let more = study(&context)?;
        content.images.extend(more.images);
        content = FigureContent { images: content.images, missing: content.missing, ..more };
    }
    let record = Record {
        figure: name,
        title: figure.title.clone(),
        source: figure.source.clone(),
        quick: options.quick,
        seconds: begin.elapsed().as_secs_f64(),
        provenance: Provenance::of(gpu),
        caption,
        ..Record::default()
    };
    record.write(figure, content, &out)
}

fn name_of(folder: &Path) -> String {
    folder.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn result_folder(root: &Path, name: &str) -> PathBuf {
    root.join(name).join("result")
}
