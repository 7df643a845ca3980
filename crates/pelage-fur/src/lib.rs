//! The fur on the CPU: groom, strands, prism shell, noise, undercoat and fibre scattering. Each
//! formula stands here once.

pub mod arithmetic;
pub mod camera;
pub mod extent;
pub mod fibre;
pub mod groom;
pub mod guard_strands;
pub mod hair_roots;
pub mod layer;
pub mod layout;
pub mod material;
pub mod octahedral;
pub mod parameters;
pub mod random;
pub mod shell;
pub mod shell_prisms;
pub mod simplex;
pub mod strand_curve;
pub mod strands;
pub mod surface;
pub mod undercoat;
pub mod view;

pub use layer::Layer;
