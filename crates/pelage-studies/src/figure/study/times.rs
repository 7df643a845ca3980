//! Times and memory of the steps, measured like those of `pelage bench`, beside the paper's Table
//! 1.

use super::{FigureContent, FigureContext};
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
    /// Renderings of each scene at each size.
    runs: u32,
}

pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let settings: Settings = context.settings()?;
    let options = bench::Options {
        scenes: settings.scenes.iter().map(|scene| context.folder.join(scene)).collect(),
        sizes: settings.sizes,
        runs: settings.runs,
        ..bench::Options::default()
    };
    let mut content = FigureContent::default();
    let report = bench::measure(&options, &mut |part| {
        content.text += part;
        context.report(part.lines().find(|line| !line.is_empty()).unwrap_or_default())
    })?;
    for column in &report.table {
        let of = |what: &str| format!("{}, {what}", column.scene);
        content.value(&of("guard hairs"), column.stats.strands as f64, 0.0);
        content.value(
            &of("memory in all, bytes"),
            column.total_bytes as f64,
            0.05 * column.total_bytes as f64,
        );
    }
    Ok(content)
}
