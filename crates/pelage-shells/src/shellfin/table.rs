//! Hair lighting by table.

use pelage_core::scene::LightingTable;
use pelage_fur::layout;

/// Entries along each axis of the table.
pub const EDGE: usize = 32;

/// Reflected light of a hair, per unit colour and irradiance; `u` = T·L, `v` = T·H.
// [Lengyel2001] sec. 2.4; [Banks1994]
pub fn hair_lighting(t: &LightingTable, u: f32, v: f32) -> f32 {
    let lobe = |x: f32, exponent: f32| (1.0 - x * x).max(0.0).powf(0.5 * exponent);
    t.ambient + t.diffuse * lobe(u, t.diffuse_exponent) + t.specular * lobe(v, t.specular_exponent)
}

/// The table of 32 x 32 entries, packed four to a vector as the shader reads it; u varies along
/// rows from −1 to 1, v from row to row.
pub fn lighting_table(t: &LightingTable) -> layout::LightingTable {
    let at = |i: usize| 2.0 * i as f32 / (EDGE - 1) as f32 - 1.0;
    let mut values = [[0.0; 4]; EDGE * EDGE / 4];
    for i in 0..EDGE * EDGE {
        values[i / 4][i % 4] = hair_lighting(t, at(i % EDGE), at(i / EDGE));
    }
    layout::LightingTable { values }
}
