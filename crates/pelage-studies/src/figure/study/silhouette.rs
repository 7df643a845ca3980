//! Edges at and near the silhouette, as the rasteriser finds them, and the fins extruded from them;
//! and shells offset from a mesh.

use super::super::{FigureContent, FigureContext};
use super::canvas::{Canvas, shade};
use bytemuck::Zeroable;
use glam::{Vec2, Vec3};
use pelage_core::skin::NONE;
use pelage_core::{Error, Result, World};
use pelage_fur::layout::{FinEdge, ShellVertex, Shellfin};
use pelage_fur::random::{hash2, random};
use pelage_shells::bake::{self, FurTextures};
use pelage_shells::shellfin::edges;
use pelage_shells::twin::shellfin_raster::fin_fade;
use serde::Deserialize;

const ORANGE: Vec3 = Vec3::new(1.0, 0.22, 0.0);
const YELLOW: Vec3 = Vec3::new(0.95, 0.62, 0.02);
const BLUE: Vec3 = Vec3::new(0.02, 0.2, 0.6);
const GREY: Vec3 = Vec3::new(0.62, 0.63, 0.65);
const LINES: Vec3 = Vec3::new(0.32, 0.33, 0.35);

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// Scene file, relative to the figure's folder.
    scene: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ShellSettings {
    /// Scene file, relative to the figure's folder.
    scene: String,
    /// Number of shells that are drawn.
    shells: u32,
    /// The fin is drawn on the edge whose midpoint is nearest to this point, cm.
    fin_at: [f32; 3],
}

/// Edges at the silhouette, and their fins.
pub(super) fn make(context: &FigureContext) -> Result<FigureContent> {
    let settings: Settings = context.settings()?;
    let (world, _) = context.load(&settings.scene, &[])?;
    let textures = bake::bake(&world)?;
    let threshold = world.scene.shells.fin_threshold;
    let eye = Vec3::from(world.scene.camera.eye);
    let vertices = vertices(&world);
    let all = edges(&world.skin);
    let within = |threshold: f32| {
        let shellfin = Shellfin { fade: 1, fin_threshold: threshold, ..Shellfin::zeroed() };
        all.iter().filter(|e| fin_fade(&shellfin, &vertices, e, eye) > 0.0).copied().collect::<Vec<_>>()
    };
    // A cosine is never below zero, so that only edges on the silhouette are left.
    let (on, near) = (within(0.0), within(threshold));

    let mut content = FigureContent::default();
    let mut canvas = Canvas::new(&world.scene.camera, context.size());
    mesh(&mut canvas, &world, 0.5);
    strokes(&mut canvas, &world, &near, YELLOW);
    strokes(&mut canvas, &world, &on, ORANGE);
    content.picture("silhouette edges", canvas.film());

    let mut canvas = Canvas::new(&world.scene.camera, context.size());
    mesh(&mut canvas, &world, 0.5);
    for edge in &near {
        fin(&mut canvas, &world, &textures, edge, None);
    }
    for edge in &on {
        fin(&mut canvas, &world, &textures, edge, Some(ORANGE));
    }
    content.picture("extruded to fins", canvas.film());
    content.value("edges", all.len() as f64, 0.0);
    content.value("edges on the silhouette", on.len() as f64, 2.0);
    content.value("edges with fins", near.len() as f64, 2.0);
    content.text = format!(
        "{} edges; {} lie on the silhouette, {} on it or with a face whose normal is within a cosine of {threshold} of square to the view.\n",
        all.len(),
        on.len(),
        near.len()
    );
    Ok(content)
}

/// A mesh, shells offset from it, and one fin.
pub(super) fn shells(context: &FigureContext) -> Result<FigureContent> {
    let settings: ShellSettings = context.settings()?;
    let (world, _) = context.load(&settings.scene, &[])?;
    let textures = bake::bake(&world)?;
    let skin = &world.skin;
    let height = textures.manifest.height;
    let at = |v: u32, height: f32| skin.positions[v as usize] + height * skin.normals[v as usize];
    let middle = |e: &FinEdge| 0.5 * (at(e.a, 0.0) + at(e.b, 0.0));
    let to = |e: &FinEdge| middle(e).distance(settings.fin_at.into());
    let all = edges(skin);
    let edge = all
        .iter()
        .min_by(|a, b| to(a).total_cmp(&to(b)))
        .ok_or_else(|| Error::Unsupported("the skin has no edges".into()))?;
    let mut content = FigureContent::default();
    for (label, shells, with_fin) in
        [("mesh", 0, false), ("offset shells", settings.shells, false), ("extruded fin", 0, true)]
    {
        let mut canvas = Canvas::new(&world.scene.camera, context.size());
        mesh(&mut canvas, &world, 1.2);
        if with_fin {
            fin(&mut canvas, &world, &textures, edge, Some(ORANGE));
        }
        for k in 1..=shells {
            let h = height * k as f32 / shells as f32;
            for t in &skin.triangles {
                canvas.veil(t.map(|v| at(v, h)), BLUE, 0.12);
            }
            for e in &all {
                // Borders stand out from the edges between triangles.
                let (pale, width) = if e.opposite[1] == NONE { (0.2, 1.4) } else { (0.75, 0.6) };
                canvas.line([at(e.a, h), at(e.b, h)], BLUE.lerp(Vec3::ONE, pale), width, 0.0);
            }
        }
        content.picture(label, canvas.film());
    }
    content.value("triangles", skin.triangles.len() as f64, 0.0);
    content.value("edges", all.len() as f64, 0.0);
    Ok(content)
}

fn vertices(world: &World) -> Vec<ShellVertex> {
    let pairs = world.skin.positions.iter().zip(&world.skin.normals);
    pairs
        .map(|(p, n)| ShellVertex { position: (*p).into(), normal: (*n).into(), ..ShellVertex::zeroed() })
        .collect()
}

/// The skin, flat shaded, with its edges.
fn mesh(canvas: &mut Canvas, world: &World, width: f32) {
    let skin = &world.skin;
    for t in 0..skin.triangles.len() {
        let corners = skin.corners(t);
        let light = shade(corners, canvas.eye());
        canvas.triangle(corners, GREY * light);
    }
    let nearer = 0.004 * bake::diameter(skin);
    for e in edges(skin) {
        let ends = [e.a, e.b].map(|v| skin.positions[v as usize]);
        canvas.line(ends, LINES, width, nearer);
    }
}

fn strokes(canvas: &mut Canvas, world: &World, edges: &[FinEdge], color: Vec3) {
    let nearer = 0.012 * bake::diameter(&world.skin);
    for e in edges {
        let ends = [e.a, e.b].map(|v| world.skin.positions[v as usize]);
        canvas.line(ends, color, 2.2, nearer);
    }
}

/// A fin with the texture coordinates that the rasteriser gives it; with `outline` also the edges
/// of its two triangles.
fn fin(canvas: &mut Canvas, world: &World, textures: &FurTextures, edge: &FinEdge, outline: Option<Vec3>) {
    let skin = &world.skin;
    let height = textures.manifest.height;
    let at = |v: u32, height: f32| skin.positions[v as usize] + height * skin.normals[v as usize];
    let [a, b, c, d] = [at(edge.a, 0.0), at(edge.b, 0.0), at(edge.b, height), at(edge.a, height)];
    let first = random(hash2(edge.a, edge.b), 0);
    let last = first + a.distance(b) / textures.manifest.fin_length;
    let corners = [
        (a, Vec2::new(first, 0.0)),
        (b, Vec2::new(last, 0.0)),
        (c, Vec2::new(last, 1.0)),
        (d, Vec2::new(first, 1.0)),
    ];
    canvas.quad(corners, &textures.fin, false);
    if let Some(color) = outline {
        let nearer = 0.006 * bake::diameter(skin);
        for line in [[a, b], [b, c], [c, d], [d, a], [a, c]] {
            canvas.line(line, color, 1.1, nearer);
        }
    }
}
