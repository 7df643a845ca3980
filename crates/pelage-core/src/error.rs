//! The error type of all crates. A message says where the fault is, what was found, what was
//! expected and what to do.

use std::path::{Path, PathBuf};

/// Result with [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Everything that can go wrong. Each variant leads to an exit code of the process.
#[derive(Debug, Clone, thiserror::Error)]
pub enum Error {
    /// Reading or writing a file failed (exit code 1).
    #[error("{}: {reason}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What went wrong and what to do about it.
        reason: String,
    },
    /// A command or a function was used wrongly (exit code 2).
    #[error("{0}")]
    Usage(String),
    /// The scene, or an asset that it names, is not valid (exit code 3). All faults of a file are
    /// reported together.
    #[error("{}", shown_faults(.0).join("\n"))]
    Scene(Vec<SceneFault>),
    /// There is no adapter, or its limits are too low (exit code 4).
    #[error("{0}")]
    Adapter(String),
    /// The device was lost (exit code 5).
    #[error("the GPU device was lost during {during}: {reason}")]
    DeviceLost {
        /// The pass or step.
        during: String,
        /// The driver's message.
        reason: String,
    },
    /// A GPU pass failed: validation, allocation (exit code 1).
    #[error("{pass}: {reason}")]
    Gpu {
        /// The stem of the pass.
        pass: String,
        /// What went wrong.
        reason: String,
    },
    /// The GPU ran out of memory in a pass whose tiles could not be split further (exit code 1).
    #[error("{pass}: out of GPU memory ({needed} bytes needed): raise --memory or lower the resolution")]
    OutOfMemory {
        /// The stem of the pass.
        pass: String,
        /// Bytes requested.
        needed: u64,
    },
    /// The user interrupted (exit code 130).
    #[error("interrupted")]
    Interrupted,
    /// A comparison exceeded its threshold, or a goal of the validation was missed (exit code 1).
    #[error("{0}")]
    GoalMissed(String),
    /// The request cannot be carried out with this input (exit code 1).
    #[error("{0}")]
    Unsupported(String),
    /// A value cannot be written as JSON or TOML (exit code 1).
    #[error("{0}")]
    Encoding(String),
}

/// Largest number of faults that are shown; further ones are counted.
pub const MAX_SHOWN_FAULTS: usize = 20;

/// The text of each fault, of [`MAX_SHOWN_FAULTS`] at most, and then how many there are more.
pub fn shown_faults(faults: &[SceneFault]) -> Vec<String> {
    let mut shown: Vec<String> = faults.iter().take(MAX_SHOWN_FAULTS).map(ToString::to_string).collect();
    let more = (faults.len() - shown.len()).to_string();
    if more != "0" {
        let digits = more.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy).collect::<Vec<_>>();
        shown.push(format!("and {} more", digits.join(",")));
    }
    shown
}

/// One fault of a scene file or an asset, with its position. It is displayed as
/// `FILE:LINE:COLUMN: MESSAGE` and a line `help: HELP`.
#[derive(Debug, Clone, PartialEq)]
pub struct SceneFault {
    /// The file with the fault, or what stands for it: a command-line flag, a key of the scene.
    pub file: PathBuf,
    /// Line, from 1; 0 if the fault has no line.
    pub line: usize,
    /// Column, from 1; 0 if unknown.
    pub column: usize,
    /// What was found and what was expected.
    pub message: String,
    /// What to do, if there is something to suggest.
    pub help: Option<String>,
}

impl std::fmt::Display for SceneFault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.file.display())?;
        if self.line > 0 {
            write!(f, ":{}", self.line)?;
            if self.column > 0 {
                write!(f, ":{}", self.column)?;
            }
        }
        write!(f, ": {}", self.message)?;
        if let Some(help) = &self.help {
            write!(f, "\n  help: {help}")?;
        }
        Ok(())
    }
}

impl Error {
    /// An I/O error of `path`.
    pub fn io(path: impl AsRef<Path>, reason: impl std::fmt::Display) -> Self {
        Self::Io { path: path.as_ref().to_owned(), reason: reason.to_string() }
    }

    /// A single fault without a line.
    pub fn fault(file: impl AsRef<Path>, message: impl Into<String>) -> Self {
        Self::fault_at(file, 0, message)
    }

    /// A single fault at a line.
    pub fn fault_at(file: impl AsRef<Path>, line: usize, message: impl Into<String>) -> Self {
        Self::Scene(vec![SceneFault {
            file: file.as_ref().to_owned(),
            line,
            column: 0,
            message: message.into(),
            help: None,
        }])
    }

    /// A failure of the GPU pass with stem `pass`.
    pub fn gpu(pass: impl Into<String>, reason: impl std::fmt::Display) -> Self {
        Self::Gpu { pass: pass.into(), reason: reason.to_string() }
    }

    /// The process exit code: 1 render or I/O failed; 2 usage; 3 scene invalid; 4 no adapter or its
    /// limits; 5 device lost; 130 interrupted.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Io { .. } | Self::Gpu { .. } | Self::OutOfMemory { .. } => 1,
            Self::GoalMissed(_) | Self::Unsupported(_) | Self::Encoding(_) => 1,
            Self::Usage(_) => 2,
            Self::Scene(_) => 3,
            Self::Adapter(_) => 4,
            Self::DeviceLost { .. } => 5,
            Self::Interrupted => 130,
        }
    }
}
