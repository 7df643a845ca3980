//! The two layers of a coat.

/// The layer of the coat that a hair belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layer {
    /// Guard hairs.
    Guard,
    /// Undercoat.
    Undercoat,
}
