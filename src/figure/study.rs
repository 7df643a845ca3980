//! Figures that are more than scenes side by side: each study is a function from a [`Stage`] to a [`Made`].

mod canvas;
mod hair_textures;
mod lapped;
mod profiles;
mod shell_rates;
mod silhouette;
mod texture_memory;
mod times;

use super::{Made, Stage};
use crate::Result;

/// A study.
pub type Study = fn(&Stage) -> Result<Made>;

/// All studies, by the names that `figure.toml` calls them.
pub static STUDIES: &[(&str, Study)] = &[
    ("hair_textures", hair_textures::make),
    ("lapped", lapped::make),
    ("offset_shells", silhouette::shells),
    ("profiles", profiles::make),
    ("shell_rates", shell_rates::make),
    ("silhouette", silhouette::make),
    ("texture_memory", texture_memory::make),
    ("times", times::make),
];

/// The study of a name.
pub fn find(name: &str) -> Option<Study> {
    STUDIES.iter().find(|(known, _)| *known == name).map(|(_, study)| *study)
}
