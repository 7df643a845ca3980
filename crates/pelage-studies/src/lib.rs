//! Figures, benchmarks, validation, comparison of images, and their reports.
//!
//! Nothing here renders on its own: all measurements and pictures come from
//! [`pelage_shells::render_on`] and [`pelage_pathtrace`].

pub mod bench;
pub mod compare;
pub mod figure;
pub mod provenance;
mod rendering;
pub mod report;
pub mod validate;
