//! The neighbour table: keys of directed edges, their slots in the GPU's hash table, and the
//! neighbours found.

use super::super::drawing::{Anchor, Canvas, Point, css, number_color};
use super::super::{FigureContent, FigureContext};
use crate::report::Table;
use pelage_core::Result;
use pelage_core::mesh::topology::edge_key;
use pelage_core::skin::NONE;
use pelage_fur::random::hash2;
use pelage_gpu::recorder::Timings;
use pelage_gpu::{Recorder, Scope};
use pelage_render::passes::edge_table::EdgeTable;
use pelage_render::twin::edge_table;
use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// Positions of the vertices in the drawing, 0..1, y upwards.
    vertices: Vec<[f64; 2]>,
    /// Vertices of the triangles, counter-clockwise.
    triangles: Vec<[u32; 3]>,
    /// The triangle whose lookups are shown.
    follow: u32,
}

/// A directed edge, and its key in the GPU's table.
struct Entry {
    triangle: usize,
    corner: usize,
    a: u32,
    b: u32,
    /// Slot of the hash, and slot of the key.
    first: u32,
    slot: u32,
    neighbour: u32,
}

pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let settings: Settings = context.settings()?;
    let count = settings.vertices.len() as u32;
    let fits = settings.triangles.iter().flatten().all(|v| *v < count);
    if !fits || settings.follow as usize >= settings.triangles.len() {
        return Err(
            context.fault("triangles must refer to existing vertices, and follow to an existing triangle")
        );
    }
    let (entries, slots) = table(context, &settings.triangles)?;
    let twin = edge_table::neighbours(&settings.triangles);
    let agree = entries.iter().filter(|e| twin[e.triangle][e.corner] == e.neighbour).count();
    let mut content = FigureContent::default();
    content.value("directed edges", entries.len() as f64, 0.0);
    content.value("slots", slots as f64, 0.0);
    content.value("neighbours that GPU and CPU find alike", agree as f64, 0.0);
    let inner = entries.iter().filter(|e| e.neighbour != NONE).count();
    content.value("directed edges with a neighbour", inner as f64, 0.0);
    content.diagram(
        "mesh",
        "The mesh: its directed edges counter-clockwise, and the look-ups of one triangle",
        mesh(&settings, &entries),
    );
    content.diagram(
        "table",
        "The hash table as the GPU filled it: 64-bit keys in their slots",
        slots_drawing(&entries, slots),
    );
    let rows = entries.iter().filter(|e| e.triangle == settings.follow as usize).map(|e| {
        let found = match e.neighbour {
            NONE => "none: a border".into(),
            n => format!("f{n}"),
        };
        let key = |a, b| format!("`{:08x} {:08x}`", edge_key(a, b) >> 32, edge_key(a, b) as u32);
        vec![format!("v{} to v{}", e.a, e.b), key(e.a, e.b), key(e.b, e.a), found]
    });
    let caption = format!("What triangle f{} finds:", settings.follow);
    let head = ["edge", "its key", "reversed key", "owner of the reversed key"];
    content.table(&Table::new(caption, &head, rows.collect()));
    Ok(content)
}

/// Runs the renderer's pass on the triangles and reads its table back.
fn table(context: &FigureContext, triangles: &[[u32; 3]]) -> Result<(Vec<Entry>, usize)> {
    let gpu = context.gpu;
    let edges = 3 * triangles.len();
    let inputs = [
        gpu.upload("triangles", 1, bytemuck::cast_slice::<[u32; 3], u32>(triangles))?,
        gpu.storage("neighbours", 1, 4 * edges as u64)?,
    ];
    let pass = EdgeTable::new(gpu)?;
    let mut recorder = Recorder::new(gpu);
    let scope = Scope::default().with(&inputs.iter().collect::<Vec<_>>());
    let [_counts, slots, _owners] = pass.record(gpu, &mut recorder, &scope, edges as u32)?;
    recorder.submit(&mut Timings::default())?;
    let neighbours: Vec<u32> = gpu.read(&inputs[1], 4 * edges as u64)?;
    let slots: Vec<u32> = gpu.read(&slots, slots.size)?;
    let key = |edge: usize| {
        let [t, k] = [edge / 3, edge % 3];
        (triangles[t][(k + 1) % 3], triangles[t][(k + 2) % 3])
    };
    let entries = (0..edges)
        .map(|edge| {
            let (a, b) = key(edge);
            // A slot holds the number of the first edge with its key, plus one; 0 if it is free.
            let slot = slots.iter().position(|e| *e > 0 && key(*e as usize - 1) == (a, b));
            Entry {
                triangle: edge / 3,
                corner: edge % 3,
                a,
                b,
                first: hash2(a, b) & (slots.len() as u32 - 1),
                slot: slot.map_or(NONE, |s| s as u32),
                neighbour: neighbours[edge],
            }
        })
        .collect();
    Ok((entries, slots.len()))
}

fn fill(triangle: usize) -> String {
    css(number_color(triangle as u32, 0.28, 0.97))
}

fn mesh(settings: &Settings, entries: &[Entry]) -> String {
    let mut canvas = Canvas::new(620.0, 480.0);
    let at = |v: u32| {
        let [x, y] = settings.vertices[v as usize];
        [50.0 + 520.0 * x, 420.0 - 380.0 * y]
    };
    let between = |a: Point, b: Point, t: f64| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
    let centre = |t: usize| {
        let corners = settings.triangles[t].map(at);
        [0, 1].map(|k| corners.iter().map(|p| p[k]).sum::<f64>() / 3.0)
    };
    for (t, triangle) in settings.triangles.iter().enumerate() {
        canvas.polygon(&triangle.map(at), &format!("fill:{};stroke:#555;stroke-width:1.2", fill(t)));
    }
    for e in entries {
        // Inside the triangle, so that the two directions of an edge do not coincide.
        let c = centre(e.triangle);
        let [a, b] = [e.a, e.b].map(|v| between(at(v), c, 0.2));
        canvas.arrow(between(a, b, 0.1), between(a, b, 0.84), "stroke:#333;stroke-width:1.2");
        let followed = e.triangle == settings.follow as usize;
        if followed && e.neighbour != NONE {
            let style = "stroke:#d55e00;stroke-width:2.4";
            let from = between(a, b, 0.5);
            canvas.arrow(from, between(from, centre(e.neighbour as usize), 0.75), style);
        } else if followed {
            let middle = between(at(e.a), at(e.b), 0.5);
            canvas.circle(middle, 6.0, "fill:#fff;stroke:#d55e00;stroke-width:2.4");
        }
    }
    for t in 0..settings.triangles.len() {
        let [x, y] = centre(t);
        canvas.circle([x, y], 12.0, "fill:#fff;fill-opacity:0.85");
        canvas.text([x, y + 5.0], Anchor::Middle, 15.0, &format!("f{t}"));
    }
    for v in 0..settings.vertices.len() as u32 {
        let [x, y] = at(v);
        canvas.circle([x, y], 11.0, "fill:#222");
        canvas.circle([x, y], 10.0, "fill:#fff");
        canvas.text([x, y + 4.0], Anchor::Middle, 11.0, &format!("v{v}"));
    }
    for (y, text) in [
        (454.0, "thin arrows: directed edges, whose keys the first pass enters"),
        (471.0, "orange: one triangle's neighbours by reversed keys, second pass; ring: no owner, a border"),
    ] {
        canvas.text([20.0, y], Anchor::Start, 12.0, text);
    }
    canvas.svg()
}

fn slots_drawing(entries: &[Entry], slots: usize) -> String {
    let columns = 2;
    let rows = slots.div_ceil(columns);
    let (width, line) = (470.0, 15.0);
    let mut canvas = Canvas::new(columns as f64 * width + 20.0, 40.0 + line * rows as f64 + 14.0);
    for column in 0..columns {
        let x = 10.0 + column as f64 * width;
        for (dx, text) in [
            (0.0, "slot"),
            (46.0, "key: from (32 bit), to (32 bit)"),
            (250.0, "edge"),
            (330.0, "owner"),
            (374.0, "hash"),
        ] {
            canvas.text([x + dx, 20.0], Anchor::Start, 11.0, text);
        }
    }
    for slot in 0..slots {
        let (x, y) = (10.0 + (slot / rows) as f64 * width, 40.0 + line * (slot % rows) as f64);
        let Some(e) = entries.iter().find(|e| e.slot == slot as u32) else {
            canvas.text([x, y], Anchor::Start, 10.5, &format!("{slot}"));
            canvas.text([x + 46.0, y], Anchor::Start, 10.5, "free");
            continue;
        };
        let band = [
            [x - 4.0, y - 11.0],
            [x + width - 20.0, y - 11.0],
            [x + width - 20.0, y + 3.0],
            [x - 4.0, y + 3.0],
        ];
        canvas.polygon(&band, &format!("fill:{}", fill(e.triangle)));
        let key = edge_key(e.a, e.b);
        // If the slot of its hash was taken, a key is in a later slot.
        let hash = if e.first == e.slot { format!("{}", e.first) } else { format!("{} (taken)", e.first) };
        for (dx, text) in [
            (0.0, format!("{slot}")),
            (46.0, format!("{:08x} {:08x}", key >> 32, key as u32)),
            (250.0, format!("v{} to v{}", e.a, e.b)),
            (330.0, format!("f{}", e.triangle)),
            (374.0, hash),
        ] {
            canvas.text([x + dx, y], Anchor::Start, 10.5, &text);
        }
    }
    canvas.svg()
}
