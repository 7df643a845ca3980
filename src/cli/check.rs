//! `pelage check`: the resolved scene, with expected counts and memory.

use super::Global;
use super::args::SceneArgs;
use super::output::{self, count, human_bytes};
use clap::Args;
use pelage::scene::{FurLayers, Scalar, Storage};
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
    maps: u64,
    budget: u64,
}

// Estimated bytes: position, normal and colour of a vertex; indices, neighbours and prism corners
// of a triangle; root and segment vertices of a strand; packed density and tangent of a subelement.
const VERTEX: u64 = 48;
const TRIANGLE: u64 = 24 + 6 * 16;
// Three vertices, a record and nodes of the hierarchy of an object's triangle.
const OBJECT_TRIANGLE: u64 = 3 * 32 + 48 + 68;
const ROOT: u64 = 48;
const SEGMENT_VERTEX: u64 = 32;
const SUBELEMENT: u64 = 4;

pub(super) fn run(args: &CheckArgs, global: &Global) -> Result<()> {
    let (scene, assets) = args.scene.load()?;
    let world = World::load(scene, &assets)?;
    output::print_notes(world.mesh_notes(), global.quiet);
    let counts = counts(&world);
    let bytes = bytes(&world, &counts);
    if args.json {
        let notes: Vec<&String> = world.mesh_notes().collect();
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
        objects: world.objects.len() as u64,
        object_triangles: world.triangles() - skin.triangles.len() as u64,
        area,
        extent: if skin.positions.is_empty() { [0.0; 3] } else { (hi - lo).into() },
        has_uv: skin.corner_uv.is_some(),
        lights: world.lights.len() as u64,
        strands: if guard { expected_strands(&scene.guard.density, area) } else { 0 },
        subelements: if undercoat { subelements(world) } else { 0 },
    }
}

fn expected_strands(density: &Scalar, area: f64) -> u64 {
    (area * f64::from(density.max().max(0.0))).round() as u64
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
    let segments = u64::from(world.scene.guard.segments);
    let stored = world.scene.undercoat.storage != Storage::Evaluated;
    Bytes {
        skin: counts.vertices * VERTEX + counts.triangles * TRIANGLE,
        objects: if counts.objects > 0 {
            counts.object_triangles * OBJECT_TRIANGLE + pelage::render::fur_grid_bytes(world)
        } else {
            0
        },
        strands: counts.strands * (ROOT + (segments + 1) * SEGMENT_VERTEX),
        undercoat: if stored { counts.subelements * SUBELEMENT } else { 0 },
        maps: world.maps.images.iter().map(|m| m.texels.len() as u64 * 16).sum(),
        budget: world.scene.render.memory,
    }
}

fn text(scene: &Scene, c: &Counts, b: &Bytes) -> Result<String> {
    let toml = toml::to_string(scene)
        .map_err(|e| Error::Encoding(format!("the resolved scene cannot be written as TOML: {e}")))?;
    let mut text = toml;
    text += "\n# Expected counts\n";
    text += &format!("# triangles    {} ({} vertices)\n", count(c.triangles), count(c.vertices));
    if c.objects > 0 {
        let objects = format!("{} of {} triangles", count(c.objects), count(c.object_triangles));
        text += &format!("# objects      {objects}\n");
    }
    text += &format!("# area         {:.1} cm²\n", c.area);
    text += &format!("# extent       {:.2} x {:.2} x {:.2} cm\n", c.extent[0], c.extent[1], c.extent[2]);
    text += &format!("# uv           {}\n", if c.has_uv { "yes" } else { "no: maps are sampled triplanar" });
    text += &format!("# lights       {}\n", count(c.lights));
    text += &format!("# strands      {} expected\n", count(c.strands));
    text += &format!("# subelements  {}\n", count(c.subelements));
    text += "\n# Estimated GPU memory\n";
    let rows = [
        ("skin", b.skin),
        ("objects", b.objects),
        ("strands", b.strands),
        ("undercoat", b.undercoat),
        ("maps", b.maps),
    ];
    for (name, bytes) in rows.into_iter().filter(|(name, _)| *name != "objects" || c.objects > 0) {
        text += &format!("# {name:<12} {}\n", human_bytes(bytes));
    }
    let fixed = b.skin + b.objects + b.strands + b.undercoat + b.maps;
    text += &format!("# total        {} of a budget of {}\n", human_bytes(fixed), human_bytes(b.budget));
    if fixed > b.budget {
        text += "# over the budget: strands are generated in batches, undercoat densities are evaluated while marching\n";
    }
    Ok(text)
}
