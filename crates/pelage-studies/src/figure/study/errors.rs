//! What the approximations cost: the experiments of `pelage validate` as a figure.

use super::super::content::PanelImage;
use super::super::{FigureContent, FigureContext};
use crate::report::{Table, number};
use crate::validate;
use crate::validate::{Finding, Goal, Level, Section};
use pelage_core::film::{Film, io};
use pelage_core::{Error, Result};
use serde::Deserialize;

/// Folder of the experiments' own report, in that of the figure's results.
const REPORT: &str = "report";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// `quick`, `usual` or `full`.
    level: Level,
    /// Names of experiments; empty: all.
    experiments: Vec<String>,
    /// Parts of the names of cases; empty: all.
    cases: Vec<String>,
    /// The case whose pictures are shown.
    shown: String,
    /// How many pixels along a side each of their pixels becomes.
    magnify: u32,
}

pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let settings: Settings = context.settings()?;
    let options = validate::Options {
        level: settings.level,
        out: context.out.join(REPORT),
        only: settings.experiments,
        cases: settings.cases,
    };
    let report = validate::run(&options, &|_| {}, context.cancel)?;
    let mut content = FigureContent::default();
    for section in &report.sections {
        context.tell(&format!(
            "{}: {:.1} s, {} findings",
            section.name,
            section.seconds,
            section.findings.len()
        ))?;
        content.table(&table(section));
        for (i, plot) in section.plots.iter().enumerate() {
            content.plots.push((format!("{} {}", section.name, i + 1), plot.clone()));
        }
        for skipped in &section.skipped {
            content.text += &format!("Left out: {skipped}.\n\n");
        }
    }
    let mut exhibits = report.sections.iter().flat_map(|section| &section.exhibits);
    let caption = |exhibit: &&validate::Exhibit| {
        exhibit.table.as_ref().is_some_and(|table| table.caption.contains(&settings.shown))
    };
    let found = exhibits.rfind(caption).ok_or_else(|| {
        Error::fault(
            context.folder.join("figure.toml"),
            format!("settings.shown is {:?}: no measured case is called that", settings.shown),
        )
    })?;
    for picture in found.pictures.iter().filter(|picture| !timed(&picture.caption)) {
        // Pictures that are there already: as a display shows them.
        let film = magnified(&io::read(options.out.join(&picture.file))?, settings.magnify.max(1))?;
        content.images.push(PanelImage::drawn(&picture.caption, film));
    }
    content.text += &found.table.as_ref().map_or(String::new(), |table| table.markdown() + "\n");
    content.files.push((format!("{REPORT}/report.html"), "The whole report".into()));
    for finding in report.findings().filter(|finding| !timed(&finding.approximation)) {
        let name = format!("{}, {}, {}", finding.approximation, finding.case, finding.metric);
        content.value(&name, finding.value, tolerance(finding));
    }
    Ok(content)
}

/// The same with each pixel repeated.
fn magnified(film: &Film, factor: u32) -> Result<Film> {
    let pixels = film.premultiplied()?;
    let [width, height] = [film.width * factor, film.height * factor];
    let at = |x: u32, y: u32| pixels[(y / factor * film.width + x / factor) as usize];
    let all: Vec<[f32; 4]> =
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| at(x, y)).collect();
    Ok(Film::from_premultiplied(width, height, &all))
}

/// Whether what is called so depends on how fast the machine is: the number of hairs does, and with it all that is seen of them.
fn timed(name: &str) -> bool {
    name.contains("equal time")
}

/// A tenth of what the goal allows, or of the value.
fn tolerance(finding: &Finding) -> f64 {
    0.1 * match finding.goal {
        Some(Goal::AtMost(limit) | Goal::OneWithin(limit)) => limit.abs(),
        Some(Goal::AtLeast(_)) | None => finding.value.abs(),
    }
}

fn table(section: &Section) -> Table {
    let dash = || "–".to_owned();
    let row = |f: &Finding| {
        let met = f.met.map_or_else(dash, |met| if met { "yes".into() } else { "**no**".into() });
        let goal = f.goal.map_or_else(dash, |goal| goal.to_string());
        vec![f.approximation.clone(), f.case.clone(), f.metric.clone(), number(f.value), goal, met]
    };
    Table {
        caption: format!("**{}**", section.title),
        head: ["approximation", "case", "metric", "value", "goal", "met"].map(String::from).to_vec(),
        rows: section.findings.iter().map(row).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_repeated() {
        let film = Film::from_premultiplied(2, 1, &[[0.1; 4], [0.2; 4]]);
        let large = magnified(&film, 3).unwrap();
        assert_eq!((large.width, large.height), (6, 3));
        assert_eq!(large.plane("R").unwrap()[6..12], [0.1, 0.1, 0.1, 0.2, 0.2, 0.2]);
    }

    #[test]
    fn what_a_fast_machine_changes_is_not_kept() {
        assert!(timed("strands only, equal time") && !timed("volume only"));
        assert_eq!(tolerance(&Finding::new("volume only", "case", "metric", 0.5, None)), 0.05);
    }
}
