//! Twin of `shaders/shell_lattice.wgsl`: what the columns of the light lattice know of the skin below them.

use super::groom::{Maps, Parameter, skin_point};
use super::lattice::{column_spot, pack_albedo};
use super::shell::Shell;
use crate::layout::{Column, Fur};

/// `columns` with density factor and colours set; corner and area are taken from them.
pub fn columns(shell: &Shell, fur: &Fur, maps: &Maps<'_>, columns: &[Column]) -> Vec<Column> {
    columns
        .iter()
        .enumerate()
        .map(|(i, column)| {
            let (prism, lambda) = column_spot(fur, i as u32, column.corner);
            let at = skin_point(shell, prism, lambda);
            Column {
                density: maps.scalar(Parameter::UndercoatDensity, &at) / fur.density,
                color_root: pack_albedo(maps.color(Parameter::UndercoatColorRoot, &at)),
                color_tip: pack_albedo(maps.color(Parameter::UndercoatColorTip, &at)),
                color_base: pack_albedo(maps.color(Parameter::BaseColor, &at)),
                ..*column
            }
        })
        .collect()
}
