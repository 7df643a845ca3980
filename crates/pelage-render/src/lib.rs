//! The hybrid renderer: passes, preparation, tiles, and the CPU twins that tests compare with.

pub mod driver;
pub mod passes;
pub mod plan;
pub mod prepare;
pub mod shaders;
pub mod strands;
pub mod tile;
pub mod twin;

pub use driver::{Frame, Progress, RenderOptions, Rendering, drive, drive_on, known_stats, run};
pub use plan::SamplePlan;
pub use shaders::open;
pub use tile::{FRAGMENT_BYTES, Job, write_tile};
