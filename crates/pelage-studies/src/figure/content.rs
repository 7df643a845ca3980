//! The finished parts of a figure, and the files that they are written to.

use super::panel;
use super::spec::Figure;
use crate::provenance::{Provenance, write_json, write_text};
use crate::report::plot::Plot;
use crate::report::{Table, file_name};
use pelage_core::film::{Film, Metadata, io};
use pelage_core::scene::{FilmSpec, Tonemap};
use pelage_core::stats::Stats;
use pelage_core::{Error, Result};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A finished picture of a figure.
pub struct PanelImage {
    /// What it shows.
    pub label: String,
    /// Its planes.
    pub film: Film,
    /// Exposure and tone mapping.
    pub spec: FilmSpec,
    /// The scene as it was rendered, TOML; `None` if no scene was rendered.
    pub scene: Option<String>,
    /// Counts and times.
    pub stats: Option<Stats>,
}

impl PanelImage {
    /// A picture of display-linear, premultiplied pixels, which are shown as they are.
    pub fn drawn(label: &str, film: Film) -> Self {
        Self { label: label.to_owned(), film, spec: as_shown(), scene: None, stats: None }
    }
}

/// A number that does not depend on the machine; `--check` compares it with the kept one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Value {
    /// What it is.
    pub name: String,
    /// The number.
    pub value: f64,
    /// Largest absolute difference from the kept number.
    pub tolerance: f64,
}

/// A line drawing.
pub struct Diagram {
    /// Part of its file's name.
    pub name: String,
    /// What it shows.
    pub caption: String,
    /// The file's content.
    pub svg: String,
}

/// A figure's parts.
#[derive(Default)]
pub struct FigureContent {
    /// Pictures; they are also assembled into a sheet.
    pub images: Vec<PanelImage>,
    /// Curves, each with part of its file's name.
    pub plots: Vec<(String, Plot)>,
    /// Drawings.
    pub diagrams: Vec<Diagram>,
    /// Tables and text, Markdown.
    pub text: String,
    /// Numbers that `--check` compares.
    pub values: Vec<Value>,
    /// Other files that were written: name, description.
    pub files: Vec<(String, String)>,
    /// Photographs that were not found; a labelled placeholder takes their place.
    pub missing: Vec<String>,
}

impl FigureContent {
    /// Adds a picture of display-linear, premultiplied pixels.
    pub fn picture(&mut self, label: &str, film: Film) {
        self.images.push(PanelImage::drawn(label, film));
    }

    /// Adds a plot; `name` is part of its file's name.
    pub fn plot(&mut self, name: &str, plot: Plot) {
        self.plots.push((name.to_owned(), plot));
    }

    /// Adds a line drawing; `name` is part of its file's name.
    pub fn diagram(&mut self, name: &str, caption: &str, svg: String) {
        self.diagrams.push(Diagram { name: name.to_owned(), caption: caption.to_owned(), svg });
    }

    /// Adds a table to the text.
    pub fn table(&mut self, table: &Table) {
        self.text += &table.markdown();
        self.text.push('\n');
    }

    /// Adds a number that `--check` compares.
    pub fn value(&mut self, name: &str, value: f64, tolerance: f64) {
        self.values.push(Value { name: name.to_owned(), value, tolerance });
    }
}

/// The JSON file beside a figure's results. Reports are written from it.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Record {
    /// Name.
    pub figure: String,
    /// Title, one line.
    pub title: String,
    /// Paper and number.
    pub source: String,
    /// Whether it is the small version.
    pub quick: bool,
    /// Time taken, s.
    pub seconds: f64,
    /// Program, machine, date, and command.
    pub provenance: Provenance,
    /// Description and known differences from the paper, Markdown.
    pub caption: String,
    /// The assembled panels.
    pub sheet: Option<String>,
    /// Panels.
    pub pictures: Vec<Picture>,
    /// Plots and drawings.
    pub drawings: Vec<Drawing>,
    /// Pairs of picture files for the report's comparison sliders.
    pub wipes: Vec<[String; 2]>,
    /// Tables and text, Markdown.
    pub text: String,
    /// Numbers that `--check` compares.
    pub values: Vec<Value>,
    /// Other files.
    pub files: Vec<Drawing>,
    /// Photographs that were not found.
    #[serde(default)]
    pub missing: Vec<String>,
}

/// The files of a picture in a [`Record`].
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Picture {
    /// What it shows.
    pub label: String,
    /// PNG file beside the record.
    pub file: String,
    /// OpenEXR file with all planes, beside the record.
    pub layers: String,
    /// Counts and times.
    pub stats: Option<serde_json::Value>,
}

/// A file and its caption.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Drawing {
    /// File beside the record.
    pub file: String,
    /// What it shows.
    pub caption: String,
}

impl Record {
    /// Writes a figure's files into `out`, its record last.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Unsupported`] if a film lacks planes or a wipe names an unknown
    /// picture.
    pub(super) fn write(mut self, figure: &Figure, content: FigureContent, out: &Path) -> Result<Self> {
        let metadata = Metadata::of_program()
            .with_adapter(&self.provenance.adapter, &self.provenance.driver)
            .with_command_line(self.provenance.command.iter());
        let write = |file: &str, text: &str| write_text(&out.join(file), text);
        let mut tiles = Vec::new();
        for (i, image) in content.images.iter().enumerate() {
            let letter = letter(i);
            let stem = format!("{letter}_{}", file_name(&image.label));
            let [file, layers] = ["png", "exr"].map(|end| format!("{stem}.{end}"));
            let mut metadata = metadata.clone();
            if let Some(scene) = &image.scene {
                metadata = metadata.with_scene(scene);
            }
            if let Some(stats) = &image.stats {
                metadata = metadata.with_stats(stats);
            }
            for file in [&file, &layers] {
                io::write(&image.film, out.join(file), &metadata, &image.spec)?;
            }
            tiles.push(panel::Picture::of(&image.film, &image.spec, format!("({letter}) {}", image.label))?);
            let stats = image.stats.as_ref().and_then(|stats| serde_json::to_value(stats).ok());
            self.pictures.push(Picture { label: image.label.clone(), file, layers, stats });
        }
        if !tiles.is_empty() {
            let sheet = panel::assemble(&tiles, figure.columns);
            let file = format!("{}.png", self.figure);
            io::write(&sheet, out.join(&file), &metadata, &as_shown())?;
            self.sheet = Some(file);
        }
        for (name, plot) in &content.plots {
            let file = format!("{}.svg", file_name(name));
            write(&file, &plot.file())?;
            self.drawings.push(Drawing { file, caption: plot.caption.clone() });
        }
        for diagram in &content.diagrams {
            let file = format!("{}.svg", file_name(&diagram.name));
            write(&file, &diagram.svg)?;
            self.drawings.push(Drawing { file, caption: diagram.caption.clone() });
        }
        for wipe in &figure.wipes {
            let file = |label: &String| {
                self.pictures.iter().find(|p| p.label == *label).map(|p| p.file.clone()).ok_or_else(|| {
                    Error::Unsupported(format!(
                        "{}: a wipe names {label:?}, but no picture has this label",
                        self.figure
                    ))
                })
            };
            self.wipes.push([file(&wipe.left)?, file(&wipe.right)?]);
        }
        self.text = content.text;
        self.values = content.values;
        self.missing = content.missing;
        self.files = content.files.into_iter().map(|(file, caption)| Drawing { file, caption }).collect();
        write_json(&out.join(RECORD), &self)?;
        Ok(self)
    }

    /// Reads the record in a figure's result folder; `None` if there is no readable one.
    pub(super) fn read(out: &Path) -> Option<Self> {
        serde_json::from_str(&std::fs::read_to_string(out.join(RECORD)).ok()?).ok()
    }
}

/// File name of the record.
const RECORD: &str = "figure.json";

/// The film settings of pixels that are display-linear already.
pub(super) fn as_shown() -> FilmSpec {
    FilmSpec { tonemap: Tonemap::None, exposure: 0.0, ..FilmSpec::default() }
}

/// a, b, ..., z, a2, b2, ...
fn letter(i: usize) -> String {
    let letter = char::from(b'a' + (i % 26) as u8);
    match i / 26 {
        0 => letter.to_string(),
        round => format!("{letter}{}", round + 1),
    }
}
