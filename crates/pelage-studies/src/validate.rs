//! Errors of the approximations against the ground truth, with goals, in a report.
//!
//! An experiment is a function from a [`Lab`] to a [`Section`] of plain data: findings with their
//! goals, tables, curves, and pictures. [`run`] collects the sections in a [`Report`], and [`html`]
//! writes it. The approximations are those of [`pelage_render`], the ground truth is
//! [`pelage_pathtrace`].

pub mod furnace;
pub mod html;
pub mod hybrid;
mod lab;
pub mod transmittance;
pub mod volume;

pub use lab::Lab;

use crate::provenance::{Provenance, write_json, write_text};
use crate::report::plot::Plot;
use crate::report::{self, Table};
use pelage_core::{Error, Result};
use pelage_render::Progress;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Extent of a validation.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// A few minutes: fewer cases, smaller and noisier images. The goals are the same.
    Quick,
    /// At most half an hour on two cores.
    #[default]
    Usual,
    /// All cases, larger images, more samples.
    Full,
}

/// Settings of a validation.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Extent.
    pub level: Level,
    /// Folder of the report.
    pub out: PathBuf,
    /// Names of experiments; empty: all.
    pub only: Vec<String>,
    /// Parts of case names, for the experiments that compare images; empty: all.
    pub cases: Vec<String>,
}

/// A condition on a value.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Goal {
    /// At most this.
    AtMost(f64),
    /// At least this.
    AtLeast(f64),
    /// 1 ± this.
    OneWithin(f64),
}

impl Goal {
    /// Whether `value` meets the goal; NaN does not.
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
    /// The approximation, or the model.
    pub approximation: String,
    /// The case in which it was measured.
    pub case: String,
    /// Name of the metric.
    pub metric: String,
    /// Value of the metric.
    pub value: f64,
    /// Goal; `None`: the value is only reported.
    pub goal: Option<Goal>,
    /// Whether the goal is met; `None` without a goal.
    pub met: Option<bool>,
    /// Time to compute the approximation, s; `None` if it is not meaningful.
    pub seconds: Option<f64>,
}

impl Finding {
    /// A value with its goal.
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

    /// Sets the time taken, s.
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

/// A table and the pictures that belong to it.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Exhibit {
    /// Table, if any.
    pub table: Option<Table>,
    /// Pictures, shown side by side.
    pub pictures: Vec<Picture>,
}

/// The results of one experiment.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Section {
    /// Name, as `--only` takes it.
    pub name: String,
    /// Heading.
    pub title: String,
    /// Paragraphs about what is measured, how, and with which limits.
    pub text: Vec<String>,
    /// Findings.
    pub findings: Vec<Finding>,
    /// Curves.
    pub plots: Vec<Plot>,
    /// Tables and pictures.
    pub exhibits: Vec<Exhibit>,
    /// Cases that were left out, with the reason.
    pub skipped: Vec<String>,
    /// Time taken, s.
    pub seconds: f64,
}

/// Results of a validation.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// Adapter, driver, version, date, command.
    pub provenance: Provenance,
    /// Number of CPU threads.
    pub threads: usize,
    /// Extent.
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
    /// [`Error::GoalMissed`] with the goals that are missed.
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

/// An experiment.
pub struct Experiment {
    /// Name, as `--only` takes it.
    pub name: &'static str,
    /// Heading of its section.
    pub title: &'static str,
    /// Usual share of the total time.
    share: f32,
    run: fn(&Lab) -> Result<Section>,
}

/// All experiments, in the order of the report.
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

/// Runs the experiments and writes `report.html`, `report.json` and pictures. The report is
/// rewritten after each experiment.
///
/// # Errors
/// [`Error::Usage`] for an unknown name or if the repository's scenes are not found;
/// [`Error::Interrupted`]; [`Error::Io`]; those of rendering.
pub fn run(options: &Options, progress: &(dyn Fn(Progress) + Sync), cancel: &AtomicBool) -> Result<Report> {
    let chosen: Vec<&Experiment> = match &options.only[..] {
        [] => EXPERIMENTS.iter().collect(),
        names => names.iter().map(|name| find(name)).collect::<Result<_>>()?,
    };
    std::fs::create_dir_all(&options.out)
        .map_err(|e| Error::io(&options.out, format!("cannot be created: {e}")))?;
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
    write_text(&options.out.join("report.html"), &html::page(report))
}
