//! From a point to the index of its subelement: Andersen et al. 2016, equations 1 to 3, with the
//! renderer's own functions.

use super::super::drawing::{Anchor, Canvas, Painter, Point, View, css, number_color};
use super::super::probe;
use super::super::{FigureContent, FigureContext};
use super::subelements::{cells, corners};
use crate::report::Table;
use glam::Vec3;
use pelage_core::Result;
use pelage_fur::random::random;
use pelage_fur::shell::{subelement, subelement_centroid};
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// Subdivision levels that are drawn.
    levels: Vec<u32>,
    /// The point whose sub-indices are shown, barycentric, and its level.
    point: [f32; 3],
    point_level: u32,
    /// Number of random points of the check.
    points: u32,
    /// The scene whose shell is drawn, and the number of the prism.
    scene: String,
    prism: u32,
}

pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let settings: Settings = context.settings()?;
    if settings.levels.iter().chain([&settings.point_level]).any(|d| *d > 6) {
        return Err(context.fault("levels must be 0..=6"));
    }
    let mut content = FigureContent::default();
    content.diagram(
        "layer",
        "Local indices of a layer's subelements after each subdivision, equation 2",
        layers(&settings.levels),
    );
    content.diagram(
        "point",
        "The three sub-indices of a point from its distances to the edges, equation 1",
        point(Vec3::from(settings.point), settings.point_level),
    );
    check(&settings, &mut content);
    prism(context, &settings, &mut content)?;
    Ok(content)
}

/// Corners of an upright triangle with its lower left corner at `at`, in the paper's order: p0
/// lower left, p1 lower right, p2 top.
fn triangle(at: Point, side: f64) -> [Point; 3] {
    [at, [at[0] + side, at[1]], [at[0] + 0.5 * side, at[1] - 0.866 * side]]
}

fn place(corners: &[Point; 3], l: Vec3) -> Point {
    let part = |k: usize| corners.iter().zip(l.to_array()).map(|(p, l)| p[k] * f64::from(l)).sum();
    [part(0), part(1)]
}

fn fill(id: u32) -> String {
    css(number_color(id, 0.45, 0.95))
}

fn layers(levels: &[u32]) -> String {
    let side = 280.0;
    let mut canvas = Canvas::new(30.0 + levels.len() as f64 * (side + 50.0), 310.0);
    for (k, d) in levels.iter().enumerate() {
        let at = triangle([30.0 + k as f64 * (side + 50.0), 264.0], side);
        for (id, cell) in cells(*d).iter().enumerate() {
            let points = cell.map(|l| place(&at, l));
            canvas.polygon(&points, &format!("fill:{};stroke:#555;stroke-width:0.7", fill(id as u32)));
            let px = side / f64::from(1 << d) * 0.26;
            if px > 5.0 {
                let [x, y] = place(&at, subelement_centroid(id as u32, *d));
                canvas.text([x, y + 0.35 * px], Anchor::Middle, px.min(26.0), &id.to_string());
            }
        }
        for (k, (corner, [dx, dy])) in at.iter().zip([[-9.0, 14.0], [9.0, 14.0], [0.0, -8.0]]).enumerate() {
            canvas.text([corner[0] + dx, corner[1] + dy], Anchor::Middle, 13.0, &format!("p{k}"));
        }
        let title = format!("d = {d}: {} subelements", 1u32 << (2 * d));
        canvas.text([at[0][0] + 0.5 * side, 296.0], Anchor::Middle, 14.0, &title);
    }
    canvas.svg()
}

/// Sub-indices, which the drawing shows one by one.
// [Andersen2016] eq. 1
fn sub_indices(l: Vec3, d: u32) -> [i32; 3] {
    ((Vec3::ONE - l) * (1 << d) as f32).floor().as_ivec3().to_array()
}

fn point(l: Vec3, d: u32) -> String {
    const BANDS: [&str; 3] = ["#0072b2", "#d55e00", "#009e73"];
    let side = 330.0;
    let mut canvas = Canvas::new(700.0, 370.0);
    let at = triangle([60.0, 322.0], side);
    let (n, id, i) = (1i32 << d, subelement(l, d), sub_indices(l, d));
    for (cell_id, cell) in cells(d).iter().enumerate() {
        let fill = if cell_id as u32 == id { "#ffe08a" } else { "#f6f6f6" };
        canvas.polygon(&cell.map(|l| place(&at, l)), &format!("fill:{fill};stroke:#999;stroke-width:0.8"));
    }
    // Subelements with i1 = i2, whose index is the first term of [Andersen2016] eq. 2.
    for (cell_id, cell) in cells(d).iter().enumerate() {
        let middle = subelement_centroid(cell_id as u32, d);
        let [_, b, c] = sub_indices(middle, d);
        if b == c {
            canvas.polygon(&cell.map(|l| place(&at, l)), "fill:none;stroke:#222;stroke-width:1.8");
        }
    }
    // Labels of the bands, each beside an edge along which its index changes.
    for band in 0..n {
        let along = 1.0 - (band as f32 + 0.5) / n as f32;
        let rest = 1.0 - along;
        let beside: [(Vec3, [f64; 2], Anchor); 3] = [
            (Vec3::new(along, rest, 0.0), [0.0, 17.0], Anchor::Middle),
            (Vec3::new(0.0, along, rest), [9.0, 0.0], Anchor::Start),
            (Vec3::new(rest, 0.0, along), [-9.0, 0.0], Anchor::End),
        ];
        for (k, (l, [dx, dy], anchor)) in beside.into_iter().enumerate() {
            let [x, y] = place(&at, l);
            canvas.circle([x, y], 2.0, &format!("fill:{}", BANDS[k]));
            canvas.text([x + dx, y + dy], anchor, 12.0, &format!("i{k}={band}"));
        }
    }
    let p = place(&at, l);
    for k in 0..3 {
        // Foot of the perpendicular on edge k, opposite corner k.
        let (a, b) = (at[(k + 1) % 3], at[(k + 2) % 3]);
        let d = [b[0] - a[0], b[1] - a[1]];
        let t = ((p[0] - a[0]) * d[0] + (p[1] - a[1]) * d[1]) / (d[0] * d[0] + d[1] * d[1]);
        let foot = [a[0] + t * d[0], a[1] + t * d[1]];
        canvas.line(p, foot, &format!("stroke:{};stroke-width:2", BANDS[k]));
        canvas.text(
            [at[k][0], at[k][1] + if k == 2 { -8.0 } else { 34.0 }],
            Anchor::Middle,
            14.0,
            &format!("p{k}"),
        );
    }
    canvas.circle(p, 4.0, "fill:#000");
    canvas.text([p[0] + 7.0, p[1] + 15.0], Anchor::Start, 14.0, "p");
    let lines = [
        format!("d = {d}, 2^d = {n}"),
        "distances of p to e0, e1, e2 over".into(),
        format!("those of p0, p1, p2: {:.3}, {:.3}, {:.3}", l.x, l.y, l.z),
        format!("i0 = floor((1 - {:.3}) {n}) = {}", l.x, i[0]),
        format!("i1 = floor((1 - {:.3}) {n}) = {}", l.y, i[1]),
        format!("i2 = floor((1 - {:.3}) {n}) = {}", l.z, i[2]),
        "i = i0 (1 + i0) + (i1 - i2)".into(),
        format!("  = {} + ({}) = {}", i[0] * (1 + i[0]), i[1] - i[2], i[0] * (1 + i[0]) + i[1] - i[2]),
        format!("the renderer's index of p: {id}"),
    ];
    for (k, line) in lines.iter().enumerate() {
        canvas.text([430.0, 40.0 + 22.0 * k as f64], Anchor::Start, 13.0, line);
    }
    canvas.text([430.0, 262.0], Anchor::Start, 13.0, "bold: i1 = i2, whose index is i0 (1 + i0)");
    canvas.svg()
}

/// Checks at random points that the index is the number of the subelement that contains the point.
fn check(settings: &Settings, content: &mut FigureContent) {
    let mut rows = Vec::new();
    for d in 0..=6u32 {
        let cells = cells(d);
        let inside = |i: &u32| {
            // Uniform in the triangle: the square folded along its diagonal.
            let (mut u, mut v) = (random(*i, 0), random(*i, 1));
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let l = Vec3::new(1.0 - u - v, u, v);
            let [a, b, c] = cells[subelement(l, d) as usize];
            let cross = |p: Vec3, q: Vec3| (p.y - l.y) * (q.z - l.z) - (p.z - l.z) * (q.y - l.y);
            let sides = [cross(a, b), cross(b, c), cross(c, a)];
            let on_an_edge = 1e-6 / cells.len() as f32;
            sides.iter().all(|s| *s >= -on_an_edge) || sides.iter().all(|s| *s <= on_an_edge)
        };
        let right = (0..settings.points).filter(inside).count();
        let known = (0..cells.len() as u32).filter(|id| subelement(subelement_centroid(*id, d), d) == *id);
        let known = known.count();
        rows.push(vec![d.to_string(), cells.len().to_string(), known.to_string(), format!("{right}")]);
        content.value(&format!("d = {d}: points in the subelement of their index"), right as f64, 0.0);
        content.value(
            &format!("d = {d}: indices that the middle of their subelement has"),
            known as f64,
            0.0,
        );
    }
    let last = format!("of {} random points in the subelement of their index", settings.points);
    let head = ["d", "subelements", "indices that come back from their middles", &last];
    content.table(&Table::new("The index and the place that it stands for:", &head, rows));
}

/// A prism of a shell, with its layers drawn apart.
fn prism(context: &FigureContext, settings: &Settings, content: &mut FigureContent) -> Result<()> {
    const GAP: f32 = 2.1;
    let (world, _) = context.load(&settings.scene, &[])?;
    if settings.prism as usize >= world.skin.triangles.len() {
        return Err(context.fault(format!("prism: the skin has {} triangles", world.skin.triangles.len())));
    }
    let probe = probe::probe(context.gpu, &world, [16, 16], [0, 0], [16, 16])?;
    let place = probe.shell.enter(settings.prism);
    let (layers, d) = (probe.fur.undercoat.layers, place.subdivision);
    let middle = Vec3::splat(1.0 / 3.0);
    let up = place.extrusion(middle).normalize_or(Vec3::Y);
    let along = (place.e1 - up * up.dot(place.e1)).normalize_or(Vec3::X);
    let forward = (up.cross(along) * 0.8 - up * 0.6 + 0.25 * along).normalize();
    let height = place.extrusion(middle).length();
    let ends = [0.0, GAP].map(|t| [Vec3::X, Vec3::Y, Vec3::Z].map(|l| place.point(t, l))).concat();
    let view = View::fitted(forward, up, &ends, [20.0, 20.0], [400.0, 640.0]);
    let mut painter = Painter::new(view);
    let cells = cells(d);
    for layer in 0..layers {
        let lift = up * (height * (GAP - 1.0) * layer as f32 / layers as f32);
        for (id, cell) in cells.iter().enumerate() {
            let c = corners(&place, cell, layer, layers).map(|p| p + lift);
            let color = number_color(id as u32, 0.45, 0.95);
            let style = |shade: f32| format!("fill:{};stroke:#444;stroke-width:0.4", css(color * shade));
            // The painter draws the sides that face the camera last.
            for k in 0..3 {
                let next = (k + 1) % 3;
                painter.face(&[c[k], c[next], c[next + 3], c[k + 3]], style(0.8));
            }
            painter.face(&c[3..], style(1.0));
        }
    }
    let mut canvas = Canvas::new(620.0, 660.0);
    painter.draw(&mut canvas);
    for layer in 0..layers {
        let lift = up * (height * (GAP - 1.0) * layer as f32 / layers as f32);
        let t = (layer as f32 + 0.5) / layers as f32;
        let right = [Vec3::X, Vec3::Y, Vec3::Z].map(|l| view.place(place.point(t, l) + lift));
        let right = right.into_iter().fold([0.0, 0.0], |a, b| if a[0] > b[0] { a } else { b });
        let (first, last) = (place.volume_index(layer, 0), place.volume_index(layer, (1 << (2 * d)) - 1));
        canvas.text(
            [right[0] + 14.0, right[1] + 4.0],
            Anchor::Start,
            12.0,
            &format!("layer {layer}: {first} to {last}"),
        );
    }
    let global = |layer: u32, id: u32| f64::from(place.volume_index(layer, id));
    // [Andersen2016] eq. 3 where all prisms have the same level.
    let wanted = f64::from(settings.prism * layers) * f64::from(1 << (2 * d));
    content.value("first global index less that of equation 3", global(0, 0) - wanted, 0.0);
    content.value("indices of a layer", global(1.min(layers - 1), 0) - global(0, 0), 0.0);
    let caption = format!(
        "Prism {} of the pelt's shell, its {layers} layers drawn apart, subelements coloured by their local index; \
         beside each layer its global indices, equation 3",
        settings.prism
    );
    content.diagram("prism", &caption, canvas.svg());
    Ok(())
}
