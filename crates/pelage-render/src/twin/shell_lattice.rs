//! Twin of `shaders/shell_lattice.wgsl`: attributes of the skin below the columns of the
//! optical-depth lattice.

use crate::twin::lattice::{column_lambda, pack_albedo};
use pelage_fur::layout::{Column, FurParameters};
use pelage_fur::parameters::{Maps, Parameter, skin_point};
use pelage_fur::shell::Shell;

/// `column` with density factor and colours set.
pub fn column(shell: &Shell, fur: &FurParameters, maps: &Maps<'_>, column: &Column) -> Column {
    let at = skin_point(shell, column.prism, column_lambda(fur, column));
    Column {
        density: maps.scalar(Parameter::UndercoatDensity, &at) / fur.undercoat.density,
        color_root: pack_albedo(maps.color(Parameter::UndercoatColorRoot, &at)),
        color_tip: pack_albedo(maps.color(Parameter::UndercoatColorTip, &at)),
        color_base: pack_albedo(maps.color(Parameter::BaseColor, &at)),
        ..*column
    }
}
