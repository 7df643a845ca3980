//! The two layers of a coat.

/// Which layer of the coat a hair belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layer {
    /// Guard hairs.
    Guard,
    /// Undercoat.
    Undercoat,
}
