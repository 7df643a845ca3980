//! Figures that are more than scenes side by side: each study is a function from a [`Stage`] to a [`Made`].

mod boxes;
mod fragments;
mod index;
mod keys;
mod march;
mod pipeline;
mod strand_count;
mod subelements;
mod times;
mod tree;
mod virtual_fragments;

use super::{Made, Stage};
use crate::Result;

/// A study.
pub type Study = fn(&Stage) -> Result<Made>;

/// All studies, by the names that `figure.toml` calls them.
pub static STUDIES: &[(&str, Study)] = &[
    ("fragments", fragments::make),
    ("index", index::make),
    ("keys", keys::make),
    ("march", march::make),
    ("pipeline", pipeline::make),
    ("strand_count", strand_count::make),
    ("times", times::make),
    ("tree", tree::make),
    ("virtual_fragments", virtual_fragments::make),
];

/// The study of a name.
pub fn find(name: &str) -> Option<Study> {
    STUDIES.iter().find(|(known, _)| *known == name).map(|(_, study)| *study)
}
