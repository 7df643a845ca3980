//! CPU twins: what each pass computes, once more in plain Rust.
//!
//! A twin has the stem of its shader: `reference/hair_roots.rs` says what `shaders/hair_roots.wgsl` does, and
//! `tests/hair_roots.rs` holds the two against each other, buffer by buffer, so that the first wrong pass names itself.
//! The other modules (`hash`, `octahedral`, `noise`, `shell`, `lattice`, `undercoat`, `groom`, `strands`, `view`) are twins of
//! `shaders/shared/`. A twin reads the same packed structs of [`pelage_fur::layout`] as its shader. It is written for
//! reading, not for speed: single precision where the shader's own arithmetic is meant, double precision where it
//! stands as an oracle.

pub mod base_raster;
pub mod edge_table;
pub mod film;
pub mod guard_bins;
pub mod guard_raster;
pub mod guard_shade;
pub mod guard_splat;
pub mod lattice;
pub mod light_occlusion;
pub mod resolve;
pub mod shell_entry;
pub mod shell_lattice;
pub mod undercoat_density;
pub mod undercoat_light;
pub mod undercoat_march;
pub mod undercoat_source;
