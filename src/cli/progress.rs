//! Progress on stderr.

use indicatif::{ProgressBar, ProgressStyle};
use pelage::render::Progress;
use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Style of the progress display.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Style {
    /// No progress
    None,
    /// A bar with the remaining time; lines of text if stderr is not a terminal
    Bar,
    /// A line of text every few seconds
    Text,
}

/// The progress display of a rendering.
pub(super) enum Display {
    Hidden,
    Bar(ProgressBar),
    Text(Mutex<Text>),
}

/// State of a display in lines of text.
pub(super) struct Text {
    start: Instant,
    last: Option<Instant>,
}

const STEPS: u64 = 1000;
const INTERVAL: Duration = Duration::from_secs(2);

impl Display {
    /// A display of `style`, as far as stderr supports it; by default a bar on a terminal, nothing
    /// otherwise.
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

    /// Shows the progress.
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

    /// Removes the bar.
    pub fn finish(&self) {
        if let Self::Bar(bar) = self {
            bar.finish_and_clear();
        }
    }
}
