//! The amount of hair in each texture layer of each panel, by height.

use super::super::{FigureContent, FigureContext};
use crate::report::plot::{Curve, Plot};
use crate::report::{Table, number};
use pelage_core::Result;
use pelage_shells::bake;

pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let mut content = FigureContent::default();
    let mut curves = Vec::new();
    let mut rows = Vec::new();
    for panel in &context.figure.panels {
        let Some(scene) = &panel.scene else { continue };
        let (world, _) = context.load(scene, &panel.set)?;
        let manifest = bake::bake(&world)?.manifest;
        let depths: Vec<f64> = manifest.summary.iter().map(|l| f64::from(l.optical_depth)).collect();
        let innermost = depths.first().copied().unwrap_or_default().max(1e-9);
        let last = (depths.len().max(2) - 1) as f64;
        let part = |l: usize| depths.get(l).map_or(0.0, |d| d / innermost);
        let points = (0..depths.len()).map(|l| [l as f64 / last, part(l)]).collect();
        curves.push(Curve::new(&panel.label, points));
        let [quarter, half] = [0.25, 0.5].map(|h: f64| part((h * last).round() as usize));
        let all = depths.iter().sum::<f64>() / innermost / depths.len().max(1) as f64;
        rows.push(vec![panel.label.clone(), number(quarter), number(half), number(all)]);
        content.value(&format!("{}: left at half of the height", panel.label), half, 0.002);
    }
    content.plot(
        "profiles",
        Plot {
            caption: "Hair in each layer, by that of the innermost".into(),
            x: "height, 0 skin to 1 tip".into(),
            y: "part of the hairs".into(),
            curves,
            ..Plot::default()
        },
    );
    let head = ["profile", "left at a quarter", "left at half", "mean over the height"];
    content.table(&Table::new("", &head, rows));
    Ok(content)
}
