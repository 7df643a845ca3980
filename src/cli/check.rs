//! `pelage check`: size, hairs, memory and time to expect; the resolved scene on request.

use super::Global;
use super::args::SceneArgs;
use super::output::{self, count, human_bytes};
use clap::Args;
use pelage::render::{self, RenderOptions};
use pelage::scene::Scalar;
use pelage::{Error, Result, Scene, World};
use pelage_core::scene::Coat;
use pelage_fur::extent::Extent;
use pelage_render::prepare::{grid_bytes, lattice_bytes, stores_undercoat, strand_bytes};
use serde::Serialize;

#[derive(Debug, Args)]
#[command(after_long_help = "Examples:
  pelage check scenes/default.toml             size, hairs, memory, warnings
  pelage check scenes/default.toml --measure   the same, and the time that rendering takes
  pelage check scenes/default.toml --full > resolved.toml")]
pub(super) struct CheckArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Also print the resolved scene: every key with its value. The output is a scene file
    #[arg(long, conflicts_with = "json")]
    full: bool,
    /// Render a small picture on this adapter and estimate the time of the whole one
    #[arg(long)]
    measure: bool,
    /// Print all of it as JSON
    #[arg(long)]
    json: bool,
}

/// Expected counts, with the largest value of maps.
#[derive(Debug, Serialize)]
struct Counts {
    vertices: u64,
    triangles: u64,
    /// Meshes without fur.
    objects: u64,
    /// Triangles of all objects.
    object_triangles: u64,
    /// cm².
    area: f64,
    /// Size of the bounding box, cm.
    extent: [f32; 3],
    has_uv: bool,
    lights: u64,
    strands: u64,
    undercoat_hairs: u64,
    subelements: u64,
}

/// Expected GPU memory in bytes, without the tiles, which use the rest of the budget.
#[derive(Debug, Serialize)]
struct Bytes {
    skin: u64,
    /// Triangles of objects, their hierarchy, and the grid of the fur's extinction.
    objects: u64,
    strands: u64,
    undercoat: u64,
    lattice: u64,
    maps: u64,
    budget: u64,
}

// Estimated bytes: position, normal and colour of a vertex; indices, neighbours and prism corners
// of a triangle; packed density and tangent of a subelement.
const VERTEX: u64 = 48;
const TRIANGLE: u64 = 24 + 6 * 16;
// Three vertices, a record and nodes of the hierarchy of an object's triangle.
const OBJECT_TRIANGLE: u64 = 3 * 32 + 48 + 68;
const SUBELEMENT: u64 = 4;
/// The least that any adapter allows for a binding.
const BINDING: u64 = 128 << 20;
// Of up to four parts that choose a region of the mesh, at a corner or a vertex.
const COVERAGE: u64 = 8;

pub(super) fn run(args: &CheckArgs, global: &Global) -> Result<()> {
    let (scene, assets) = args.scene.load()?;
    let mut world = World::load(scene, &assets)?;
    output::admit(&mut world, true, global.quiet)?;
    let counts = counts(&world);
    let bytes = bytes(&world, &counts)?;
    let toml = toml::to_string(&world.scene)
        .map_err(|e| Error::Encoding(format!("the resolved scene cannot be written as TOML: {e}")))?;
    if args.json {
        let (scene, notes) = (output::to_json(&world.scene, "scene")?, world.notes.clone());
        let time = args.measure.then(|| measure(&mut world)).transpose()?;
        return output::print_json(&serde_json::json!({
            "scene": scene, "counts": counts, "bytes": bytes, "notes": notes, "time": time,
        }));
    }
    let mut text = summary(&world, &counts, &bytes);
    if args.measure {
        text += &measure(&mut world)?.text();
    } else {
        text += "time         not estimated: --measure renders a small picture to tell\n";
    }
    if args.full {
        text = text.lines().map(|line| format!("# {line}\n")).collect();
        text += &format!("\n{toml}");
    }
    output::print(&text)
}

fn counts(world: &World) -> Counts {
    let skin = &world.skin;
    let extent = Extent::of(world);
    let (lo, hi) = skin.bounds();
    Counts {
        vertices: skin.positions.len() as u64,
        triangles: skin.triangles.len() as u64,
        objects: world.objects.len() as u64,
        object_triangles: world.triangles() - skin.triangles.len() as u64,
        area: extent.area,
        extent: if skin.positions.is_empty() { [0.0; 3] } else { (hi - lo).into() },
        has_uv: skin.corner_uv.is_some(),
        lights: world.lights.len() as u64,
        strands: extent.guard_hairs.round() as u64,
        undercoat_hairs: extent.undercoat_hairs.round() as u64,
        subelements: extent.subelements,
    }
}

fn bytes(world: &World, counts: &Counts) -> Result<Bytes> {
    let segments = world.scene.coats().map(|coat| coat.guard.segments).max().unwrap_or(1);
    let lanes = world.scene.parts.iter().filter(|part| part.has_region()).count() as u64;
    let media = counts.subelements * SUBELEMENT;
    let stored = stores_undercoat(world, media, BINDING);
    Ok(Bytes {
        skin: counts.vertices * VERTEX + counts.triangles * TRIANGLE,
        objects: if counts.objects > 0 {
            counts.object_triangles * OBJECT_TRIANGLE + grid_bytes(world)
        } else {
            0
        },
        strands: counts.strands * strand_bytes(segments, false),
        undercoat: if stored { media } else { 0 },
        lattice: lattice_bytes(world)?,
        maps: world.maps.images.iter().map(|m| m.texels.len() as u64 * 16).sum::<u64>()
            + (3 * counts.triangles + counts.vertices) * COVERAGE * lanes.div_ceil(4),
        budget: world.scene.render.memory,
    })
}

/// The largest side of the body, cm.
fn largest_side(c: &Counts) -> f32 {
    c.extent.iter().copied().fold(0.0, f32::max)
}

/// The longest of a length of all coats, in cm, with its share of the body's largest side.
fn against_body<'a>(scene: &'a Scene, of: impl Fn(&Coat<'a>) -> &'a Scalar, c: &Counts) -> String {
    let longest = scene.coats().map(|coat| of(&coat).max()).fold(f32::NEG_INFINITY, f32::max);
    let everywhere = scene.coats().all(|coat| *of(&coat) == Scalar::Constant(longest));
    let up_to = if everywhere { "" } else { "up to " };
    let share = 100.0 * longest / largest_side(c);
    let share =
        if share.is_finite() { format!(", {share:.1} % of the body's largest side") } else { String::new() };
    format!("{up_to}{longest} cm{share}")
}

fn summary(world: &World, c: &Counts, b: &Bytes) -> String {
    let (scene, [x, y, z]) = (&world.scene, c.extent);
    let mut text = format!("body         {x:.2} x {y:.2} x {z:.2} cm, skin {:.1} cm²\n", c.area);
    if c.strands > 0 {
        let length = against_body(scene, |coat| &coat.guard.length, c);
        text += &format!("guard hairs  {}, {length}\n", count(c.strands));
    }
    if c.undercoat_hairs > 0 {
        let height = against_body(scene, |coat| &coat.undercoat.height, c);
        let hairs = count(c.undercoat_hairs);
        text += &format!("undercoat    {hairs} hairs in {} subelements, {height}\n", count(c.subelements));
    }
    let uv = if c.has_uv { "with uv" } else { "without uv: maps repeat every 10 cm" };
    text += &format!("mesh         {} triangles, {} vertices, {uv}\n", count(c.triangles), count(c.vertices));
    if c.objects > 0 {
        text += &format!("objects      {}, {} triangles\n", count(c.objects), count(c.object_triangles));
    }
    let film = &scene.film;
    let lights = count(c.lights);
    text += &format!(
        "picture      {} x {} pixels, {} samples each, {lights} lights\n",
        film.width, film.height, film.spp
    );
    let rows = [
        ("skin", b.skin),
        ("guard hairs", b.strands),
        ("undercoat", b.undercoat),
        ("light", b.lattice),
        ("maps", b.maps),
        ("objects", b.objects),
    ];
    let used = rows.iter().filter(|(_, bytes)| *bytes > 0);
    let parts: Vec<_> = used.map(|(name, bytes)| format!("{name} {}", human_bytes(*bytes))).collect();
    let total: u64 = rows.iter().map(|(_, bytes)| bytes).sum();
    let budget = human_bytes(b.budget);
    text += &format!("memory       {} of {budget} on the GPU: {}\n", human_bytes(total), parts.join(", "));
    if total > b.budget {
        text +=
            "             over the budget: guard hairs are grown again for each tile, undercoat densities\n";
        text += "             are evaluated while marching; slower, the same picture\n";
    }
    text
}

/// The time to expect, from a small picture.
#[derive(Debug, Serialize)]
struct Time {
    adapter: String,
    /// Preparation, which does not depend on the picture's size, s.
    preparation: f64,
    /// The whole picture, least and most, s.
    total: [f64; 2],
}

/// Samples of the picture that is measured.
const SAMPLES: f64 = 20_000.0;

/// Renders a picture of about [`SAMPLES`] samples. The rest of the picture costs at most as much
/// per sample, because passes over few samples are dominated by their start, and hardly less than
/// a third of it.
fn measure(world: &mut World) -> Result<Time> {
    let whole = world.scene.film.clone();
    let film = &mut world.scene.film;
    let shrink = (SAMPLES / (f64::from(whole.width) * f64::from(whole.height))).sqrt().min(1.0);
    let side = |pixels: u32| ((f64::from(pixels) * shrink).round() as u32).max(1);
    (film.width, film.height, film.spp) = (side(whole.width), side(whole.height), 1);
    let samples = |f: &pelage::scene::FilmSpec| f64::from(f.width) * f64::from(f.height) * f64::from(f.spp);
    let ratio = samples(&whole) / samples(film);
    let stats = render::render(world, &RenderOptions::default())?.stats;
    world.scene.film = whole;
    // Steps 4 to 7 run for every tile.
    let tiles: f64 = stats.steps.iter().filter(|s| s.step >= 4).filter_map(|s| s.ms).sum::<f64>() / 1000.0;
    let preparation = (stats.total_ms / 1000.0 - tiles).max(0.0);
    let total = [0.8 * preparation + 0.3 * tiles * ratio, 1.3 * (preparation + tiles * ratio)];
    Ok(Time { adapter: stats.adapter, preparation, total })
}

impl Time {
    fn text(&self) -> String {
        let [least, most] = self.total.map(human_time);
        let preparation = human_time(self.preparation);
        format!(
            "time         {least} to {most} on {} ({preparation} of it before the first tile)\n",
            self.adapter
        )
    }
}

fn human_time(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
