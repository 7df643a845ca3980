//! What the approximations cost: measured against the ground truth, with goals, in a report.
//!
//! Each family of experiments is a function from a [`Lab`] to a [`Section`] of plain data: findings with their goals, tables, curves,
//! pictures. [`run`] collects them in a [`Report`], [`html`] writes it. Nothing here renders by a way of its own: the approximations
//! are [`pelage_render`], the truth is [`pelage_pathtrace`].

pub mod furnace;
pub mod html;
pub mod hybrid;
mod lab;
pub mod transmittance;
pub mod volume;

pub use lab::Lab;

use crate::provenance::{Provenance, write_json};
use crate::report;
use crate::report::Table;
use crate::report::plot::Plot;
use pelage_core::{Error, Result};
use pelage_render::Progress;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// How much is measured.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// A few minutes: fewer cases, smaller and noisier pictures. Goals are the same.
    Quick,
    /// Within half an hour on two cores.
    #[default]
    Usual,
    /// All cases, larger pictures, more samples.
    Full,
}

/// What is measured and where it is written.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// How much.
    pub level: Level,
    /// Folder of the report.
    pub out: PathBuf,
    /// Names of experiments; empty: all.
    pub only: Vec<String>,
    /// Parts of the names of the cases of those that compare pictures; empty: all.
    pub cases: Vec<String>,
}

/// What a value must be.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Goal {
    /// No more than this.
    AtMost(f64),
    /// No less than this.
    AtLeast(f64),
    /// One, give or take this.
    OneWithin(f64),
}

impl Goal {
    /// Whether `value` is what it must be; what is not a number is not.
    pub fn met(self, value: f64) -> bool {
        match self {
            Self::AtMost(limit) => value <= limit,
            Self::AtLeast(limit) => value >= limit,
            Self::OneWithin(limit) => (value - 1.0).abs() <= limit,
        }
    }
}

impl std::fmt::Display for Goal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::AtMost(limit) => write!(f, "at most {limit}"),
            Self::AtLeast(limit) => write!(f, "at least {limit}"),
            Self::OneWithin(limit) => write!(f, "1 ± {limit}"),
        }
    }
}

/// One number about one approximation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// What is approximated, or which model is tested.
    pub approximation: String,
    /// Where it was measured.
    pub case: String,
    /// What the number is.
    pub metric: String,
    /// The number.
    pub value: f64,
    /// What it must be; `None`: it is only told.
    pub goal: Option<Goal>,
    /// Whether it is.
    pub met: Option<bool>,
    /// Time that it took to compute the approximation, s; `None` where that says nothing.
    pub seconds: Option<f64>,
}

impl Finding {
    /// A number with its goal.
    pub fn new(approximation: &str, case: &str, metric: &str, value: f64, goal: Option<Goal>) -> Self {
        Self {
            approximation: approximation.to_owned(),
            case: case.to_owned(),
            metric: metric.to_owned(),
            value,
            goal,
            met: goal.map(|goal| goal.met(value)),
            seconds: None,
        }
    }

    /// With the time that it took.
    pub fn in_seconds(self, seconds: f64) -> Self {
        Self { seconds: Some(seconds), ..self }
    }
}

/// A picture beside the report.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Picture {
    /// File name in the report's folder.
    pub file: String,
    /// What it shows.
    pub caption: String,
}

/// A table with the pictures that it is about.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Exhibit {
    /// The table, if any.
    pub table: Option<Table>,
    /// Pictures side by side.
    pub pictures: Vec<Picture>,
}

/// The results of one experiment.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Section {
    /// Name, as `--only` takes it.
    pub name: String,
    /// Heading.
    pub title: String,
    /// What is measured, how, and what it does not say; paragraphs.
    pub text: Vec<String>,
    /// Numbers with their goals.
    pub findings: Vec<Finding>,
    /// Curves.
    pub plots: Vec<Plot>,
    /// More numbers, and pictures.
    pub exhibits: Vec<Exhibit>,
    /// What was left out, and why.
    pub skipped: Vec<String>,
    /// Time taken, s.
    pub seconds: f64,
}

/// Everything that was found.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// Adapter, driver, version, date, command.
    pub provenance: Provenance,
    /// CPU threads.
    pub threads: usize,
    /// How much was measured.
    pub level: Level,
    /// Time taken, s.
    pub seconds: f64,
    /// The experiments.
    pub sections: Vec<Section>,
}

impl Report {
    /// All findings.
    pub fn findings(&self) -> impl Iterator<Item = &Finding> {
        self.sections.iter().flat_map(|section| &section.findings)
    }

    /// The findings that miss their goal.
    pub fn missed(&self) -> Vec<&Finding> {
        self.findings().filter(|finding| finding.met == Some(false)).collect()
    }

    /// Whether all goals are met.
    ///
    /// # Errors
    /// [`Error::GoalMissed`] with those that are not.
    pub fn verdict(&self) -> Result<()> {
        let line = |f: &Finding| {
            let goal = f.goal.map_or(String::new(), |goal| goal.to_string());
            let value = report::number(f.value);
            format!("\n{}, {}: {} is {value}, expected {goal}", f.approximation, f.case, f.metric)
        };
        let lines: Vec<String> = self.missed().into_iter().map(line).collect();
        if lines.is_empty() {
            return Ok(());
        }
        Err(Error::GoalMissed(format!("{} of the goals are missed:{}", lines.len(), lines.concat())))
    }
}

/// An experiment: its name, what it is about, and its usual share of the time.
pub struct Experiment {
    /// Name, as `--only` takes it.
    pub name: &'static str,
    /// In a few words.
    pub title: &'static str,
    share: f32,
    run: fn(&Lab) -> Result<Section>,
}

/// All experiments in the order of the report.
pub static EXPERIMENTS: [Experiment; 4] = [
    Experiment {
        name: "transmittance",
        title: "Light through a slab of hairs: strands and march against Beer and Lambert",
        share: 2.0,
        run: transmittance::run,
    },
    Experiment {
        name: "furnace",
        title: "White hairs in white light: fibre models and path tracer",
        share: 2.0,
        run: furnace::run,
    },
    Experiment {
        name: "volume",
        title: "Undercoat as a volume against the same hairs as strands, scattered once",
        share: 6.0,
        run: volume::run,
    },
    Experiment { name: "hybrid", title: "Hybrid fur against path tracing", share: 16.0, run: hybrid::run },
];

/// Makes the experiments and writes `report.html`, `report.json` and pictures. The report is written anew after each of them.
///
/// # Errors
/// [`Error::Usage`] for an unknown name or where the repository's scenes are not found, [`Error::Interrupted`], [`Error::Io`], and
/// those of rendering.
pub fn run(options: &Options, progress: &(dyn Fn(Progress) + Sync), cancel: &AtomicBool) -> Result<Report> {
    let chosen: Vec<&Experiment> = match &options.only[..] {
        [] => EXPERIMENTS.iter().collect(),
        names => names.iter().map(|name| find(name)).collect::<Result<_>>()?,
    };
    std::fs::create_dir_all(&options.out)
        .map_err(|e| Error::io(&options.out, format!("cannot be made: {e}")))?;
    let gpu = pelage_render::open()?;
    let started = Instant::now();
    let mut report = Report {
        provenance: Provenance::of(&gpu),
        threads: rayon::current_num_threads(),
        level: options.level,
        seconds: 0.0,
        sections: Vec::new(),
    };
    let all: f32 = chosen.iter().map(|experiment| experiment.share).sum();
    let mut done = 0.0;
    for experiment in chosen {
        let begin = Instant::now();
        let [base, span] = [done, experiment.share].map(|share| share / all);
        let show = |part: f32| progress(Progress { done: base + span * part, stage: experiment.name });
        show(0.0);
        let lab = Lab::new(&gpu, options, &show, cancel);
        let mut section = (experiment.run)(&lab)?;
        section.name = experiment.name.to_owned();
        section.title = experiment.title.to_owned();
        section.seconds = begin.elapsed().as_secs_f64();
        report.sections.push(section);
        report.seconds = started.elapsed().as_secs_f64();
        write(&report, options)?;
        done += experiment.share;
    }
    progress(Progress { done: 1.0, stage: "report" });
    Ok(report)
}

fn find(name: &str) -> Result<&'static Experiment> {
    EXPERIMENTS.iter().find(|experiment| experiment.name == name).ok_or_else(|| {
        let names: Vec<_> = EXPERIMENTS.iter().map(|experiment| experiment.name).collect();
        Error::Usage(format!("there is no experiment {name:?}; there are {}", names.join(", ")))
    })
}

/// Writes `report.html` and `report.json`, each whole or not at all.
///
/// # Errors
/// [`Error::Io`].
pub fn write(report: &Report, options: &Options) -> Result<()> {
    write_json(&options.out.join("report.json"), report)?;
    let text = html::page(report);
    pelage_core::files::write_atomically(&options.out.join("report.html"), |file| {
        Ok(std::io::Write::write_all(file, text.as_bytes())?)
    })
}
