//! The fragment lists of a row of pixels after rasterisation and march, by depth.

use super::super::drawing::{Anchor, Canvas, css};
use super::super::probe;
use super::super::{FigureContent, FigureContext};
use crate::report::Table;
use crate::report::plot::{Curve, Plot};
use glam::Vec3;
use pelage_core::Result;
use pelage_render::twin::resolve::{Base, Kind, Node, blend_fragments};
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    scene: String,
    /// Pixels of the film.
    film: [u32; 2],
    /// First pixel of the row, and number of pixels.
    first: [u32; 2],
    pixels: u32,
    /// Number in the row of the pixel whose transmittance is plotted.
    follow: u32,
}

pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let settings: Settings = context.settings()?;
    let (world, _) = context.load(&settings.scene, &[])?;
    let row = settings.pixels.max(1);
    let probe = probe::probe(context.gpu, &world, settings.film, settings.first, [row, 1])?;
    probe.draw_strands()?;
    probe.march()?;
    let (lists, bases) = (probe.lists()?, probe.bases()?);
    if lists.iter().all(Vec::is_empty) || settings.follow >= row {
        return Err(context.fault("no fur is visible in the row of pixels, or follow is not a pixel of it"));
    }
    // The GPU's result for these lists against that of the CPU twin.
    let samples = probe.resolve(false)?;
    let worst = lists.iter().zip(&bases).zip(&samples).map(|((list, base), sample)| {
        let wanted = blend_fragments(&probe.fur.undercoat, list.clone(), *base);
        let sum = |a: Vec3, b: Vec3, c: Vec3| a + b + c;
        let differing = sum(wanted.guard, wanted.undercoat, wanted.base)
            - sum(sample.guard, sample.undercoat, sample.base);
        differing.abs().max_element()
    });
    let worst = worst.fold(0.0, f32::max);
    let mut content = FigureContent::default();
    let follow = settings.follow as usize;
    content.diagram(
        "side",
        "Fragments of a row of pixels by depth; grey: the part of what lies there that is hidden",
        side(&lists, &bases, follow),
    );
    content.plot("transmittance", transmittance(&lists[follow], bases[follow], follow));
    let count = |kind: Kind| lists.iter().flatten().filter(|n| n.kind() == kind).count() as f64;
    let mut rows = Vec::new();
    for (name, kind) in [
        ("guard-hair fragments", Kind::Strand),
        ("shell entries", Kind::Entry),
        ("virtual fragments", Kind::Volume),
    ] {
        // Whether the edge of a hair touches a pixel may depend on the adapter's rounding.
        content.value(name, count(kind), 0.01 * count(kind).max(100.0));
        rows.push(vec![
            name.into(),
            format!("{}", count(kind)),
            format!("{:.1}", count(kind) / f64::from(row)),
        ]);
    }
    let skin = bases.iter().flatten().count() as f64;
    content.value("pixels that see the skin's surface behind the fur", skin, 0.0);
    rows.push(vec!["skin".into(), format!("{skin}"), format!("{:.1}", skin / f64::from(row))]);
    content.value("resolved radiance, largest difference of GPU and CPU", f64::from(worst), 0.02);
    let head = ["kind", "fragments", "a pixel"];
    content.table(&Table::new(format!("In the row of {row} pixels:"), &head, rows));
    Ok(content)
}

/// Transmittance in front of each fragment, and behind the last.
fn through(list: &[Node]) -> Vec<f32> {
    let mut t = 1.0;
    let mut all = vec![t];
    for node in list {
        if node.kind() != Kind::Entry {
            t *= 1.0 - node.color.w;
        }
        all.push(t);
    }
    all
}

fn side(lists: &[Vec<Node>], bases: &[Option<Base>], follow: usize) -> String {
    let (left, right, top, bottom) = (60.0, 20.0, 34.0, 92.0);
    let size = [900.0, 560.0];
    let all = || {
        let skin = bases.iter().flatten().map(|b| b.z);
        lists.iter().flatten().map(|n| n.z).chain(skin)
    };
    let (low, high) = (all().fold(f32::INFINITY, f32::min), all().fold(0.0, f32::max));
    let (low, high) = (low - 0.05, high + 0.05);
    let wide = (size[0] - left - right) / lists.len() as f64;
    let y = |z: f32| top + f64::from((z - low) / (high - low)) * (size[1] - top - bottom);
    let mut canvas = Canvas::new(size[0], size[1]);
    for (i, (list, base)) in lists.iter().zip(bases).enumerate() {
        let x = left + i as f64 * wide;
        // Darker grey where more is hidden.
        let end = base.map_or(high, |b| b.z);
        let borders: Vec<f32> = [low].into_iter().chain(list.iter().map(|n| n.z)).chain([end]).collect();
        for (t, pair) in through(list).into_iter().zip(borders.windows(2)) {
            let (from, to) = (y(pair[0]), y(pair[1].max(pair[0])));
            let box_ = [[x, from], [x + wide, from], [x + wide, to], [x, to]];
            if t < 0.995 && to > from {
                canvas.polygon(
                    &box_,
                    &format!("fill:{};shape-rendering:crispEdges", css(Vec3::splat(0.62 + 0.38 * t))),
                );
            }
        }
        if let Some(base) = base {
            let style = "stroke:#a0522d;stroke-width:3";
            canvas.line([x, y(base.z)], [x + wide, y(base.z)], style);
        }
        for node in list {
            let (at, alpha) = (y(node.z), f64::from(node.color.w));
            match node.kind() {
                // A dash as long as the hair's coverage of the pixel.
                Kind::Strand => {
                    let half = 0.5 * wide * alpha.clamp(0.12, 1.0);
                    let middle = x + 0.5 * wide;
                    let style = "stroke:#0072b2;stroke-width:2.2";
                    canvas.line([middle - half, at], [middle + half, at], style);
                }
                Kind::Entry => {
                    let half = 0.36 * wide;
                    let m = x + 0.5 * wide;
                    canvas.polygon(
                        &[[m - half, at - half], [m + half, at - half], [m, at + 0.6 * half]],
                        "fill:#d55e00",
                    );
                }
                Kind::Volume => {
                    canvas.circle([x + 0.5 * wide, at], 0.2 * wide, "fill:#009e73");
                }
            }
        }
    }
    let x = left + follow as f64 * wide;
    let frame = [[x, top], [x + wide, top], [x + wide, size[1] - bottom], [x, size[1] - bottom]];
    canvas.polygon(&frame, "fill:none;stroke:#000;stroke-width:1.4");
    // The axis, with ticks 2 mm or more apart.
    let step = [0.2f32, 0.5, 1.0, 2.0].into_iter().find(|s| (high - low) / s < 12.0).unwrap_or(5.0);
    for k in (low / step).ceil() as i32..=(high / step).floor() as i32 {
        let z = k as f32 * step;
        canvas.line([left - 5.0, y(z)], [left, y(z)], "stroke:#444");
        canvas.text([left - 8.0, y(z) + 4.0], Anchor::End, 11.0, &format!("{z:.1}"));
    }
    canvas.line([left, top], [left, size[1] - bottom], "stroke:#444");
    canvas.text([6.0, 18.0], Anchor::Start, 12.0, "depth, cm, away from the eye");
    canvas.text([size[0] - right, 18.0], Anchor::End, 12.0, &format!("{} pixels of a row", lists.len()));
    let line = size[1] - 60.0;
    canvas.line([30.0, line], [46.0, line], "stroke:#0072b2;stroke-width:1.6");
    canvas.text(
        [54.0, line + 4.0],
        Anchor::Start,
        12.0,
        "guard-hair fragment, as wide as its part of the pixel",
    );
    canvas.circle([38.0, line + 20.0], 3.4, "fill:#009e73");
    canvas.text(
        [54.0, line + 24.0],
        Anchor::Start,
        12.0,
        "virtual fragment of the undercoat, an equal part of its opacity",
    );
    canvas.polygon(&[[32.0, line + 34.0], [44.0, line + 34.0], [38.0, line + 44.0]], "fill:#d55e00");
    canvas.text([54.0, line + 44.0], Anchor::Start, 12.0, "entry into the shell (shell fragment)");
    canvas.line([480.0, line], [500.0, line], "stroke:#a0522d;stroke-width:3");
    canvas.text([508.0, line + 4.0], Anchor::Start, 12.0, "skin (base mesh fragment)");
    canvas.polygon(
        &[[480.0, line + 13.0], [500.0, line + 13.0], [500.0, line + 26.0], [480.0, line + 26.0]],
        "fill:#9e9e9e",
    );
    canvas.text([508.0, line + 24.0], Anchor::Start, 12.0, "hidden by what lies in front; white: seen");
    canvas.text([480.0, line + 44.0], Anchor::Start, 12.0, "framed: the pixel of the curve below");
    canvas.svg()
}

fn transmittance(list: &[Node], base: Option<Base>, pixel: usize) -> Plot {
    let steps = |kept: &dyn Fn(Kind) -> bool| {
        let mut t = 1.0f64;
        let first = list.first().map_or(0.0, |n| f64::from(n.z) - 0.02);
        let mut points = vec![[first, t]];
        for node in list.iter().filter(|n| n.kind() != Kind::Entry && kept(n.kind())) {
            points.push([f64::from(node.z), t]);
            t *= 1.0 - f64::from(node.color.w);
            points.push([f64::from(node.z), t]);
        }
        points.extend(base.map(|b| [f64::from(b.z), t]));
        points
    };
    let curve = |name: &str, kept: &dyn Fn(Kind) -> bool| Curve::new(name, steps(kept));
    Plot {
        caption: format!("Transmittance along pixel {pixel} of the row"),
        x: "depth, cm".into(),
        y: "transmittance".into(),
        curves: vec![
            curve("guard hairs and undercoat, sorted", &|_| true),
            curve("guard hairs alone", &|kind| kind == Kind::Strand),
            curve("undercoat alone", &|kind| kind == Kind::Volume),
        ],
        ..Plot::default()
    }
}
