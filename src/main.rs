//! pelage
fn main() {}
