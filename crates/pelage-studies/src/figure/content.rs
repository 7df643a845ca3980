//! What a figure consists of once it is made, and the files that it becomes.

use super::panel;
use super::spec::Figure;
use crate::provenance::{Provenance, write_json};
use crate::report::plot::Plot;
use crate::report::{Table, file_name};
use pelage_core::film::{Film, Metadata, io};
use pelage_core::scene::{FilmSpec, Tonemap};
use pelage_core::stats::Stats;
use pelage_core::{Error, Result, files};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A picture.
pub struct PanelImage {
    /// What it shows.
    pub label: String,
    /// Its layers.
    pub film: Film,
    /// How it is shown.
    pub spec: FilmSpec,
    /// The scene as it was rendered, TOML; `None` where no scene was rendered.
    pub scene: Option<String>,
    /// Counts and times.
    pub stats: Option<Stats>,
}

impl PanelImage {
    /// Of pixels that are shown as they are: display-linear, premultiplied.
    pub fn drawn(label: &str, film: Film) -> Self {
        let spec = FilmSpec { tonemap: Tonemap::None, exposure: 0.0, ..FilmSpec::default() };
        Self { label: label.to_owned(), film, spec, scene: None, stats: None }
    }
}

/// A number that does not depend on the machine, for the check against what is kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Value {
    /// What it is.
    pub name: String,
    /// The number.
    pub value: f64,
    /// How far it may be from the number that is kept.
    pub tolerance: f64,
}

/// A drawing of lines.
pub struct Diagram {
    /// Part of its file's name.
    pub name: String,
    /// What it shows.
    pub caption: String,
    /// The whole file.
    pub svg: String,
}

/// A figure's parts.
#[derive(Default)]
pub struct FigureContent {
    /// Pictures, which are also assembled to a sheet.
    pub images: Vec<PanelImage>,
    /// Curves, each with part of its file's name.
    pub plots: Vec<(String, Plot)>,
    /// Drawings.
    pub diagrams: Vec<Diagram>,
    /// Tables and words, Markdown.
    pub text: String,
    /// Numbers that are checked.
    pub values: Vec<Value>,
    /// Files that were written besides (name, what it is).
    pub files: Vec<(String, String)>,
    /// Photographs that are not there; words on grey stand for them.
    pub missing: Vec<String>,
}

impl FigureContent {
    /// Adds a table to the text.
    pub fn table(&mut self, table: &Table) {
        self.text += &table.markdown();
        self.text.push('\n');
    }

    /// Adds a number that is checked.
    pub fn value(&mut self, name: &str, value: f64, tolerance: f64) {
        self.values.push(Value { name: name.to_owned(), value, tolerance });
    }
}

/// The JSON file beside a figure: all that a report says about it.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Record {
    /// Name.
    pub figure: String,
    /// One line.
    pub title: String,
    /// Paper and number.
    pub source: String,
    /// Whether it is the small version.
    pub quick: bool,
    /// Time that it took, s.
    pub seconds: f64,
    /// Program, machine, date and command.
    pub provenance: Provenance,
    /// What is seen and what differs from the paper, Markdown.
    pub caption: String,
    /// The assembled panels.
    pub sheet: Option<String>,
    /// Panels.
    pub pictures: Vec<Picture>,
    /// Plots and drawings.
    pub drawings: Vec<Drawing>,
    /// Files of two pictures that a slider wipes between.
    pub wipes: Vec<[String; 2]>,
    /// Tables and words, Markdown.
    pub text: String,
    /// Numbers that are checked.
    pub values: Vec<Value>,
    /// Other files.
    pub files: Vec<Drawing>,
    /// Photographs that are not there.
    #[serde(default)]
    pub missing: Vec<String>,
}

/// A picture's place in a [`Record`].
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Picture {
    /// What it shows.
    pub label: String,
    /// PNG beside the record.
    pub file: String,
    /// All its layers, OpenEXR, beside the record.
    pub layers: String,
    /// Counts and times.
    pub stats: Option<serde_json::Value>,
}

/// A file with its caption.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Drawing {
    /// Beside the record.
    pub file: String,
    /// What it shows.
    pub caption: String,
}

impl Record {
    /// Writes a figure's files into `out`, its record last.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Unsupported`] where a film lacks planes or a wipe names no picture.
    pub(super) fn write(mut self, figure: &Figure, content: FigureContent, out: &Path) -> Result<Self> {
        let metadata = Metadata::of_program()
            .with_adapter(&self.provenance.adapter, &self.provenance.driver)
            .with_command_line(self.provenance.command.iter());
        let text = |file: &str, text: &str| {
            files::write_atomically(&out.join(file), |f| Ok(std::io::Write::write_all(f, text.as_bytes())?))
        };
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
            let spec = FilmSpec { tonemap: Tonemap::None, exposure: 0.0, ..FilmSpec::default() };
            let file = format!("{}.png", self.figure);
            io::write(&sheet, out.join(&file), &metadata, &spec)?;
            self.sheet = Some(file);
        }
        for (name, plot) in &content.plots {
            let file = format!("{}.svg", file_name(name));
            text(&file, &plot.file())?;
            self.drawings.push(Drawing { file, caption: plot.caption.clone() });
        }
        for diagram in &content.diagrams {
            let file = format!("{}.svg", file_name(&diagram.name));
            text(&file, &diagram.svg)?;
            self.drawings.push(Drawing { file, caption: diagram.caption.clone() });
        }
        for wipe in &figure.wipes {
            let file = |label: &String| {
                self.pictures.iter().find(|p| p.label == *label).map(|p| p.file.clone()).ok_or_else(|| {
                    Error::Unsupported(format!(
                        "{}: a wipe names {label:?}, which no picture is called",
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

    /// Reads the record in a figure's folder of results; `None` where there is none that can be read.
    pub(super) fn read(out: &Path) -> Option<Self> {
        serde_json::from_str(&std::fs::read_to_string(out.join(RECORD)).ok()?).ok()
    }
}

/// The record's name beside the pictures.
const RECORD: &str = "figure.json";

/// a, b, ..., z, a2, b2, ...
fn letter(i: usize) -> String {
    let letter = char::from(b'a' + (i % 26) as u8);
    match i / 26 {
        0 => letter.to_string(),
        round => format!("{letter}{}", round + 1),
    }
}
