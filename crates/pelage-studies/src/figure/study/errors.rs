//! Errors of the approximations: the experiments of `pelage validate` as a figure.

use super::super::{FigureContent, FigureContext};
use crate::report::{Table, number};
use crate::validate::{self, Finding, Goal, Level, Section};
use pelage_core::Result;
use pelage_core::film::{Film, io};
use serde::Deserialize;

/// Folder of the experiments' own report, in the figure's result folder.
const REPORT: &str = "report";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// `quick`, `usual` or `full`.
    level: Level,
    /// Names of experiments; empty: all.
    experiments: Vec<String>,
    /// Parts of case names; empty: all.
    cases: Vec<String>,
    /// The case whose pictures are shown.
    shown: String,
    /// Factor on the width and height of these pictures; pixels are repeated.
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
        context.report(&format!(
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
    let is_shown = |exhibit: &&validate::Exhibit| {
        exhibit.table.as_ref().is_some_and(|table| table.caption.contains(&settings.shown))
    };
    let found = exhibits.rfind(is_shown).ok_or_else(|| {
        context.fault(format!("settings.shown is {:?}: no measured case has this name", settings.shown))
    })?;
    for picture in found.pictures.iter().filter(|picture| !timed(&picture.caption)) {
        // The files hold tone-mapped pixels already.
        let film = magnified(&io::read(options.out.join(&picture.file))?, settings.magnify.max(1))?;
        content.picture(&picture.caption, film);
    }
    content.text += &found.table.as_ref().map_or(String::new(), |table| table.markdown() + "\n");
    content.files.push((format!("{REPORT}/report.html"), "The whole report".into()));
    for finding in report.findings().filter(|finding| !timed(&finding.approximation)) {
        let name = format!("{}, {}, {}", finding.approximation, finding.case, finding.metric);
        content.value(&name, finding.value, tolerance(finding));
    }
    Ok(content)
}

/// Repeats each pixel `factor` times along both axes.
fn magnified(film: &Film, factor: u32) -> Result<Film> {
    let pixels = film.premultiplied()?;
    let [width, height] = [film.width * factor, film.height * factor];
    let at = |x: u32, y: u32| pixels[(y / factor * film.width + x / factor) as usize];
    let all: Vec<[f32; 4]> =
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| at(x, y)).collect();
    Ok(Film::from_premultiplied(width, height, &all))
}

/// Whether a variant depends on the speed of the machine, which decides its number of hairs.
fn timed(name: &str) -> bool {
    name.contains("equal time")
}

/// A tenth of the goal's limit, or of the value.
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
    let head = ["approximation", "case", "metric", "value", "goal", "met"];
    Table::new(format!("**{}**", section.title), &head, section.findings.iter().map(row).collect())
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
    fn results_that_depend_on_speed_are_not_kept() {
        assert!(timed("strands only, equal time") && !timed("volume only"));
        assert_eq!(tolerance(&Finding::new("volume only", "case", "metric", 0.5, None)), 0.05);
    }
}
