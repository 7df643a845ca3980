//! Measurements from papers: Table 1 of Andersen et al. 2016 (Quadro K6000, 3840 x 2274, one
//! frame), and the bunny of Lengyel et al. 2001.

use serde::Serialize;

/// A column of the table.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Column {
    /// Name of our scene file without folder and extension.
    pub scene: &'static str,
    /// Triangles of the skin.
    pub triangles: u32,
    /// Milliseconds of steps 1 to 7.
    pub ms: [f64; 7],
    /// Gigabytes of steps 1 to 7; the paper has none for step 7.
    pub gigabytes: [Option<f64>; 7],
    /// Milliseconds of steps 1 to 3, as printed.
    pub preprocessing_ms: f64,
    /// Milliseconds of steps 4 to 7, as printed.
    pub online_ms: f64,
    /// Gigabytes altogether, as printed.
    pub total_gigabytes: f64,
}

/// Table 1 of the paper. As here, the shell is step 4 and the base mesh step 5; the paper's text
/// numbers them the other way round.
// [Andersen2016] table 1
pub const TABLE_1: [Column; 3] = [
    Column {
        scene: "cylinder",
        triangles: 3584,
        ms: [0.2, 2405.0, 1.1, 635.0, 87.6, 428.0, 255.0],
        gigabytes: [Some(0.37), Some(1.06), Some(0.06), Some(0.20), Some(0.20), Some(2.60), None],
        preprocessing_ms: 2406.0,
        online_ms: 1407.0,
        total_gigabytes: 4.49,
    },
    Column {
        scene: "hat",
        triangles: 5632,
        ms: [1.7, 1740.0, 8.0, 519.0, 139.0, 1270.0, 812.0],
        gigabytes: [Some(0.33), Some(0.77), Some(0.52), Some(0.20), Some(0.20), Some(2.60), None],
        preprocessing_ms: 1750.0,
        online_ms: 2740.0,
        total_gigabytes: 4.62,
    },
    Column {
        scene: "bunny",
        triangles: 69_451,
        ms: [1.4, 1327.0, 4.3, 755.0, 147.0, 795.0, 447.0],
        gigabytes: [Some(0.37), Some(0.59), Some(0.28), Some(0.20), Some(0.20), Some(2.60), None],
        preprocessing_ms: 1333.0,
        online_ms: 2143.0,
        total_gigabytes: 4.24,
    },
];

/// Frames per second of shells and fins.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rates {
    /// The model.
    pub model: &'static str,
    /// Number of triangles.
    pub triangles: u32,
    /// Number of layers.
    pub layers: u32,
    /// Frames per second with all layers.
    pub fps_all: f64,
    /// Frames per second with half of the layers.
    pub fps_half: f64,
}

/// The bunny on a GeForce DDR and an AMD K7 of 700 MHz; the paper does not give the size of the
/// picture.
// [Lengyel2001] table 1
pub const LENGYEL_BUNNY: Rates =
    Rates { model: "bunny", triangles: 5000, layers: 16, fps_all: 12.0, fps_half: 23.0 };

/// The paper's column for a scene file, by its name without folder and extension.
pub fn column(scene: &str) -> Option<&'static Column> {
    TABLE_1.iter().find(|c| c.scene == scene)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_add_up_to_the_printed_sums() {
        for c in TABLE_1 {
            let pre: f64 = c.ms[..3].iter().sum();
            let online: f64 = c.ms[3..].iter().sum();
            let memory: f64 = c.gigabytes.iter().flatten().sum();
            assert!((pre - c.preprocessing_ms).abs() < 1.0, "{}: {pre}", c.scene);
            assert!((online - c.online_ms).abs() < 1.5, "{}: {online}", c.scene);
            assert!((memory - c.total_gigabytes).abs() < 0.005, "{}: {memory}", c.scene);
        }
    }
}
