//! The march of one ray, step by step: where it enters the shell, the subelements that its steps
//! read, and the edges that it crosses.

use super::super::drawing::{Anchor, Canvas, Painter, Point, View, css, number_color};
use super::super::probe::{self, Probe};
use super::super::{FigureContent, FigureContext};
use super::subelements::{cells, corners, cut};
use crate::report::Table;
use glam::Vec3;
use pelage_core::{Error, Result};
use pelage_fur::shell::{Located, Place, most_negative, subelement};
use pelage_fur::view::sample_ray;
use pelage_render::twin::resolve::Kind;
use pelage_render::twin::undercoat_march::{Step, first_phase, steps};
use serde::Deserialize;
use std::cell::RefCell;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    scene: String,
    /// Pixels of the film, and the pixel of the ray.
    film: [u32; 2],
    pixel: [u32; 2],
}

/// A step of the march, and how its place was found.
struct Found {
    step: Step,
    /// Point at which the medium was read, cm.
    at: Vec3,
    layer: u32,
    id: u32,
    /// Prisms that were left to find the place.
    hops: Vec<u32>,
}

pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let settings: Settings = context.settings()?;
    let (world, _) = context.load(&settings.scene, &[])?;
    let probe = probe::probe(context.gpu, &world, settings.film, settings.pixel, [1, 1])?;
    let ray = sample_ray(&probe.frame, [0, 0]);
    let entry = probe.lists()?[0].iter().find(|n| n.kind() == Kind::Entry).map(|n| (n.z, n.id()));
    let Some((z, prism)) = entry else {
        return Err(context.fault("the ray of this pixel does not enter the shell"));
    };
    let mut found = follow(&probe, ray, z, prism)?;
    // The last step may reach below the skin, where the medium does not count.
    let z_base = probe.bases()?[0].map_or(f32::INFINITY, |b| b.z);
    found.retain(|f| f.step.z < z_base);
    for f in &mut found {
        f.step.z_end = f.step.z_end.min(z_base);
    }
    // A step that was cut at the skin has another midpoint.
    if let Some(last) = found.last_mut() {
        last.at = Vec3::from(probe.frame.eye) + 0.5 * (last.step.z + last.step.z_end) * ray;
    }
    let mut content = FigureContent::default();
    let opaque: f32 = found.iter().map(|f| f.step.sigma * (f.step.z_end - f.step.z)).sum();
    let mut subelements: Vec<_> = found.iter().map(|f| (f.step.place.prism, f.layer, f.id)).collect();
    let entered = 1 + subelements.windows(2).filter(|w| w[0] != w[1]).count();
    subelements.sort_unstable();
    subelements.dedup();
    let mut prisms: Vec<u32> = found.iter().map(|f| f.step.place.prism).collect();
    prisms.dedup();
    let hops: usize = found.iter().map(|f| f.hops.len()).sum();
    for (name, value) in [
        ("steps", found.len()),
        ("hops over edges", hops),
        ("prisms in which steps are", prisms.len()),
        ("entries into another subelement", entered),
        ("subelements that are read", subelements.len()),
    ] {
        // With other rounding, a step near an edge may be on the other side of it.
        content.value(name, value as f64, 1.0);
    }
    content.value("transmittance", f64::from((-opaque).exp()), 1e-3);
    content.diagram(
        "section",
        "A cut through the shell in the plane of the ray: subelements coloured by their global index, the march \
         through them",
        section(&probe, ray, z, &found),
    );
    content.diagram(
        "prisms",
        "The same ray in space: the prisms that it hops through and the subelements that its steps read",
        space(&probe, ray, z, &found),
    );
    content.table(&table(&found));
    Ok(content)
}

/// Marches like the CPU twin, then locates each place again and records the prisms on the way.
fn follow(probe: &Probe<'_>, ray: Vec3, z: f32, prism: u32) -> Result<Vec<Found>> {
    let (inputs, shell) = (probe.inputs(), &probe.shell);
    let phase = first_phase(&probe.frame, [0, 0]);
    let (steps, lost) = steps(&inputs, ray, prism, z, phase);
    if lost {
        return Err(Error::Unsupported("the march lost the ray".into()));
    }
    let mut place = Place { t: 1.0, ..shell.enter(prism) };
    let length = probe.fur.undercoat.step / ray.length();
    let mut found = Vec::new();
    for (k, step) in steps.into_iter().enumerate() {
        let dz = if k == 0 { length * phase } else { length };
        let at = Vec3::from(probe.frame.eye) + (step.z + 0.5 * dz) * ray;
        let hops = RefCell::new(Vec::new());
        let iterations = if k == 0 { 4 } else { 2 };
        let located = shell.locate_by(&mut place, at, ray, iterations, |place, _| {
            hops.borrow_mut().push(place.prism);
            most_negative(place.lambda)
        });
        if located != Located::Inside || place.prism != step.place.prism {
            return Err(Error::Unsupported(format!(
                "step {k} was found in another prism when located again"
            )));
        }
        let layers = probe.fur.undercoat.layers;
        let layer = ((step.place.t.clamp(0.0, 1.0) * layers as f32) as u32).min(layers - 1);
        let id = subelement(step.place.lambda, step.place.subdivision);
        // The last step's place is clamped to the shell.
        let at = step.place.point(step.place.t, step.place.lambda);
        found.push(Found { step, at, layer, id, hops: hops.into_inner() });
    }
    Ok(found)
}

const STEP: &str = "fill:#fff;stroke:#000;stroke-width:1.2";
const NEW: &str = "fill:#000;stroke:#fff;stroke-width:1";
const HOP: &str = "fill:#d55e00;stroke:#fff;stroke-width:1";

/// Marks the steps: black if they enter another subelement, orange if they enter another prism.
fn marks(canvas: &mut Canvas, found: &[Found], at: impl Fn(Vec3) -> Point) {
    for (k, f) in found.iter().enumerate() {
        let key = |f: &Found| (f.step.place.prism, f.layer, f.id);
        let before = k.checked_sub(1).map(|k| &found[k]);
        let (radius, style) = match before {
            _ if !f.hops.is_empty() => (5.0, HOP),
            Some(before) if key(before) == key(f) => (3.2, STEP),
            _ => (4.2, NEW),
        };
        canvas.circle(at(f.at), radius, style);
    }
}

/// The ray from outside the shell to its entry and on to its exit, and the steps on it.
fn marched_ray(canvas: &mut Canvas, view: &View, points: [Vec3; 3], found: &[Found]) {
    let [outside, entry, exit] = points.map(|p| view.place(p));
    canvas.arrow(outside, entry, "stroke:#000;stroke-width:1.6");
    canvas.line(entry, exit, "stroke:#000;stroke-width:1.2");
    canvas.circle(entry, 5.5, "fill:#0072b2;stroke:#fff;stroke-width:1.2");
    canvas.circle(exit, 8.5, "fill:#009e73;stroke:#fff;stroke-width:1.2");
    marks(canvas, found, |p| view.place(p));
}

fn legend(canvas: &mut Canvas, [x, y]: Point) {
    for (k, (radius, style, text)) in [
        (4.2, NEW, "first step in a subelement"),
        (3.2, STEP, "further step in the same subelement"),
        (5.0, HOP, "first step behind a hop to a neighbouring prism"),
    ]
    .into_iter()
    .enumerate()
    {
        let y = y + 18.0 * k as f64;
        canvas.circle([x, y], radius, style);
        canvas.text([x + 12.0, y + 4.0], Anchor::Start, 12.0, text);
    }
}

fn ends(probe: &Probe<'_>, ray: Vec3, z: f32, found: &[Found]) -> [Vec3; 2] {
    let eye = Vec3::from(probe.frame.eye);
    [eye + z * ray, eye + found.last().map_or(z, |f| f.step.z_end) * ray]
}

/// The cut along the plane of the ray and of the shell's upward direction.
fn section(probe: &Probe<'_>, ray: Vec3, z: f32, found: &[Found]) -> String {
    const MARGIN: f32 = 0.45;
    let size = [860.0, 520.0];
    let [entry, exit] = ends(probe, ray, z, found);
    let shell = &probe.shell;
    let up = found.first().map_or(Vec3::Y, |f| f.step.place.extrusion(f.step.place.lambda));
    let (height, up) = (up.length(), up.normalize_or(Vec3::Y));
    let along = (ray - up * ray.dot(up)).normalize_or(up.any_orthonormal_vector());
    let normal = along.cross(up);
    let length = (exit - entry).dot(along);
    let drop = (entry - exit).dot(up).max(height);
    let scale = (f64::from(length + 2.0 * MARGIN) / (size[0] - 20.0))
        .max(f64::from(drop + MARGIN) / (size[1] - 110.0))
        .recip();
    let centre = entry.midpoint(exit);
    let view = View::new(-normal, up, centre, [0.5 * size[0], 0.5 * (size[1] - 40.0) + 6.0], scale);
    let mut canvas = Canvas::new(size[0], size[1]);
    let window = |p: Vec3| (p - centre).dot(along).abs() < 0.5 * length + MARGIN;
    let reach = length + 2.0 * height + 1.0;
    for index in 0..shell.prisms.len() as u32 {
        let place = shell.enter(index);
        if place.p0.distance(centre) > reach {
            continue;
        }
        let (layers, d) = (probe.fur.undercoat.layers, place.subdivision);
        let visited = found.iter().any(|f| f.step.place.prism == index);
        let whole = |layer| corners(&place, &[Vec3::X, Vec3::Y, Vec3::Z], layer, layers);
        let [low, high] = [whole(0), whole(layers - 1)];
        let body = [low[0], low[1], low[2], high[3], high[4], high[5]];
        let outline = cut(&body, centre, normal);
        if !outline.iter().any(|p| window(*p)) {
            continue;
        }
        for layer in 0..layers {
            if cut(&whole(layer), centre, normal).is_empty() {
                continue;
            }
            for (id, cell) in cells(d).iter().enumerate() {
                let polygon = cut(&corners(&place, cell, layer, layers), centre, normal);
                if polygon.len() < 3 {
                    continue;
                }
                let (saturation, value) = if visited { (0.42, 0.97) } else { (0.13, 0.97) };
                let color = css(number_color(place.volume_index(layer, id as u32), saturation, value));
                let points: Vec<Point> = polygon.iter().map(|p| view.place(*p)).collect();
                canvas.polygon(&points, &format!("fill:{color};stroke:#777;stroke-width:0.4"));
            }
        }
        let points: Vec<Point> = outline.iter().map(|p| view.place(*p)).collect();
        canvas.polygon(&points, "fill:none;stroke:#222;stroke-width:1.4");
    }
    let direction = (exit - entry).normalize_or(Vec3::NEG_Y);
    marched_ray(&mut canvas, &view, [entry - direction * 0.6 * MARGIN, entry, exit], found);
    legend(&mut canvas, [24.0, size[1] - 50.0]);
    canvas.circle([420.0, size[1] - 50.0], 5.5, "fill:#0072b2");
    canvas.text([432.0, size[1] - 46.0], Anchor::Start, 12.0, "entry (shell fragment)");
    canvas.circle([420.0, size[1] - 32.0], 5.5, "fill:#009e73");
    canvas.text(
        [432.0, size[1] - 28.0],
        Anchor::Start,
        12.0,
        "end at the skin, or where the ray leaves the shell",
    );
    canvas.text([420.0, size[1] - 10.0], Anchor::Start, 12.0, "bold outlines: prisms; pale: not visited");
    canvas.svg()
}

/// The prisms as outlines, and the subelements that were read as bodies.
fn space(probe: &Probe<'_>, ray: Vec3, z: f32, found: &[Found]) -> String {
    let [entry, exit] = ends(probe, ray, z, found);
    let (shell, layers) = (&probe.shell, probe.fur.undercoat.layers);
    let first = &found[0].step.place;
    let up = first.extrusion(first.lambda).normalize_or(Vec3::Y);
    let along = (ray - up * ray.dot(up)).normalize_or(up.any_orthonormal_vector());
    let forward = along.cross(up) * 0.85 + along * 0.3 - up * 0.42;
    let size = [860.0, 560.0];
    let mut prisms: Vec<u32> =
        found.iter().flat_map(|f| f.hops.iter().copied().chain([f.step.place.prism])).collect();
    prisms.sort_unstable();
    prisms.dedup();
    let outline = |prism: u32| {
        let place = shell.enter(prism);
        [0.0, 1.0].map(|t| [Vec3::X, Vec3::Y, Vec3::Z].map(|l| place.point(t, l)))
    };
    let all: Vec<Vec3> = prisms.iter().flat_map(|p| outline(*p).concat()).chain([entry, exit]).collect();
    let view = View::fitted(forward, up, &all, [30.0, 40.0], [size[0] - 30.0, size[1] - 75.0]);
    let mut painter = Painter::new(view);
    for prism in prisms {
        let [skin, top] = outline(prism);
        painter.face(&skin, "fill:#c9b8a6;fill-opacity:0.8;stroke:#6b5a48;stroke-width:1".into());
        let line = "fill:none;stroke:#555;stroke-width:0.9;stroke-opacity:0.7";
        painter.line(&[top[0], top[1], top[2], top[0]], 0.0, line.into());
        for k in 0..3 {
            painter.line(&[skin[k], top[k]], 0.0, line.into());
        }
    }
    let mut drawn = Vec::new();
    for f in found {
        let place = &f.step.place;
        let key = (place.prism, f.layer, f.id);
        if drawn.contains(&key) {
            continue;
        }
        drawn.push(key);
        let cell = cells(place.subdivision)[f.id as usize];
        let c = corners(place, &cell, f.layer, layers);
        let color = number_color(place.volume_index(f.layer, f.id), 0.5, 0.95);
        let style = |shade: f32| {
            format!("fill:{};fill-opacity:0.75;stroke:#333;stroke-width:0.5", css(color * shade))
        };
        painter.face(&c[..3], style(0.7));
        for k in 0..3 {
            let next = (k + 1) % 3;
            painter.face(&[c[k], c[next], c[next + 3], c[k + 3]], style(0.85));
        }
        painter.face(&c[3..], style(1.0));
    }
    let mut canvas = Canvas::new(size[0], size[1]);
    painter.draw(&mut canvas);
    let direction = (exit - entry).normalize_or(Vec3::NEG_Y);
    marched_ray(&mut canvas, &view, [entry - 0.3 * direction, entry, exit], found);
    legend(&mut canvas, [24.0, size[1] - 50.0]);
    canvas.svg()
}

/// The steps with their indices.
fn table(found: &[Found]) -> Table {
    let mut through = 1.0f32;
    let rows = found.iter().enumerate().map(|(k, f)| {
        let place = &f.step.place;
        through *= (-f.step.sigma * (f.step.z_end - f.step.z)).exp();
        let l = place.lambda;
        vec![
            k.to_string(),
            place.prism.to_string(),
            if f.hops.is_empty() { String::new() } else { f.hops.len().to_string() },
            format!("{:.3}", place.t),
            format!("{:.2} {:.2} {:.2}", l.x, l.y, l.z),
            f.layer.to_string(),
            f.id.to_string(),
            place.volume_index(f.layer, f.id).to_string(),
            format!("{:.4}", through),
        ]
    });
    let head = [
        "step",
        "prism",
        "hops",
        "height",
        "barycentric",
        "layer",
        "i, eq. 2",
        "global, eq. 3",
        "transmittance",
    ];
    Table::new("The steps:", &head, rows.collect())
}
