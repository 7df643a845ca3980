//! CPU twins: plain-Rust versions of the passes, for tests to compare with.
//!
//! A twin has the stem of its shader: `twin/guard_bins.rs` computes what `shaders/guard_bins.wgsl`
//! does, and `tests/guard_bins.rs` compares the two buffer by buffer, so that the first wrong pass
//! identifies itself. [`lattice`] is the twin of files in `shaders/shared/`; the twins of the
//! others, and of `hair_roots`, `guard_strands` and `shell_prisms`, are in `pelage-fur`. A twin
//! reads the same packed structs of [`pelage_fur::layout`] as its shader. It is written for
//! clarity, not for speed: in single precision where it follows the shader's arithmetic, in double
//! precision where it serves as an oracle.

pub mod base_raster;
pub mod edge_table;
pub mod film;
pub mod guard_bins;
pub mod guard_raster;
pub mod guard_shade;
pub mod guard_splat;
pub mod lattice;
pub mod light_occlusion;
pub mod objects;
pub mod resolve;
pub mod shell_entry;
pub mod shell_lattice;
pub mod undercoat_density;
pub mod undercoat_light;
pub mod undercoat_march;
pub mod undercoat_source;
