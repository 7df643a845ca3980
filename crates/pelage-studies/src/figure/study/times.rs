//! Times and memory of the steps beside those of the paper's Table 1, as `pelage bench` measures them.

use super::{Made, Stage};
use crate::bench;
use pelage_core::Result;
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// Scene files, relative to the figure's folder.
    scenes: Vec<String>,
    /// Image sizes.
    sizes: Vec<[u32; 2]>,
    /// Renderings of each.
    runs: u32,
}

pub(super) fn make(stage: &Stage) -> Result<Made> {
    let settings: Settings = stage.settings()?;
    let options = bench::Options {
        scenes: settings.scenes.iter().map(|scene| stage.folder.join(scene)).collect(),
        sizes: settings.sizes,
        runs: settings.runs,
        ..bench::Options::default()
    };
    let mut made = Made::default();
    let report = bench::measure(&options, &mut |part| {
        made.text += part;
        stage.tell(part.lines().find(|line| !line.is_empty()).unwrap_or_default())
    })?;
    for column in &report.table {
        let of = |what: &str| format!("{}, {what}", column.scene);
        made.value(&of("guard hairs"), column.stats.strands as f64, 0.0);
        made.value(&of("memory in all, bytes"), column.total_bytes as f64, 0.05 * column.total_bytes as f64);
    }
    Ok(made)
}
