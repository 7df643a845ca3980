//! Frames per second of shells and fins, beside those of a paper.

use super::super::{FigureContent, FigureContext};
use crate::bench::shells::Row;
use crate::report::Table;
use pelage_core::{Error, Result};
use pelage_shells::lapped;
use pelage_shells::shellfin::edges;
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// Pixels of the image, one sample each.
    size: [u32; 2],
    /// Frames of each model.
    runs: u32,
    /// Models that are measured.
    models: Vec<Model>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Model {
    /// Name in the table.
    name: String,
    /// Scene file, relative to the figure's folder.
    scene: String,
    /// Figures from the paper.
    paper: Paper,
}

/// A model's row in the paper.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Paper {
    name: String,
    faces: u32,
    edges: u32,
    patches: u32,
    /// Frames per second with half of the layers, and with all.
    fps: [f64; 2],
}

pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let settings: Settings = context.settings()?;
    let [width, height] = settings.size;
    let set = [
        format!("film.width={width}"),
        format!("film.height={height}"),
        "film.spp=1".to_owned(),
        "render.fur=shells".to_owned(),
    ];
    let mut content = FigureContent::default();
    let mut rows = Vec::new();
    for model in &settings.models {
        let (world, _) = context.load(&model.scene, &set)?;
        let patches = lapped::lap(&world.skin, &world.scene)?.patches.len();
        let all = Row::measure(context.gpu, &world, &model.name, settings.runs)?;
        let half = all.with_layers(&world, (all.shells / 2).max(1));
        let half = Row::measure(context.gpu, &half, &model.name, settings.runs)?;
        if half.shells * 2 != all.shells {
            return Err(Error::Unsupported(format!(
                "{}: {} shells are not half of {}",
                model.name, half.shells, all.shells
            )));
        }
        context.report(&format!(
            "{}: {:.1} and {:.1} frames a second",
            model.name, half.fps.median, all.fps.median
        ))?;
        let p = &model.paper;
        rows.push(vec![
            format!("{}, ours", model.name),
            all.triangles.to_string(),
            edges(&world.skin).len().to_string(),
            patches.to_string(),
            all.shells.to_string(),
            format!("{:.1}", half.fps.median),
            format!("{:.1}", all.fps.median),
            format!("{:.2}", half.fps.median / all.fps.median),
        ]);
        rows.push(vec![
            format!("{}, paper", p.name),
            p.faces.to_string(),
            p.edges.to_string(),
            p.patches.to_string(),
            all.shells.to_string(),
            format!("{}", p.fps[0]),
            format!("{}", p.fps[1]),
            format!("{:.2}", p.fps[0] / p.fps[1]),
        ]);
        content.value(&format!("{}: faces", model.name), f64::from(all.triangles), 0.0);
        content.value(&format!("{}: edges", model.name), edges(&world.skin).len() as f64, 0.0);
        content.value(&format!("{}: patches", model.name), patches as f64, 5.0);
    }
    let head = [
        "model",
        "faces",
        "edges",
        "patches",
        "layers",
        "half of the layers, frames/s",
        "all layers, frames/s",
        "half by all",
    ];
    let caption = format!(
        "Median of {} frames of {width} x {height} pixels here; the paper does not say how large its pictures are.",
        settings.runs
    );
    content.table(&Table::new(caption, &head, rows));
    Ok(content)
}
