//! Progress on stderr.

use indicatif::{ProgressBar, ProgressStyle};
use pelage_render::Progress;
use std::{
    io::IsTerminal,
    sync::Mutex,
    time::{Duration, Instant},
};

/// How progress is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Style {
    /// Not at all.
    None,
    /// A bar with the time left; lines of text where stderr is no terminal.
    Bar,
    /// A line every few seconds.
    Text,
}

/// The display of one rendering.
pub(super) enum Display {
    Hidden,
    Bar(ProgressBar),
    Text(Mutex<Text>),
}

/// What the lines of text were last about.
pub(super) struct Text {
    start: Instant,
    last: Option<Instant>,
}

const STEPS: u64 = 1000;
const INTERVAL: Duration = Duration::from_secs(2);

impl Display {
    /// The display that was asked for, as far as stderr allows it.
    pub fn new(style: Option<Style>, quiet: bool) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let default = if terminal { Style::Bar } else { Style::None };
        match style.unwrap_or(default) {
            _ if quiet => Self::Hidden,
            Style::None => Self::Hidden,
            Style::Bar if terminal => {
                let bar = ProgressBar::new(STEPS);
                let style = ProgressStyle::with_template("{bar:40} {percent:>3}%  {eta} left  {msg}");
                bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
                Self::Bar(bar)
            }
            Style::Bar | Style::Text => Self::Text(Mutex::new(Text { start: Instant::now(), last: None })),
        }
    }

    /// Shows how far the rendering is.
    pub fn update(&self, progress: Progress) {
        let done = if progress.done.is_finite() { progress.done.clamp(0.0, 1.0) } else { 0.0 };
        match self {
            Self::Hidden => {}
            Self::Bar(bar) => {
                bar.set_position((done * STEPS as f32) as u64);
                bar.set_message(progress.stage);
            }
            Self::Text(text) => {
                let Ok(mut text) = text.lock() else { return };
                if text.last.is_some_and(|last| last.elapsed() < INTERVAL) && done < 1.0 {
                    return;
                }
                text.last = Some(Instant::now());
                let elapsed = text.start.elapsed().as_secs_f32();
                let left = if done > 0.0 {
                    format!("{:.0} s left", elapsed * (1.0 - done) / done)
                } else {
                    "time left unknown".into()
                };
                eprintln!("{:3.0}%  {left}  {}", done * 100.0, progress.stage);
            }
        }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}
