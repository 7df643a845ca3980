//! The hybrid renderer: passes, preparation, tiles, the CPU twins of the passes, and a probe that
//! reads every step back.

pub mod driver;
pub mod job;
pub mod mattes;
pub mod options;
pub mod passes;
pub mod plan;
pub mod planes;
pub mod prepare;
pub mod probe;
pub mod shaders;
pub mod strands;
pub mod tile;
pub mod tile_buffers;
pub mod twin;

pub use driver::{Frame, Rendering, drive, drive_on, known_stats, run};
pub use job::Job;
pub use options::{Progress, RenderOptions};
pub use plan::SamplePlan;
pub use planes::write_tile;
pub use shaders::open;
pub use tile_buffers::FRAGMENT_BYTES;
