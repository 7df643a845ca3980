//! The hybrid renderer: passes, preparation, tiles, and the CPU twins that tests compare with.

pub mod driver;
pub mod job;
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
