//! Cost and benefit of virtual fragments: error, time and memory by their number.

use super::super::{FigureContent, FigureContext};
use crate::bench::steps_ms;
use crate::compare::{Comparison, compare};
use crate::report::plot::{Curve, Plot};
use crate::report::{Table, number};
use pelage_core::Result;
use pelage_core::stats::Stats;
use pelage_render::FRAGMENT_BYTES;
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    scene: String,
    /// Numbers of virtual fragments.
    numbers: Vec<u32>,
    /// Those that are also shown as pictures, beside simplified and exact blending.
    shown: Vec<u32>,
}

/// Measurements of a blending mode.
struct Row {
    name: String,
    number: Option<u32>,
    error: Comparison,
    stats: Stats,
}

/// Step 4 at 3840 x 2274 with one shell fragment a pixel and with 30 virtual fragments: number and
/// bytes.
// [Andersen2016]
const PAPER: [(f64, f64); 2] = [(1.0, 0.2e9), (30.0, 7.8e9)];
const PAPER_PIXELS: f64 = 3840.0 * 2274.0;

pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let settings: Settings = context.settings()?;
    let mut content = FigureContent::default();
    let render_panel = |label: &str, set: &[String]| {
        let (world, assets) = context.load(&settings.scene, set)?;
        context.gpu.ledger.reset_peaks();
        context.render_panel(label, &world, &assets)
    };
    let exact = render_panel("exact", &["render.blend=exact".into()])?;
    let mut rows = Vec::new();
    let simplified = render_panel("simplified, eq. 4", &["render.blend=simplified".into()])?;
    rows.push(Row {
        name: "simplified".into(),
        number: None,
        error: compare(&simplified.film, &exact.film)?,
        stats: simplified.stats.clone().unwrap_or_default(),
    });
    content.images.push(simplified);
    for x in &settings.numbers {
        let set = ["render.blend=virtual".into(), format!("render.virtual_fragments={x}")];
        let image = render_panel(&format!("virtual, x = {x}"), &set)?;
        rows.push(Row {
            name: format!("virtual, x = {x}"),
            number: Some(*x),
            error: compare(&image.film, &exact.film)?,
            stats: image.stats.clone().unwrap_or_default(),
        });
        if settings.shown.contains(x) {
            content.images.push(image);
        }
    }
    let reference = exact.stats.clone().unwrap_or_default();
    content.images.push(exact);
    for row in &rows {
        let (flip, rmse) = (row.error.all.flip, row.error.all.rmse);
        content.value(&format!("{}: mean FLIP against exact", row.name), flip, 0.1 * flip + 1e-3);
        content.value(&format!("{}: RMSE against exact", row.name), rmse, 0.1 * rmse + 1e-4);
        let fragments = row.stats.fragments as f64;
        content.value(&format!("{}: fragments", row.name), fragments, 0.01 * fragments);
    }
    plots(&mut content, &rows, &reference);
    content.table(&table(&rows, &reference));
    Ok(content)
}

/// Time of the steps that blending changes, ms.
fn time(stats: &Stats) -> f64 {
    steps_ms(stats, &[4, 6, 7]).unwrap_or(f64::NAN)
}

/// Fragments of all kinds per sample.
fn fragments(stats: &Stats) -> f64 {
    stats.fragments as f64 / samples(stats)
}

fn samples(stats: &Stats) -> f64 {
    f64::from(stats.width) * f64::from(stats.height) * f64::from(stats.spp.max(1))
}

fn plots(content: &mut FigureContent, rows: &[Row], exact: &Stats) {
    let of = |name: &str, y: &dyn Fn(&Row) -> f64| {
        let points = rows.iter().filter_map(|r| Some([f64::from(r.number?), y(r)])).collect();
        Curve::new(name, points)
    };
    let all: Vec<f64> = rows.iter().filter_map(|r| r.number.map(f64::from)).collect();
    let (first, last) = (all.first().copied().unwrap_or(1.0), all.last().copied().unwrap_or(1.0));
    let level = |name: &str, y: f64| Curve::new(name, vec![[first, y], [last, y]]);
    let simplified = rows.iter().find(|r| r.number.is_none());
    let by_simplified = |f: &dyn Fn(&Row) -> f64| simplified.map_or(f64::NAN, f);
    let x = "virtual fragments x";
    content.plot(
        "error",
        Plot {
            caption: "Error against exact blending".into(),
            x: x.into(),
            y: "error".into(),
            log: [true, true],
            curves: vec![
                of("virtual: mean FLIP", &|r| r.error.all.flip),
                of("virtual: RMSE of linear light", &|r| r.error.all.rmse),
                level("simplified: mean FLIP", by_simplified(&|r| r.error.all.flip)),
                level("simplified: RMSE of linear light", by_simplified(&|r| r.error.all.rmse)),
            ],
        },
    );
    content.plot(
        "time",
        Plot {
            caption: "Time of march, hairs and blending (steps 4, 6 and 7)".into(),
            x: x.into(),
            y: "ms".into(),
            log: [true, false],
            curves: vec![
                of("virtual", &|r| time(&r.stats)),
                level("simplified", by_simplified(&|r| time(&r.stats))),
                level("exact", time(exact)),
            ],
        },
    );
    let bytes = |s: &Stats| fragments(s) * FRAGMENT_BYTES as f64;
    content.plot(
        "memory",
        Plot {
            caption: "Bytes of fragments a sample".into(),
            x: x.into(),
            y: "bytes a sample".into(),
            log: [true, true],
            curves: vec![
                of("virtual, all fragments", &|r| bytes(&r.stats)),
                level("simplified, all fragments", by_simplified(&|r| bytes(&r.stats))),
                level("exact, all fragments", bytes(exact)),
                Curve::new(
                    "paper, shell fragments alone (step 4)",
                    PAPER.map(|(x, bytes)| [x, bytes / PAPER_PIXELS]).into(),
                ),
            ],
        },
    );
}

fn table(rows: &[Row], exact: &Stats) -> Table {
    let line = |name: &str, error: Option<&Comparison>, stats: &Stats| {
        let of = |f: fn(&Comparison) -> f64| error.map_or("0".into(), |e| number(f(e)));
        vec![
            name.to_owned(),
            of(|e| e.all.flip),
            of(|e| e.all.rmse),
            format!("{:.0}", time(stats)),
            format!("{:.1}", fragments(stats)),
            stats.fragments_max.to_string(),
            format!("{:.2}", fragments(stats) * FRAGMENT_BYTES as f64 * PAPER_PIXELS / 1e9),
        ]
    };
    let head = [
        "blending",
        "mean FLIP",
        "RMSE",
        "steps 4, 6, 7, ms",
        "fragments a sample",
        "longest list",
        "GB at 3840 x 2274",
    ];
    let mut lines: Vec<Vec<String>> = rows.iter().map(|r| line(&r.name, Some(&r.error), &r.stats)).collect();
    lines.push(line("exact", None, exact));
    lines.push(["paper, x = 1", "", "", "", "", "", "0.20 (shell fragments alone)"].map(String::from).into());
    lines.push(["paper, x = 30", "", "", "", "", "", "7.8 (shell fragments alone)"].map(String::from).into());
    let caption =
        "Against exact blending; memory is that of all fragments of this view, scaled to the paper's pixels:";
    Table::new(caption, &head, lines)
}
