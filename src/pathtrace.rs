//! The ground truth: the same fur with every hair a strand, path traced on the CPU.
//!
//! A world becomes [`strands::Strands`], guard hairs and undercoat alike; nothing of the shell or the light lattice is used.

pub mod grow;
mod guard;
pub mod shell;
pub mod strands;
mod undercoat;
