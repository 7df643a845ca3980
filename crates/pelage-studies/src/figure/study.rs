//! Figures that are more than scenes side by side. A study is a function from a [`FigureContext`]
//! to a [`FigureContent`].

mod boxes;
mod canvas;
mod environment;
mod errors;
mod fragments;
mod hair_textures;
mod index;
mod keys;
mod lapped;
mod march;
mod orbit;
mod pipeline;
mod profiles;
mod scaling;
mod shell_rates;
mod silhouette;
mod strand_count;
mod subelements;
mod texture_memory;
mod times;
mod tree;
mod virtual_fragments;

use super::{FigureContent, FigureContext};
use pelage_core::Result;

/// A study.
pub type Study = fn(&FigureContext) -> Result<FigureContent>;

/// All studies by the names that `figure.toml` uses.
pub static STUDIES: &[(&str, Study)] = &[
    ("environment", environment::make),
    ("errors", errors::make),
    ("fragments", fragments::make),
    ("hair_textures", hair_textures::make),
    ("index", index::make),
    ("keys", keys::make),
    ("lapped", lapped::make),
    ("march", march::make),
    ("offset_shells", silhouette::shells),
    ("orbit", orbit::make),
    ("pipeline", pipeline::make),
    ("profiles", profiles::make),
    ("scaling", scaling::make),
    ("shell_rates", shell_rates::make),
    ("silhouette", silhouette::make),
    ("strand_count", strand_count::make),
    ("texture_memory", texture_memory::make),
    ("times", times::make),
    ("tree", tree::make),
    ("virtual_fragments", virtual_fragments::make),
];

/// The study called `name`.
pub fn find(name: &str) -> Option<Study> {
    STUDIES.iter().find(|(known, _)| *known == name).map(|(_, study)| *study)
}
