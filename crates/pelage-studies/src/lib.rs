//! Figures, benchmarks, validation, comparison of images, and their reports.

pub mod bench;
pub mod compare;
pub mod figure;
pub mod provenance;
pub mod report;
pub mod validate;
