//! The passes of shells and fins.

pub mod shellfin_raster;
pub mod shellfin_rows;
