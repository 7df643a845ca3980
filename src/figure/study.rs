//! Figures that are more than scenes side by side: each study is a function from a [`Stage`] to a [`Made`].

mod times;

use super::{Made, Stage};
use crate::Result;

/// A study.
pub type Study = fn(&Stage) -> Result<Made>;

/// All studies, by the names that `figure.toml` calls them.
pub static STUDIES: &[(&str, Study)] = &[("times", times::make)];

/// The study of a name.
pub fn find(name: &str) -> Option<Study> {
    STUDIES.iter().find(|(known, _)| *known == name).map(|(_, study)| *study)
}
