//! Time and memory by the number of guard hairs, and the number of hairs that take as long as the
//! undercoat.

use super::super::{FigureContent, FigureContext};
use crate::bench::sweep::Sweep;
use crate::bench::{Times, mebibytes, paper, repeat, steps_ms};
use crate::report::plot::{Curve, Plot};
use crate::report::{Table, number};
use pelage_core::Result;
use pelage_core::scene::FurLayers;
use pelage_core::stats::Stats;
use pelage_render::FRAGMENT_BYTES;
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    scene: String,
    /// Renderings of each variant.
    runs: u32,
    /// Undercoat hairs that the volume of the paper's pelt replaces.
    undercoat: f64,
}

pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let settings: Settings = context.settings()?;
    let (mut world, _) = context.load(&settings.scene, &[])?;
    world.scene.render.fur = FurLayers::Explicit;
    let table = Sweep::Strands.measure(context.gpu, &world, "pelt", settings.runs)?;
    world.scene.render.fur = FurLayers::Implicit;
    let undercoat = repeat(context.gpu, &world, settings.runs)?;
    let march = Times::of(undercoat.iter().map(|s| steps_ms(s, &[4, 7]))).map_or(f64::NAN, |t| t.min);
    let mut content = FigureContent::default();
    let mut measured = Vec::new();
    for row in &table.rows {
        let Some(stats) = &row.stats else { continue };
        content.value(&format!("{}: guard hairs", row.label), stats.strands as f64, 0.0);
        let fragments = stats.fragments as f64;
        content.value(&format!("{}: fragments", row.label), fragments, 0.01 * fragments);
        measured.push((row.label.clone(), stats.clone(), row.ms.map_or(f64::NAN, |t| t.min)));
    }
    let strands = |s: &Stats| s.strands as f64;
    let curve = |name: &str, y: &dyn Fn(&Stats) -> f64| {
        Curve::new(name, measured.iter().map(|(_, s, _)| [strands(s), y(s)]).collect())
    };
    let ends = |y: f64| {
        let at = |i: usize| measured.get(i).map_or(1.0, |(_, s, _)| strands(s));
        vec![[at(0), y], [at(measured.len().saturating_sub(1)), y]]
    };
    let ms = |step: u32| move |s: &Stats| steps_ms(s, &[step]).unwrap_or(f64::NAN);
    content.plot(
        "time",
        Plot {
            caption: "Time of the steps against the number of guard hairs, no undercoat".into(),
            x: "guard hairs".into(),
            y: "ms".into(),
            log: [true, true],
            curves: vec![
                Curve::new(
                    "hairs: generate, rasterise, blend (3, 6, 7)",
                    measured.iter().map(|(_, s, ms)| [strands(s), *ms]).collect(),
                ),
                curve("3 generate", &ms(3)),
                curve("6 rasterise", &ms(6)),
                curve("7 blend", &ms(7)),
                Curve::new("undercoat as a volume, no hairs (4, 7)", ends(march)),
            ],
        },
    );
    content.plot(
        "memory",
        Plot {
            caption: "Memory of hairs and fragments".into(),
            x: "guard hairs".into(),
            y: "MiB".into(),
            log: [true, true],
            curves: vec![
                curve("strand geometry (3)", &|s| strand_mebibytes(s)),
                curve("all fragments of the picture", &|s| mebibytes(s.fragments * FRAGMENT_BYTES)),
                curve("most at once", &|s| mebibytes(s.gpu_peak_bytes)),
            ],
        },
    );
    let head =
        ["", "guard hairs", "steps 3, 6, 7, ms", "µs a hair", "times the first", "fragments a hair", "tiles"];
    let row = |(label, s, ms): &(String, Stats, f64)| {
        vec![
            label.clone(),
            s.strands.to_string(),
            format!("{ms:.1}"),
            number(1e3 * ms / strands(s)),
            format!("{:.2}", ms / measured[0].2),
            format!("{:.1}", s.fragments as f64 / strands(s)),
            s.tiles.to_string(),
        ]
    };
    content.table(&Table::new("Guard hairs alone:", &head, measured.iter().map(row).collect()));
    content.table(&exchange(&settings, &measured, march));
    Ok(content)
}

/// The number of hairs that cost as much as the volume, which the paper also compares.
fn exchange(settings: &Settings, measured: &[(String, Stats, f64)], march: f64) -> Table {
    // Time of one more hair, from the ends of the curve.
    let slope = match (measured.first(), measured.last()) {
        (Some((_, a, from)), Some((_, b, to))) => (to - from) / (b.strands as f64 - a.strands as f64),
        _ => f64::NAN,
    };
    let line = |what: &str, ours: f64, paper: Option<f64>| {
        vec![what.to_owned(), format!("{ours:.0}"), paper.map_or(String::new(), |p| format!("{p:.0}"))]
    };
    // [Andersen2016] table 1: step 4 of the cylinder; sec. 5: the 82,432 undercoat strands that the
    // same time would buy. The paper does not count the guard hairs of its pelt.
    let paper_march = paper::column("cylinder").map(|c| c.ms[3]);
    let bought = march / slope;
    let rows = vec![
        line("time of the undercoat as a volume, ms", march, paper_march),
        line("hairs that the same time would add", bought, Some(82_432.0)),
        line("undercoat hairs that the volume stands for", settings.undercoat, Some(3.8e6)),
        line("times as many as could be bought", settings.undercoat / bought, Some(3.8e6 / 82_432.0)),
    ];
    Table::new("What the time of the undercoat would buy:", &["", "here", "paper"], rows)
}

/// MiB of the buffers of step 3.
fn strand_mebibytes(stats: &Stats) -> f64 {
    stats.steps.iter().find(|s| s.step == 3).map_or(f64::NAN, |s| mebibytes(s.bytes))
}
