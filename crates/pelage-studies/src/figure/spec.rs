//! `figure.toml`: the description of a figure.

use crate::provenance::repository_path;
use pelage_core::{Error, Result};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// The folder of the registry.
pub(super) const FOLDER: &str = "paper_figures";
/// The description in a figure's folder.
pub(super) const FILE: &str = "figure.toml";
/// Widest panel and most samples of `--quick`, unless the figure sets its own.
const QUICK_WIDTH: u32 = 240;
const QUICK_SAMPLES: u32 = 4;

/// A `figure.toml`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// Title, one line.
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
    /// Study that runs after the panels, or without any: one of [`super::study::STUDIES`].
    pub study: Option<String>,
    /// Settings of the study.
    #[serde(default)]
    pub settings: toml::Table,
    /// Pairs of panels that the report lays over each other.
    #[serde(default)]
    pub wipes: Vec<Wipe>,
    /// Changes for `--quick`.
    #[serde(default)]
    pub quick: Quick,
}

/// One picture of a figure.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Panel {
    /// What it shows.
    pub label: String,
    /// Scene file, relative to the figure's folder.
    pub scene: Option<String>,
    /// Overrides, as after `-D`.
    #[serde(default)]
    pub set: Vec<String>,
    /// Frame of the scene's animation, from 1.
    #[serde(default = "one")]
    pub frame: u32,
    /// A photograph instead of a scene; it is searched for like the files of a scene.
    pub image: Option<String>,
}

/// Labels of two panels of equal size that a slider compares.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wipe {
    /// Shown left of the slider.
    pub left: String,
    /// Shown right of it.
    pub right: String,
}

/// What `--quick` changes.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Quick {
    /// Pixels of a panel; `None`: the figure's, scaled down to a width of at most 240.
    pub size: Option<[u32; 2]>,
    /// Samples a pixel; `None`: the figure's, at most 4.
    pub spp: Option<u32>,
    /// Overrides for all panels, applied before their own.
    #[serde(default)]
    pub set: Vec<String>,
    /// Settings of the study that replace those of the figure.
    #[serde(default)]
    pub settings: toml::Table,
}

fn one() -> u32 {
    1
}
fn usual_size() -> [u32; 2] {
    [960, 568]
}

impl Figure {
    /// The names of all figures in natural order: `fig2` before `fig10`.
    ///
    /// # Errors
    /// [`Error::Usage`] if there is no folder `paper_figures/`, [`Error::Io`].
    pub fn names() -> Result<Vec<String>> {
        let folder = repository_path(FOLDER)?;
        let entries = std::fs::read_dir(&folder).map_err(|e| Error::io(&folder, e))?;
        let mut names: Vec<String> = entries
            .filter_map(|entry| Some(entry.ok()?.path()))
            .filter(|path| path.join(FILE).is_file())
            .filter_map(|path| Some(path.file_name()?.to_string_lossy().into_owned()))
            .collect();
        names.sort_by_key(|name| {
            let stem = name.trim_end_matches(|c: char| c.is_ascii_digit());
            (stem.to_owned(), name[stem.len()..].parse::<u64>().unwrap_or(0))
        });
        Ok(names)
    }

    /// Reads the figure called `name`; returns it with its folder. A unique ending after a hyphen
    /// is enough: `fig8` for `andersen2016-fig8`.
    ///
    /// # Errors
    /// [`Error::Usage`] with the known names if the name is unknown or ambiguous, [`Error::Scene`]
    /// if the figure's file is not valid.
    pub fn find(name: &str) -> Result<(Self, PathBuf)> {
        let names = Self::names()?;
        let end = format!("-{name}");
        let ending: Vec<&String> = names.iter().filter(|known| known.ends_with(&end)).collect();
        let found = match (names.iter().find(|known| *known == name), &ending[..]) {
            (Some(exact), _) => exact,
            (None, [only]) => only,
            (None, []) => {
                let all = names.join(", ");
                return Err(Error::Usage(format!("there is no figure {name:?}; there are {all}")));
            }
            (None, several) => {
                let several: Vec<&str> = several.iter().map(|name| name.as_str()).collect();
                return Err(Error::Usage(format!("{name:?} is ambiguous: {}", several.join(", "))));
            }
        };
        let folder = repository_path(FOLDER)?.join(found);
        let path = folder.join(FILE);
        let text = std::fs::read_to_string(&path).map_err(|e| Error::io(&path, e))?;
        Ok((Self::parse(&text, &path)?, folder))
    }

    fn parse(text: &str, path: &Path) -> Result<Self> {
        let figure: Self = toml::from_str(text).map_err(|e| {
            let line = e.span().map_or(0, |span| text[..span.start].matches('\n').count() + 1);
            Error::fault_at(path, line, e.message())
        })?;
        figure.check().map_err(|message| Error::fault(path, message))?;
        Ok(figure)
    }

    fn check(&self) -> Result<(), String> {
        if self.panels.is_empty() && self.study.is_none() {
            return Err("expected panels or a study".into());
        }
        let sizes = [Some(self.size), self.quick.size];
        if sizes.into_iter().flatten().any(|size| size.contains(&0)) {
            return Err("size must be at least 1".into());
        }
        if self.columns == 0 || self.spp == 0 || self.quick.spp == Some(0) || self.panels.len() > 26 {
            return Err("columns and spp must be at least 1, and there are at most 26 panels".into());
        }
        if let Some(panel) = self.panels.iter().find(|p| p.scene.is_some() == p.image.is_some()) {
            return Err(format!("panel {:?}: expected either a scene or an image", panel.label));
        }
        if let Some(name) = self.study.as_deref().filter(|name| super::study::find(name).is_none()) {
            let known: Vec<&str> = super::study::STUDIES.iter().map(|(name, _)| *name).collect();
            return Err(format!("there is no study {name:?}; there are {}", known.join(", ")));
        }
        if self.study.is_none() && !(self.settings.is_empty() && self.quick.settings.is_empty()) {
            return Err("settings without a study".into());
        }
        for label in self.wipes.iter().flat_map(|w| [&w.left, &w.right]) {
            // A study may add pictures that wipes name.
            if self.study.is_none() && !self.panels.iter().any(|panel| panel.label == *label) {
                return Err(format!("a wipe names {label:?}, but no panel has this label"));
            }
        }
        Ok(())
    }

    /// Pixels of a panel: `asked`, if given, or those of the figure or of its quick version.
    pub(super) fn panel_size(&self, asked: Option<[u32; 2]>, quick: bool) -> [u32; 2] {
        let narrow = || {
            let [width, height] = self.size;
            let to = width.min(QUICK_WIDTH);
            [to, (height * to).div_ceil(width).max(1)]
        };
        match (asked, quick) {
            (Some(size), _) => size,
            (None, true) => self.quick.size.unwrap_or_else(narrow),
            (None, false) => self.size,
        }
    }

    /// Samples a pixel.
    pub(super) fn samples(&self, quick: bool) -> u32 {
        if quick { self.quick.spp.unwrap_or(self.spp.min(QUICK_SAMPLES)) } else { self.spp }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Figure> {
        Figure::parse(&format!("title = \"t\"\nsource = \"s\"\n{text}"), Path::new("figure.toml"))
    }

    #[test]
    fn inconsistent_figures_are_errors() {
        for (text, part) in [
            ("", "panels or a study"),
            ("[[panels]]\nlabel = \"a\"", "a scene or an image"),
            ("[[panels]]\nlabel = \"a\"\nscene = \"x\"\nimage = \"y\"", "a scene or an image"),
            ("study = \"alchemy\"", "alchemy"),
            ("settings.x = 1\n[[panels]]\nlabel = \"a\"\nscene = \"x\"", "without a study"),
            ("[[panels]]\nlabel = \"a\"\nscene = \"x\"\n[[wipes]]\nleft = \"a\"\nright = \"b\"", "\"b\""),
            ("size = [0, 3]\n[[panels]]\nlabel = \"a\"\nscene = \"x\"", "size"),
        ] {
            let error = parse(text).expect_err(text).to_string();
            assert!(error.contains(part) && error.contains("figure.toml"), "{text}: {error}");
        }
    }

    #[test]
    fn quick_panels_keep_their_shape() {
        let panels = "[[panels]]\nlabel = \"a\"\nscene = \"x\"\n";
        let figure = parse(&format!("size = [960, 568]\nspp = 16\n{panels}")).expect("valid");
        assert_eq!((figure.panel_size(None, true), figure.samples(true)), ([240, 142], 4));
        assert_eq!((figure.panel_size(None, false), figure.samples(false)), ([960, 568], 16));
        assert_eq!(figure.panel_size(Some([5, 6]), true), [5, 6]);
        let figure = parse(&format!("{panels}[quick]\nsize = [90, 50]\nspp = 2\n")).expect("valid");
        assert_eq!((figure.panel_size(None, true), figure.samples(true)), ([90, 50], 2));
    }
}
