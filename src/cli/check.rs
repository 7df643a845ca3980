//! `pelage check`: the resolved scene, with expected counts and memory.

use super::Global;
use super::args::SceneArgs;
use super::output::{self, count, human_bytes};
use clap::Args;
use pelage::scene::{FurLayers, Storage};
use pelage::{Error, Result, Scene, World};
use serde::Serialize;

#[derive(Debug, Args)]
pub(super) struct CheckArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

/// Expected counts, with the largest value of maps.
#[derive(Debug, Serialize)]
struct Counts {
    vertices: u64,
    triangles: u64,
    /// cm².
    area: f64,
    /// Size of the bounding box, cm.
    extent: [f32; 3],
    has_uv: bool,
    lights: u64,
    strands: u64,
    subelements: u64,
}

/// Expected GPU memory in bytes, without the tiles, which use the rest of the budget.
#[derive(Debug, Serialize)]
struct Bytes {
    skin: u64,
    strands: u64,
    undercoat: u64,
    maps: u64,
    budget: u64,
}

// Estimated bytes: position, normal and colour of a vertex; indices, neighbours and prism corners
// of a triangle; root and segment vertices of a strand; packed density and tangent of a subelement.
const VERTEX: u64 = 48;
const TRIANGLE: u64 = 24 + 6 * 16;
const ROOT: u64 = 48;
const SEGMENT_VERTEX: u64 = 32;
const SUBELEMENT: u64 = 4;
// Of up to four parts that choose groups or materials, at a corner or a vertex.
const COVERAGE: u64 = 8;

pub(super) fn run(args: &CheckArgs, global: &Global) -> Result<()> {
    let (scene, assets) = args.scene.load()?;
    let world = World::load(scene, &assets)?;
    output::print_notes(&world.skin, global.quiet);
    let counts = counts(&world);
    let bytes = bytes(&world, &counts);
    if args.json {
        let notes = &world.skin.notes;
        return output::print_json(&serde_json::json!({
            "scene": world.scene, "counts": counts, "bytes": bytes, "notes": notes,
        }));
    }
    output::print(&text(&world.scene, &counts, &bytes)?)
}

fn counts(world: &World) -> Counts {
    let (scene, skin) = (&world.scene, &world.skin);
    let area = skin.area();
    let guard = matches!(scene.render.fur, FurLayers::Explicit | FurLayers::Hybrid);
    let undercoat = matches!(scene.render.fur, FurLayers::Implicit | FurLayers::Hybrid);
    let (lo, hi) = skin.bounds();
    Counts {
        vertices: skin.positions.len() as u64,
        triangles: skin.triangles.len() as u64,
        area,
        extent: if skin.positions.is_empty() { [0.0; 3] } else { (hi - lo).into() },
        has_uv: skin.corner_uv.is_some(),
        lights: world.lights.len() as u64,
        strands: if guard { expected_strands(scene, area) } else { 0 },
        subelements: if undercoat { subelements(world) } else { 0 },
    }
}

fn expected_strands(scene: &Scene, area: f64) -> u64 {
    let density = scene.largest(|coat| coat.guard.density.max()).max(0.0);
    (area * f64::from(density)).round() as u64
}

/// Layers times 4^d, with d from the longest edge if the scene does not set it.
fn subelements(world: &World) -> u64 {
    let undercoat = &world.scene.undercoat;
    let layers = u64::from(undercoat.layers);
    let level = |t: usize| match undercoat.subdivision {
        Some(d) => d,
        None => {
            let [a, b, c] = world.skin.corners(t);
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            (longest / undercoat.cell).log2().ceil().clamp(0.0, 7.0) as u32
        }
    };
    (0..world.skin.triangles.len()).map(|t| layers << (2 * level(t))).sum()
}

fn bytes(world: &World, counts: &Counts) -> Bytes {
    let segments = world.scene.coats().map(|coat| u64::from(coat.guard.segments)).max().unwrap_or(1);
    let lanes = world.scene.parts.iter().filter(|part| part.has_sections()).count() as u64;
    let stored = world.scene.undercoat.storage != Storage::Evaluated;
    Bytes {
        skin: counts.vertices * VERTEX + counts.triangles * TRIANGLE,
        strands: counts.strands * (ROOT + (segments + 1) * SEGMENT_VERTEX),
        undercoat: if stored { counts.subelements * SUBELEMENT } else { 0 },
        maps: world.maps.images.iter().map(|m| m.texels.len() as u64 * 16).sum::<u64>()
            + (3 * counts.triangles + counts.vertices) * COVERAGE * lanes.div_ceil(4),
        budget: world.scene.render.memory,
    }
}

fn text(scene: &Scene, c: &Counts, b: &Bytes) -> Result<String> {
    let toml = toml::to_string(scene)
        .map_err(|e| Error::Encoding(format!("the resolved scene cannot be written as TOML: {e}")))?;
    let mut text = toml;
    text += "\n# Expected counts\n";
    text += &format!("# triangles    {} ({} vertices)\n", count(c.triangles), count(c.vertices));
    text += &format!("# area         {:.1} cm²\n", c.area);
    text += &format!("# extent       {:.2} x {:.2} x {:.2} cm\n", c.extent[0], c.extent[1], c.extent[2]);
    text += &format!("# uv           {}\n", if c.has_uv { "yes" } else { "no: maps are sampled triplanar" });
    text += &format!("# lights       {}\n", count(c.lights));
    text += &format!("# strands      {} expected\n", count(c.strands));
    text += &format!("# subelements  {}\n", count(c.subelements));
    text += "\n# Estimated GPU memory\n";
    let rows = [("skin", b.skin), ("strands", b.strands), ("undercoat", b.undercoat), ("maps", b.maps)];
    for (name, bytes) in rows {
        text += &format!("# {name:<12} {}\n", human_bytes(bytes));
    }
    let fixed = b.skin + b.strands + b.undercoat + b.maps;
    text += &format!("# total        {} of a budget of {}\n", human_bytes(fixed), human_bytes(b.budget));
    if fixed > b.budget {
        text += "# over the budget: strands are generated in batches, undercoat densities are evaluated while marching\n";
    }
    Ok(text)
}
