//! `pelage schema`.

use super::output;
use pelage::{Result, scene};

/// Prints the JSON schema of scene files.
pub(super) fn run() -> Result<()> {
    output::print_json(scene::json_schema())
}
